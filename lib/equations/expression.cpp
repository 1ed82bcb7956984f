// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/expression.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

namespace graze::equations {

using enum Operation;

namespace {

/// A graph of this size takes several hundred megabytes; only derivatives that explode need more.
constexpr std::size_t most_nodes = 4'000'000;
/// Larger integer exponents are evaluated with pow().
constexpr double largest_integer_power = 64.0;

/// The result if it is exact (and normal); otherwise nothing.
std::optional<double> exact_sum(double a, double b) {
  const double sum = a + b, part = sum - a;
  if (!std::isfinite(sum) || (a - (sum - part)) + (b - part) != 0.0) return std::nullopt;
  return sum;
}
std::optional<double> exact_product(double a, double b) {
  const double product = a * b;
  if (a == 0.0 || b == 0.0) return 0.0;
  // Below this the rounding error itself underflows.
  if (!std::isfinite(product) || std::abs(product) < 1e-290 || std::fma(a, b, -product) != 0.0) return std::nullopt;
  return product;
}
std::optional<double> exact_quotient(double a, double b) {
  if (b == 0.0) return std::nullopt;
  if (a == 0.0) return 0.0;
  const double quotient = a / b;
  if (!std::isfinite(quotient) || std::abs(quotient) < 1e-290 || std::fma(quotient, b, -a) != 0.0) return std::nullopt;
  return quotient;
}

std::optional<double> exact_power(double a, int n) {
  double value = 1.0;
  for (int i = 0; i < std::abs(n); ++i) {
    const auto next = exact_product(value, a);
    if (!next) return std::nullopt;
    value = *next;
  }
  return n < 0 ? exact_quotient(1.0, value) : value;
}

/// Values of functions that are exact.
std::optional<double> exact_value(Operation operation, double a) {
  switch (operation) {
  case sin:
  case tan:
  case asin:
  case atan:
  case sinh:
  case tanh:
    return a == 0.0 ? std::optional(0.0) : std::nullopt;
  case cos:
  case cosh:
  case exp:
    return a == 0.0 ? std::optional(1.0) : std::nullopt;
  case log:
  case acos:
    return a == 1.0 ? std::optional(0.0) : std::nullopt;
  case sqrt: {
    const double root = a >= 0.0 ? std::sqrt(a) : std::numeric_limits<double>::quiet_NaN();
    return exact_product(root, root) == a ? std::optional(root) : std::nullopt;
  }
  case abs:
    return std::abs(a);
  case sign:
    return a > 0.0 ? 1.0 : a < 0.0 ? -1.0 : 0.0;
  case step:
    return a >= 0.0 ? 1.0 : 0.0;
  default:
    return std::nullopt;
  }
}

}  // namespace

int operands(Operation operation) {
  switch (operation) {
  case constant:
  case pi:
  case state:
  case parameter:
  case time:
    return 0;
  case add:
  case subtract:
  case multiply:
  case divide:
  case power:
  case atan2:
  case hypot:
  case max:
  case min:
    return 2;
  default:
    return 1;
  }
}

std::size_t Graph::Hash::operator()(const Node& node) const {
  std::uint64_t h = static_cast<std::uint64_t>(node.operation) * 0x9E3779B97F4A7C15U;
  for (const std::uint64_t part : {static_cast<std::uint64_t>(node.index), static_cast<std::uint64_t>(node.a.index),
                                   static_cast<std::uint64_t>(node.b.index), std::bit_cast<std::uint64_t>(node.value)}) {
    h = (h ^ part) * 0xFF51AFD7ED558CCDU;
    h ^= h >> 32U;
  }
  return static_cast<std::size_t>(h);
}

Graph::Graph() { constant(0.0); }

Expression Graph::intern(const Node& node) {
  const auto [found, is_new] = index_.try_emplace(node, static_cast<std::uint32_t>(nodes_.size()));
  if (is_new) {
    if (nodes_.size() >= most_nodes)
      throw std::invalid_argument(fmt::format("the equations and their derivatives have more than {} parts", most_nodes));
    nodes_.push_back(node);
  }
  return {found->second};
}

bool Graph::is_constant(Expression e, double value) const {
  const Node& n = node(e);
  return n.operation == Operation::constant && n.value == value;
}

Expression Graph::constant(double value) { return intern({.operation = Operation::constant, .value = value + 0.0}); }
Expression Graph::pi() { return intern({.operation = Operation::pi}); }
Expression Graph::state(std::size_t i) { return intern({.operation = Operation::state, .index = static_cast<std::uint32_t>(i)}); }
Expression Graph::parameter(std::size_t i) {
  return intern({.operation = Operation::parameter, .index = static_cast<std::uint32_t>(i)});
}
Expression Graph::time() { return intern({.operation = Operation::time}); }

Expression Graph::add(Expression a, Expression b) {
  if (b < a) std::swap(a, b);
  if (node(a).operation == Operation::constant) std::swap(a, b);
  const Node p = node(a), q = node(b);
  if (is_constant(a, 0.0)) return b;
  if (is_constant(b, 0.0)) return a;
  if (p.operation == Operation::constant && q.operation == Operation::constant)
    if (const auto sum = exact_sum(p.value, q.value)) return constant(*sum);
  if (a == b) return multiply(constant(2.0), a);
  if (q.operation == Operation::negate) return subtract(a, q.a);
  if (p.operation == Operation::negate) return subtract(b, p.a);
  return intern({.operation = Operation::add, .a = a, .b = b});
}

Expression Graph::subtract(Expression a, Expression b) {
  const Node p = node(a), q = node(b);
  if (a == b) return constant(0.0);
  if (is_constant(b, 0.0)) return a;
  if (is_constant(a, 0.0)) return negate(b);
  if (p.operation == Operation::constant && q.operation == Operation::constant)
    if (const auto difference = exact_sum(p.value, -q.value)) return constant(*difference);
  if (q.operation == Operation::negate) return add(a, q.a);
  if (q.operation == Operation::constant && q.value < 0.0) return add(a, constant(-q.value));
  return intern({.operation = Operation::subtract, .a = a, .b = b});
}

Expression Graph::negate(Expression a) {
  const Node p = node(a);
  if (p.operation == Operation::constant) return constant(-p.value);
  if (p.operation == Operation::negate) return p.a;
  if (p.operation == Operation::subtract) return subtract(p.b, p.a);
  return intern({.operation = Operation::negate, .a = a});
}

Expression Graph::multiply(Expression a, Expression b) {
  if (b < a) std::swap(a, b);
  if (node(b).operation == Operation::constant) std::swap(a, b);
  const Node p = node(a), q = node(b);
  if (is_constant(a, 0.0) || is_constant(b, 0.0)) return constant(0.0);
  if (is_constant(a, 1.0)) return b;
  if (is_constant(b, 1.0)) return a;
  if (p.operation == Operation::constant && q.operation == Operation::constant)
    if (const auto product = exact_product(p.value, q.value)) return constant(*product);
  if (p.operation == Operation::negate) return negate(multiply(p.a, b));
  if (q.operation == Operation::negate) return negate(multiply(a, q.a));
  if (p.operation == Operation::constant && p.value < 0.0) return negate(multiply(constant(-p.value), b));
  if (q.operation == Operation::constant && q.value < 0.0) return negate(multiply(a, constant(-q.value)));
  if (a == b) return integer_power(a, 2);
  // x^n x becomes x^(n+1). The reverse would change the rounding.
  const auto raised = [&](const Node& n, Expression other) {
    return n.operation == Operation::integer_power && n.a == other && n.value >= 2.0 && n.value < largest_integer_power;
  };
  if (raised(p, b)) return integer_power(b, static_cast<int>(p.value) + 1);
  if (raised(q, a)) return integer_power(a, static_cast<int>(q.value) + 1);
  return intern({.operation = Operation::multiply, .a = a, .b = b});
}

Expression Graph::divide(Expression a, Expression b) {
  const Node p = node(a), q = node(b);
  if (is_constant(b, 1.0)) return a;
  if (q.operation != Operation::constant || q.value != 0.0) {
    if (is_constant(a, 0.0)) return a;
    if (a == b) return constant(1.0);
  }
  if (p.operation == Operation::constant && q.operation == Operation::constant)
    if (const auto quotient = exact_quotient(p.value, q.value)) return constant(*quotient);
  if (p.operation == Operation::negate) return negate(divide(p.a, b));
  if (q.operation == Operation::negate) return negate(divide(a, q.a));
  if (q.operation == Operation::constant && q.value < 0.0) return negate(divide(a, constant(-q.value)));
  if (p.operation == Operation::constant && p.value < 0.0) return negate(divide(constant(-p.value), b));
  return intern({.operation = Operation::divide, .a = a, .b = b});
}

Expression Graph::integer_power(Expression a, int n) {
  if (n == 0) return constant(1.0);
  if (n == 1) return a;
  const Node p = node(a);
  if (p.operation == Operation::constant)
    if (const auto value = exact_power(p.value, n)) return constant(*value);
  if (p.operation == Operation::negate) {
    const Expression even = integer_power(p.a, n);
    return n % 2 == 0 ? even : negate(even);
  }
  if (p.operation == Operation::integer_power && std::abs(p.value * n) <= largest_integer_power)
    return integer_power(p.a, static_cast<int>(p.value) * n);
  if (p.operation == Operation::sqrt && n > 1) return n % 2 == 0 ? integer_power(p.a, n / 2) : power(p.a, constant(0.5 * n));
  return intern({.operation = Operation::integer_power, .a = a, .value = static_cast<double>(n)});
}

Expression Graph::power(Expression a, Expression b) {
  const Node q = node(b);
  if (is_constant(a, 1.0)) return a;
  if (q.operation == Operation::constant) {
    if (std::abs(q.value) <= largest_integer_power && q.value == std::nearbyint(q.value))
      return integer_power(a, static_cast<int>(q.value));
    if (q.value == 0.5) return function(Operation::sqrt, a);
    if (is_constant(a, 0.0) && q.value > 0.0) return a;
  }
  return intern({.operation = Operation::power, .a = a, .b = b});
}

Expression Graph::contact_power(Expression a, double exponent) {
  const Node p = node(a);
  if (p.operation == Operation::constant && p.value <= 0.0) return constant(0.0);
  return intern({.operation = Operation::contact_power, .a = a, .value = exponent});
}

Expression Graph::rate(Expression a) {
  const Node p = node(a);
  if (p.operation == Operation::constant || p.operation == Operation::pi || p.operation == Operation::parameter)
    return constant(0.0);
  if (p.operation == Operation::time) return constant(1.0);
  return intern({.operation = Operation::rate, .a = a});
}

Expression Graph::spline(std::size_t table, Expression a, int order) {
  if (order > 3) return constant(0.0);
  return intern(
      {.operation = Operation::spline, .index = static_cast<std::uint32_t>(table), .a = a, .value = static_cast<double>(order)});
}

std::size_t Graph::add_table(Table table) {
  splines_.push_back(make_spline(std::move(table)));
  return splines_.size() - 1;
}

Expression Graph::function(Operation operation, Expression a, Expression b) {
  const Node p = node(a);
  if (operands(operation) == 1) {
    if (p.operation == Operation::constant)
      if (const auto value = exact_value(operation, p.value)) return constant(*value);
    if (p.operation == Operation::negate) {
      switch (operation) {
      case sin:
      case tan:
      case asin:
      case atan:
      case sinh:
      case tanh:
      case sign:
        return negate(function(operation, p.a));
      case cos:
      case cosh:
      case abs:
        return function(operation, p.a);
      default:
        break;
      }
    }
    return intern({.operation = operation, .a = a});
  }
  if (operation == max || operation == min) {
    if (a == b) return a;
    const Node q = node(b);
    if (p.operation == Operation::constant && q.operation == Operation::constant)
      return (p.value < q.value) == (operation == max) ? b : a;
  }
  if (operation == atan2 && p.operation == Operation::constant && p.value == 0.0)
    return multiply(pi(), subtract(constant(1.0), function(step, b)));
  if ((operation == max || operation == min || operation == hypot) && b < a) std::swap(a, b);
  return intern({.operation = operation, .a = a, .b = b});
}

Expression Graph::with_operands(const Node& n, Expression a, Expression b) {
  switch (n.operation) {
  case Operation::constant:
  case Operation::pi:
  case Operation::state:
  case Operation::parameter:
  case Operation::time:
    return intern(n);
  case Operation::add:
    return add(a, b);
  case Operation::subtract:
    return subtract(a, b);
  case Operation::multiply:
    return multiply(a, b);
  case Operation::divide:
    return divide(a, b);
  case Operation::negate:
    return negate(a);
  case Operation::integer_power:
    return integer_power(a, static_cast<int>(n.value));
  case Operation::power:
    return power(a, b);
  case Operation::contact_power:
    return contact_power(a, n.value);
  case Operation::rate:
    return rate(a);
  case Operation::spline:
    return spline(n.index, a, static_cast<int>(n.value));
  default:
    return function(n.operation, a, b);
  }
}

Expression Graph::derive(const Node& n, Expression self, Expression symbol, const std::function<Expression(Expression)>& d) {
  const Expression zero = constant(0.0), one = constant(1.0), a = n.a, b = n.b;
  if (self == symbol) return one;
  const int count = operands(n.operation);
  if (count == 0) return zero;
  const Expression da = d(a), db = count == 2 ? d(b) : zero;
  if (n.operation == Operation::rate) throw std::logic_error("the derivative of a rate was asked for before its mode was known");
  if (da == zero && db == zero) return zero;
  const auto square = [&](Expression e) { return integer_power(e, 2); };
  const auto chain = [&](Expression outer) { return multiply(outer, da); };
  switch (n.operation) {
  case Operation::add:
    return add(da, db);
  case Operation::subtract:
    return subtract(da, db);
  case Operation::multiply:
    return add(multiply(da, b), multiply(a, db));
  case Operation::divide:  // (a' - (a/b) b')/b
    return divide(subtract(da, multiply(self, db)), b);
  case Operation::negate:
    return negate(da);
  case Operation::integer_power:
    return chain(multiply(constant(n.value), integer_power(a, static_cast<int>(n.value) - 1)));
  case Operation::contact_power:
    return chain(multiply(constant(n.value), contact_power(a, n.value - 1.0)));
  case Operation::power: {
    const Expression in_base = multiply(multiply(b, power(a, subtract(b, one))), da);
    if (db == zero) return in_base;
    return add(in_base, multiply(multiply(self, function(log, a)), db));
  }
  case sin:
    return chain(function(cos, a));
  case cos:
    return negate(chain(function(sin, a)));
  case tan:
    return chain(add(one, square(self)));
  case asin:
    return divide(da, function(sqrt, subtract(one, square(a))));
  case acos:
    return negate(divide(da, function(sqrt, subtract(one, square(a)))));
  case atan:
    return divide(da, add(one, square(a)));
  case atan2:
    return divide(subtract(multiply(b, da), multiply(a, db)), add(square(a), square(b)));
  case sinh:
    return chain(function(cosh, a));
  case cosh:
    return chain(function(sinh, a));
  case tanh:
    return chain(subtract(one, square(self)));
  case exp:
    return chain(self);
  case log:
    return divide(da, a);
  case sqrt:
    return divide(da, multiply(constant(2.0), self));
  case hypot:
    return divide(add(multiply(a, da), multiply(b, db)), self);
  case Operation::spline:
    return chain(spline(n.index, a, static_cast<int>(n.value) + 1));
  case abs:
    return chain(function(sign, a));
  case max:
  case min: {  // max: a where a - b >= 0
    const Expression first = function(step, n.operation == max ? subtract(a, b) : subtract(b, a));
    return add(multiply(first, da), multiply(subtract(one, first), db));
  }
  default:  // sign, step
    return zero;
  }
}

Expression Graph::derivative(Expression e, Expression symbol) {
  const auto key = [&](Expression of) { return (std::uint64_t{of.index} << 32U) | symbol.index; };
  const auto known = [&](Expression of) { return derivatives_.at(key(of)); };
  std::vector<Expression> stack{e};
  while (!stack.empty()) {
    const Expression top = stack.back();
    if (derivatives_.contains(key(top))) {
      stack.pop_back();
      continue;
    }
    const Node n = node(top);
    const int count = operands(n.operation);
    const std::size_t before = stack.size();
    if (count > 0 && !derivatives_.contains(key(n.a))) stack.push_back(n.a);
    if (count > 1 && !derivatives_.contains(key(n.b))) stack.push_back(n.b);
    if (stack.size() > before) continue;
    derivatives_.emplace(key(top), derive(n, top, symbol, known));
    stack.pop_back();
  }
  return derivatives_.at(key(e));
}

Expression Graph::substitute(Expression e, const Replacement& replacement) {
  if (replacement.empty()) return e;
  Replacement done = replacement;
  for (const Expression part : reachable(*this, e)) {
    if (done.contains(part.index)) continue;
    const Node n = node(part);
    const int count = operands(n.operation);
    const Expression a = count > 0 ? done.at(n.a.index) : Expression{}, b = count > 1 ? done.at(n.b.index) : Expression{};
    const bool same = count == 0 || (a == n.a && (count == 1 || b == n.b));
    const Expression made = done.emplace(part.index, same ? part : with_operands(n, a, b)).first->second;
    if (made.index > part.index) origins_.try_emplace(made.index, part);
  }
  return done.at(e.index);
}

std::optional<Expression> Graph::origin(Expression e) const {
  const auto found = origins_.find(e.index);
  return found == origins_.end() ? std::nullopt : std::optional(found->second);
}

std::vector<Expression> reachable(const Graph& graph, std::span<const Expression> roots) {
  std::uint32_t last = 0;
  for (const Expression root : roots) last = std::max(last, root.index);
  std::vector<char> seen(roots.empty() ? 0 : last + std::size_t{1}, 0);
  for (const Expression root : roots) seen[root.index] = 1;
  std::size_t count = 0;
  for (std::size_t i = seen.size(); i-- > 0;) {
    if (!seen[i]) continue;
    ++count;
    const Node& n = graph.node({static_cast<std::uint32_t>(i)});
    const int number = operands(n.operation);
    if (number > 0) seen[n.a.index] = 1;
    if (number > 1) seen[n.b.index] = 1;
  }
  std::vector<Expression> out;
  out.reserve(count);
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (seen[i]) out.push_back({static_cast<std::uint32_t>(i)});
  return out;
}

std::optional<Expression> divisor_of(const Graph& graph, Expression e) {
  const Node n = graph.node(e);
  if (n.operation == Operation::divide) return n.b;
  return n.operation == Operation::integer_power && n.value < 0.0 ? std::optional(n.a) : std::nullopt;
}

Dependence dependence(const Graph& graph, std::span<const Expression> roots) {
  Dependence out;
  for (const Expression e : reachable(graph, roots)) {
    const Node& n = graph.node(e);
    if (n.operation == Operation::state) out.states.push_back(n.index);
    if (n.operation == Operation::parameter) out.parameters.push_back(n.index);
    if (n.operation == Operation::time) out.time = true;
    if (n.operation == Operation::rate) out.rate = true;
  }
  std::sort(out.states.begin(), out.states.end());
  std::sort(out.parameters.begin(), out.parameters.end());
  return out;
}

std::string function_name(Operation operation) {
  switch (operation) {
  case sin:
    return "sin";
  case cos:
    return "cos";
  case tan:
    return "tan";
  case asin:
    return "asin";
  case acos:
    return "acos";
  case atan:
    return "atan";
  case atan2:
    return "atan2";
  case sinh:
    return "sinh";
  case cosh:
    return "cosh";
  case tanh:
    return "tanh";
  case exp:
    return "exp";
  case log:
    return "log";
  case sqrt:
    return "sqrt";
  case hypot:
    return "hypot";
  case abs:
    return "abs";
  case sign:
    return "sign";
  case max:
    return "max";
  case min:
    return "min";
  case step:
    return "step";
  default:
    return {};
  }
}

namespace {

enum Strength : int { sum = 1, product = 2, prefix = 3, raised = 4, atom = 5 };

Strength strength(const Node& n) {
  switch (n.operation) {
  case add:
  case subtract:
    return sum;
  case multiply:
  case divide:
    return product;
  case negate:
    return prefix;
  case constant:
    return n.value < 0.0 ? prefix : atom;
  case integer_power:
  case power:
  case contact_power:
    return raised;
  default:
    return atom;
  }
}

}  // namespace

std::string to_text(const Graph& graph, Expression e, const Symbols& symbols, std::size_t limit) {
  // Either text, or an expression that must bind at least as strongly as `needed`.
  struct Piece {
    std::string text;
    std::optional<Expression> expression = {};
    int needed = 0;
  };
  std::string out;
  std::vector<Piece> stack;
  stack.push_back({{}, e, 0});
  while (!stack.empty()) {
    const Piece piece = std::move(stack.back());
    stack.pop_back();
    if (out.size() > limit) return out.substr(0, limit) + "...";
    if (!piece.expression) {
      out += piece.text;
      continue;
    }
    const Node n = graph.node(*piece.expression);
    const int own = strength(n);
    if (own < piece.needed) {
      out += '(';
      stack.push_back({")"});
    }
    const auto binary = [&](const char* sign_text, int left, int right) {
      stack.push_back({{}, n.b, right});
      stack.push_back({sign_text});
      stack.push_back({{}, n.a, left});
    };
    switch (n.operation) {
    case constant:
      out += fmt::format("{}", n.value);
      break;
    case pi:
      out += "pi";
      break;
    case state:
      out += symbols.states.at(n.index);
      break;
    case parameter:
      out += symbols.parameters.at(n.index);
      break;
    case time:
      out += "t";
      break;
    case add:
      binary(" + ", sum, product);
      break;
    case subtract:
      binary(" - ", sum, product);
      break;
    case multiply:
      binary("*", product, prefix);
      break;
    case divide:
      binary("/", product, prefix);
      break;
    case negate:
      out += '-';
      stack.push_back({{}, n.a, raised});
      break;
    case power:
      binary("^", atom, atom);
      break;
    case integer_power:
    case contact_power: {
      stack.push_back({n.value < 0.0 ? fmt::format("^({})", n.value) : fmt::format("^{}", n.value)});
      stack.push_back({{}, n.a, atom});
      break;
    }
    case rate:
      stack.push_back({"'"});
      stack.push_back({{}, n.a, atom});
      break;
    case spline: {
      stack.push_back({")"});
      stack.push_back({{}, n.a, 0});
      out +=
          fmt::format("spline({}{}, ", graph.splines()[n.index].table.name, std::string(static_cast<std::size_t>(n.value), '\''));
      break;
    }
    default:
      out += function_name(n.operation) + '(';
      stack.push_back({")"});
      if (operands(n.operation) == 2) {
        stack.push_back({{}, n.b, 0});
        stack.push_back({", "});
      }
      stack.push_back({{}, n.a, 0});
    }
  }
  return out;
}

}  // namespace graze::equations
