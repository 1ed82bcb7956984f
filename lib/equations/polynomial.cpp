// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/polynomial.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze::equations {

namespace {

/// Sums with more terms are not multiplied out.
constexpr std::size_t most_terms = 400;
constexpr int largest_expanded_power = 12;

Monomial times(const Monomial& a, const Monomial& b) {
  Monomial out;
  auto p = a.begin(), q = b.begin();
  while (p != a.end() || q != b.end()) {
    if (q == b.end() || (p != a.end() && p->first < q->first)) {
      out.push_back(*p++);
    } else if (p == a.end() || q->first < p->first) {
      out.push_back(*q++);
    } else {
      const double exponent = p->second + q->second;
      if (exponent != 0.0) out.emplace_back(p->first, exponent);
      ++p;
      ++q;
    }
  }
  return out;
}

void accumulate(Graph& graph, Polynomial& sum, const Monomial& monomial, Expression coefficient) {
  const auto [at, is_new] = sum.try_emplace(monomial, coefficient);
  if (!is_new) at->second = graph.add(at->second, coefficient);
  if (graph.is_constant(at->second, 0.0)) sum.erase(at);
}

std::optional<Polynomial> product(Graph& graph, const Polynomial& a, const Polynomial& b) {
  if (a.size() * b.size() > most_terms) return std::nullopt;
  Polynomial out;
  for (const auto& [m, c] : a)
    for (const auto& [n, d] : b) accumulate(graph, out, times(m, n), graph.multiply(c, d));
  return out;
}

}  // namespace

Expression Expander::original(std::uint32_t generator) const {
  const auto found = original_.find(generator);
  return found == original_.end() ? Expression{generator} : found->second;
}

Expression Expander::normal(Expression e) {
  if (coefficients_ != Coefficients::numbers) {
    if (!numbers_) numbers_ = std::make_unique<Expander>(graph_, Coefficients::numbers);
    return numbers_->normal(e);
  }
  if (const auto found = normal_.find(e.index); found != normal_.end()) return found->second;
  const std::optional<Polynomial>& polynomial = expand(e);
  const Expression out = polynomial ? assemble(graph_, *polynomial) : e;
  normal_.emplace(e.index, out);
  return out;
}

std::optional<Polynomial> Expander::generator(Expression normal, Expression original, double exponent) {
  original_.try_emplace(normal.index, original);
  return Polynomial{{Monomial{{normal.index, exponent}}, graph_.constant(1.0)}};
}

