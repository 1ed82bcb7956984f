// SPDX-License-Identifier: GPL-3.0-or-later
// Random expressions, and their values by plain recursion, which shares no code with the tape.
#pragma once

#include <graze/lib/equations/expression.hpp>
#include <graze/lib/equations/parse.hpp>
#include <graze/lib/numerics/vector.hpp>

#include <cmath>
#include <numbers>
#include <random>

namespace graze::support {

struct Point {
  long double t = 0.0L;
  std::vector<long double> x, p;
};

/// The value of an expression, by recursion, in long double.
inline long double value(const equations::Graph& graph, equations::Expression e, const Point& at) {
  using enum equations::Operation;
  const equations::Node& n = graph.node(e);
  const int count = equations::operands(n.operation);
  const long double a = count > 0 ? value(graph, n.a, at) : 0.0L, b = count > 1 ? value(graph, n.b, at) : 0.0L;
  switch (n.operation) {
  case constant:
    return n.value;
  case pi:
    return std::numbers::pi_v<long double>;
  case state:
    return at.x[n.index];
  case parameter:
    return at.p[n.index];
  case time:
    return at.t;
  case add:
    return a + b;
  case subtract:
    return a - b;
  case multiply:
    return a * b;
  case divide:
    return a / b;
  case negate:
    return -a;
  case integer_power:
    return std::pow(a, static_cast<long double>(n.value));
  case power:
    return std::pow(a, b);
  case contact_power:
    return a > 0 ? std::pow(a, static_cast<long double>(n.value)) : 0.0L;
  case sin:
    return std::sin(a);
  case cos:
    return std::cos(a);
  case tan:
    return std::tan(a);
  case asin:
    return std::asin(a);
  case acos:
    return std::acos(a);
  case atan:
    return std::atan(a);
  case atan2:
    return std::atan2(a, b);
  case sinh:
    return std::sinh(a);
  case cosh:
    return std::cosh(a);
  case tanh:
    return std::tanh(a);
  case exp:
    return std::exp(a);
  case log:
    return std::log(a);
  case sqrt:
    return std::sqrt(a);
  case hypot:
    return std::hypot(a, b);
  case spline:
    return graph.splines()[n.index].value(static_cast<int>(n.value), a);
  case abs:
    return std::fabs(a);
  case sign:
    return a > 0 ? 1.0L : a < 0 ? -1.0L : 0.0L;
  case max:
    return std::max(a, b);
  case min:
    return std::min(a, b);
  case step:
    return a >= 0 ? 1.0L : 0.0L;
  case rate:
    break;
  }
  return std::nanl("");
}

/// Smooth expressions in 2 states, 2 parameters and time. They are defined and of moderate size if all of these lie in (0.2,
/// 1.2).
class RandomExpressions {
 public:
  RandomExpressions(equations::Graph& graph, unsigned seed) : graph_(graph), engine_(seed) {}

  equations::Expression operator()(int depth) {
    using enum equations::Operation;
    if (depth == 0) return leaf();
    const auto inner = [&] { return (*this)(depth - 1); };
    // Between -1 and 1, and at least 1/2.
    const auto small = [&] { return graph_.function(sin, inner()); };
    const auto positive = [&] { return graph_.add(graph_.constant(1.5), small()); };
    switch (engine_() % 24) {
    case 0:
    case 1:
    case 2:
      return graph_.add(inner(), inner());
    case 3:
    case 4:
      return graph_.subtract(inner(), inner());
    case 5:
    case 6:
    case 7:
      return graph_.multiply(small(), inner());
    case 8:
      return graph_.divide(inner(), positive());
    case 9:
      return graph_.negate(inner());
    case 10:
      return graph_.integer_power(positive(), static_cast<int>(engine_() % 9) - 4);
    case 11:
      return graph_.power(positive(), small());
    case 12:
      return graph_.power(positive(), graph_.divide(graph_.constant(1.0), graph_.constant(3.0)));
    case 13:
      return graph_.contact_power(positive(), 1.5);
    case 14:
      return graph_.function(tan, small());
    case 15:
      return graph_.function(asin, graph_.multiply(graph_.constant(0.75), small()));
    case 16:
      return graph_.function(acos, graph_.multiply(graph_.constant(0.75), small()));
    case 17:
      return graph_.function(atan2, inner(), positive());
    case 18:
      return graph_.function(engine_() % 2 ? sinh : cosh, small());
    case 19:
      return graph_.function(engine_() % 2 ? tanh : atan, inner());
    case 20:
      return graph_.function(exp, small());
    case 21:
      return graph_.function(engine_() % 2 ? log : sqrt, positive());
    case 22:
      return graph_.function(hypot, positive(), inner());
    default:
      return graph_.function(engine_() % 2 ? cos : sin, inner());
    }
  }

  Point point() {
    std::uniform_real_distribution<double> any(0.2, 1.2);
    Point out{any(engine_), {}, {}};
    for (int i = 0; i < 2; ++i) {
      out.x.push_back(any(engine_));
      out.p.push_back(any(engine_));
    }
    return out;
  }

 private:
  equations::Expression leaf() {
    switch (engine_() % 8) {
    case 0:
    case 1:
    case 2:
      return graph_.state(engine_() % 2);
    case 3:
    case 4:
      return graph_.parameter(engine_() % 2);
    case 5:
      return graph_.time();
    case 6:
      return graph_.pi();
    default:
      return graph_.constant(static_cast<double>(engine_() % 7) / 2.0 - 1.0);
    }
  }

  equations::Graph& graph_;
  std::mt19937 engine_;
};

/// Names for 2 states and 2 parameters.
inline equations::Symbols two_and_two() { return {{"x", "v"}, {"a", "b"}}; }
inline equations::Scope two_and_two_scope(equations::Graph& graph) {
  equations::Scope scope;
  scope.names = {"x", "v", "a", "b"};
  scope.find = [&graph](std::string_view name) -> std::optional<equations::Expression> {
    if (name == "x") return graph.state(0);
    if (name == "v") return graph.state(1);
    if (name == "a") return graph.parameter(0);
    if (name == "b") return graph.parameter(1);
    return std::nullopt;
  };
  return scope;
}
inline equations::Expression read(equations::Graph& graph, const std::string& text) {
  const equations::Source source{"text", text};
  const equations::Text whole{text, {1, 1, text.size()}};
  return equations::parse_expression(graph, source, whole, two_and_two_scope(graph), "in the test");
}

}  // namespace graze::support