std::optional<Polynomial> Expander::make(const Node& n, Expression self) {
  using enum Operation;
  if (is_coefficient_.at(self.index)) {
    if (graph_.is_constant(self, 0.0)) return Polynomial{};
    return Polynomial{{Monomial{}, self}};
  }
  const int count = operands(n.operation);
  if (count == 0) return generator(self, self);
  const auto &a = known_.at(n.a.index), &b = count > 1 ? known_.at(n.b.index) : a;
  const auto scaled = [&](const Polynomial& from, const std::function<Expression(Expression)>& factor) {
    Polynomial out;
    for (const auto& [monomial, coefficient] : from) out.emplace(monomial, factor(coefficient));
    return out;
  };
  const auto inverse = [&](const std::optional<Polynomial>& of, Expression expression) -> std::optional<Polynomial> {
    if (of && of->size() == 1) {
      Monomial monomial = of->begin()->first;
      for (auto& [g, exponent] : monomial) exponent = -exponent;
      return Polynomial{{monomial, graph_.divide(graph_.constant(1.0), of->begin()->second)}};
    }
    return generator(normal(expression), expression, -1.0);
  };
  switch (n.operation) {
  case add:
  case subtract: {
    if (!a || !b) return std::nullopt;
    Polynomial out = *a;
    for (const auto& [monomial, coefficient] : *b)
      accumulate(graph_, out, monomial, n.operation == add ? coefficient : graph_.negate(coefficient));
    if (out.size() > most_terms) return std::nullopt;
    return out;
  }
  case negate:
    if (!a) return std::nullopt;
    return scaled(*a, [&](Expression c) { return graph_.negate(c); });
  case multiply:
    if (!a || !b) return std::nullopt;
    return product(graph_, *a, *b);
  case divide: {
    if (!a) return std::nullopt;
    if (b && b->size() == 1 && b->begin()->first.empty()) {
      const Expression divisor = b->begin()->second;
      return scaled(*a, [&](Expression c) { return graph_.divide(c, divisor); });
    }
    const auto of = inverse(b, n.b);
    return of ? product(graph_, *a, *of) : std::nullopt;
  }
  case integer_power: {
    const int exponent = static_cast<int>(n.value), size = std::abs(exponent);
    if (a && size <= largest_expanded_power) {
      std::optional<Polynomial> out = Polynomial{{Monomial{}, graph_.constant(1.0)}};
      for (int i = 0; i < size && out; ++i) out = product(graph_, *out, *a);
      if (out && exponent > 0) return out;
      if (out && out->size() == 1) return inverse(out, self);
    }
    return generator(normal(n.a), n.a, n.value);
  }
  case sqrt:
  case power: {
    const Expression base = normal(n.a);
    const Node& e = n.operation == power ? graph_.node(n.b) : n;
    if (n.operation == power && e.operation != constant) return generator(graph_.power(base, normal(n.b)), self);
    const double exponent = n.operation == power ? e.value : 0.5;
    if (graph_.is_constant(base, 0.0) && exponent > 0.0) return Polynomial{};
    return generator(base, n.a, exponent);
  }
  default: {
    const Expression with_normal = graph_.with_operands(n, normal(n.a), count > 1 ? normal(n.b) : Expression{});
    // Simplification may have made it a number, or moved a sign out.
    const Node& m = graph_.node(with_normal);
    if (m.operation == constant) return m.value == 0.0 ? Polynomial{} : Polynomial{{Monomial{}, with_normal}};
    if (m.operation == negate) return Polynomial{{Monomial{{m.a.index, 1.0}}, graph_.constant(-1.0)}};
    return generator(with_normal, self);
  }
  }
}

const std::optional<Polynomial>& Expander::expand(Expression e) {
  if (const auto found = known_.find(e.index); found != known_.end()) return found->second;
  for (const Expression part : reachable(graph_, e)) {
    if (known_.contains(part.index)) continue;
    const Node n = graph_.node(part);
    const int count = operands(n.operation);
    bool coefficient = n.operation == Operation::constant;
    if (coefficients_ == Coefficients::parameters) {
      coefficient = n.operation != Operation::state && n.operation != Operation::time && n.operation != Operation::rate;
      if (count > 0) coefficient = coefficient && is_coefficient_.at(n.a.index);
      if (count > 1) coefficient = coefficient && is_coefficient_.at(n.b.index);
    }
    is_coefficient_[part.index] = coefficient;
    auto made = make(n, part);
    known_.emplace(part.index, std::move(made));
  }
  return known_.at(e.index);
}

Expression assemble(Graph& graph, const Polynomial& polynomial) {
  Expression sum = graph.constant(0.0);
  for (const auto& [monomial, coefficient] : polynomial) {
    Expression term = coefficient;
    for (const auto& [generator, exponent] : monomial)
      term = graph.multiply(term, graph.power({generator}, graph.constant(exponent)));
    sum = graph.add(sum, term);
  }
  return sum;
}

Expression normal_form(Graph& graph, Expression e) { return Expander(graph, Coefficients::numbers).normal(e); }

bool is_zero(Graph& graph, Expression e) {
  if (graph.is_constant(e, 0.0)) return true;
  Expander expander(graph, Coefficients::numbers);
  const auto& polynomial = expander.expand(e);
  return polynomial && polynomial->empty();
}

std::optional<std::size_t> as_parameter(Graph& graph, Expression e) {
  const Expression normal = normal_form(graph, e);
  const Node& n = graph.node(normal);
  return n.operation == Operation::parameter ? std::optional<std::size_t>(n.index) : std::nullopt;
}

Bounds bounds(const Graph& graph, Expression e, const std::vector<ParameterInfo>& parameters) {
  using enum Operation;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto product = [](double a, double b) { return a == 0.0 || b == 0.0 ? 0.0 : a * b; };
  const auto multiplied = [&](Bounds a, Bounds b) {
    const auto [low, high] =
        std::minmax({product(a.lower, b.lower), product(a.lower, b.upper), product(a.upper, b.lower), product(a.upper, b.upper)});
    return Bounds{low, high};
  };
  const auto inverse = [&](Bounds a) {
    if (a.lower > 0.0 || a.upper < 0.0) return Bounds{1.0 / a.upper, 1.0 / a.lower};
    if (a.lower == 0.0) return Bounds{1.0 / a.upper, infinity};
    return Bounds{-infinity, infinity};
  };
  const auto raised = [&](Bounds a, int n) {
    const double low = std::pow(a.lower, n), high = std::pow(a.upper, n);
    if (n % 2 == 1) return Bounds{low, high};
    if (a.lower <= 0.0 && a.upper >= 0.0) return Bounds{0.0, std::max(low, high)};
    return Bounds{std::min(low, high), std::max(low, high)};
  };
  std::unordered_map<std::uint32_t, Bounds> known;
  for (const Expression part : reachable(graph, e)) {
    const Node& n = graph.node(part);
    const int count = operands(n.operation);
    const Bounds everything{-infinity, infinity};
    const Bounds a = count > 0 ? known.at(n.a.index) : everything, b = count > 1 ? known.at(n.b.index) : everything;
    Bounds out = everything;
    switch (n.operation) {
    case constant:
      out = {n.value, n.value};
      break;
    case pi:
      out = {3.1415926, 3.1415927};
      break;
    case parameter:
      if (n.index < parameters.size()) {
        const ParameterInfo& info = parameters[n.index];
        out = {info.lower_open ? std::nextafter(info.lower, infinity) : info.lower, info.upper};
      }
      break;
    case add:
      out = {a.lower + b.lower, a.upper + b.upper};
      break;
    case subtract:
      out = {a.lower - b.upper, a.upper - b.lower};
      break;
    case multiply:
      out = multiplied(a, b);
      break;
    case divide:
      out = multiplied(a, inverse(b));
      break;
    case negate:
      out = {-a.upper, -a.lower};
      break;
    case integer_power: {
      const int exponent = static_cast<int>(n.value);
      out = raised(a, std::abs(exponent));
      if (exponent < 0) out = inverse(out);
      break;
    }
    case power:
    case contact_power:
    case sqrt:
    case hypot:
    case cosh:
      out = {n.operation == cosh ? 1.0 : 0.0, infinity};
      // A root or hypot of values bounded away from zero is bounded away from zero.
      if (n.operation == sqrt || n.operation == hypot) {
        const auto least = [](Bounds of) { return of.lower > 0.0 ? of.lower : of.upper < 0.0 ? -of.upper : 0.0; };
        out.lower = n.operation == sqrt ? std::sqrt(std::max(0.0, a.lower)) : std::max(least(a), least(b));
      }
      break;
    case exp:
      out = {std::exp(a.lower), std::exp(a.upper)};
      break;
    case sin:
    case cos:
    case tanh:
    case sign:
      out = {-1.0, 1.0};
      break;
    case step:
      out = {0.0, 1.0};
      break;
    case atan:
      out = {-1.5707964, 1.5707964};
      break;
    case atan2:
      out = {a.lower >= 0.0 ? 0.0 : -3.1415927, a.upper < 0.0 ? 0.0 : 3.1415927};
      break;
    case abs:
      out = {a.lower > 0.0 ? a.lower : a.upper < 0.0 ? -a.upper : 0.0, std::max(-a.lower, a.upper)};
      break;
    case max:
      out = {std::max(a.lower, b.lower), std::max(a.upper, b.upper)};
      break;
    case min:
      out = {std::min(a.lower, b.lower), std::min(a.upper, b.upper)};
      break;
    default:
      break;
    }
    if (std::isnan(out.lower)) out.lower = -infinity;
    if (std::isnan(out.upper)) out.upper = infinity;
    known.emplace(part.index, out);
  }
  return known.at(e.index);
}

}  // namespace graze::equations
