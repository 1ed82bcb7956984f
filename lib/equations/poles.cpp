// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/poles.hpp>

#include <algorithm>
#include <cmath>
#include <unordered_set>

namespace graze::equations {

namespace {

/// numerator / product over k of factor_k^powers[k].
struct Fraction {
  Expression numerator;
  std::vector<int> powers;
  bool plain() const {
    return std::all_of(powers.begin(), powers.end(), [](int power) { return power == 0; });
  }
};

/// Brings expressions over the common denominator of given divisors.
class CommonDenominator {
 public:
  CommonDenominator(Graph& graph, const std::vector<SignedDivisor>& divisors, const std::vector<ParameterInfo>& parameters)
      : graph_(graph), parameters_(parameters), divisors_(divisors) {
    for (const SignedDivisor& one : divisors) {
      const Fraction own = of(one.divisor);
      const int sign = one.sign * sign_of(own.powers);
      factors_.push_back(own.numerator);
      signs_.push_back(sign);
      powers_.push_back(own.powers);
      known_.clear();  // the later ones may contain quotients by this one
    }
  }

  /// See without_quotients.
  RegularFraction regular(Expression e) {
    const Fraction own = of(e);
    const Expression product = times_factors(graph_.constant(1.0), own.powers, std::vector<int>(divisors_.size(), 0));
    if (sign_of(own.powers) > 0) return {own.numerator, product};
    return {graph_.negate(own.numerator), graph_.negate(product)};
  }

 private:
  int sign_of(const std::vector<int>& powers) const {
    int sign = 1;
    for (std::size_t k = 0; k < signs_.size(); ++k)
      if (powers[k] % 2 != 0) sign *= signs_[k];
    return sign;
  }

  Fraction plain(Expression e) const { return {e, std::vector<int>(divisors_.size(), 0)}; }

  Expression times_factors(Expression e, const std::vector<int>& powers, const std::vector<int>& less) {
    for (std::size_t k = 0; k < factors_.size(); ++k)
      if (const int n = powers[k] - less[k]; n > 0) e = graph_.multiply(e, graph_.integer_power(factors_[k], n));
    return e;
  }

  Fraction of(Expression e) {
    for (const Expression part : reachable(graph_, e))
      if (!known_.contains(part.index)) known_.emplace(part.index, make(part));
    return known_.at(e.index);
  }

  Fraction make(Expression part) {
    using enum Operation;
    const Node n = graph_.node(part);
    if (const auto quotient = as_quotient(graph_, part, parameters_))
      for (std::size_t k = 0; k < factors_.size(); ++k)
        if (const int side = same_up_to_sign(graph_, quotient->divisor, divisors_[k].divisor); side != 0)
          return divided(*quotient, k, side);
    const std::vector<int> none(divisors_.size(), 0);
    const Fraction a = operands(n.operation) > 0 ? known_.at(n.a.index) : plain(part);
    const Fraction b = operands(n.operation) > 1 ? known_.at(n.b.index) : plain(part);
    if (a.plain() && b.plain()) return plain(part);
    Fraction out = a;
    switch (n.operation) {
    case add:
    case subtract:
      std::transform(a.powers.begin(), a.powers.end(), b.powers.begin(), out.powers.begin(),
                     [](int i, int j) { return std::max(i, j); });
      out.numerator = graph_.with_operands(n, times_factors(a.numerator, out.powers, a.powers),
                                           times_factors(b.numerator, out.powers, b.powers));
      return out;
    case negate:
      out.numerator = graph_.negate(a.numerator);
      return out;
    case multiply:
      std::transform(a.powers.begin(), a.powers.end(), b.powers.begin(), out.powers.begin(), std::plus<>());
      out.numerator = graph_.multiply(a.numerator, b.numerator);
      return out;
    case divide:
      out.numerator = graph_.divide(times_factors(a.numerator, b.powers, none), b.numerator);
      return out;
    case integer_power:
      if (n.value < 0.0) return plain(part);
      for (int& power : out.powers) power *= static_cast<int>(n.value);
      out.numerator = graph_.integer_power(a.numerator, static_cast<int>(n.value));
      return out;
    default:
      return plain(part);
    }
  }

  Fraction divided(const Quotient& quotient, std::size_t k, int side) {
    const auto known = known_.find(quotient.numerator.index);
    Fraction out = known == known_.end() ? plain(quotient.numerator) : known->second;
    std::vector<int> behind = powers_[k];  // of the divisor itself
    for (int& power : behind) power *= quotient.power;
    behind.resize(divisors_.size(), 0);
    out.numerator = times_factors(out.numerator, behind, std::vector<int>(divisors_.size(), 0));
    if (side < 0 && quotient.power % 2 != 0) out.numerator = graph_.negate(out.numerator);
    out.powers[k] += quotient.power;
    return out;
  }

  Graph& graph_;
  const std::vector<ParameterInfo>& parameters_;
  const std::vector<SignedDivisor>& divisors_;
  std::vector<Expression> factors_;  ///< numerators of the divisors
  std::vector<int> signs_;           ///< of the factors
  std::vector<std::vector<int>> powers_;
  std::unordered_map<std::uint32_t, Fraction> known_;
};

}  // namespace

bool jumps_at_poles(Operation operation) {
  return operation == Operation::atan || operation == Operation::tanh || operation == Operation::atan2;
}

std::optional<Quotient> as_quotient(Graph& graph, Expression e, const std::vector<ParameterInfo>& parameters) {
  const Node n = graph.node(e);
  Quotient out{graph.constant(1.0), n.a, 1};
  if (n.operation == Operation::divide) {
    out = {n.a, n.b, 1};
    if (const Node b = graph.node(n.b); b.operation == Operation::integer_power && b.value > 0.0)
      out = {n.a, b.a, static_cast<int>(b.value)};
  } else if (n.operation == Operation::integer_power && n.value < 0.0) {
    out.power = static_cast<int>(-n.value);
  } else if (n.operation == Operation::tan) {
    out = {graph.function(Operation::sin, n.a), graph.function(Operation::cos, n.a), 1};
  } else {
    return std::nullopt;
  }
  if (out.power % 2 == 0 || !dependence(graph, out.divisor).moves()) return std::nullopt;
  const Bounds range = bounds(graph, out.divisor, parameters);
  return range.lower < 0.0 && range.upper > 0.0 ? std::optional(out) : std::nullopt;
}

std::vector<Expression> vanishing_divisors(Graph& graph, std::span<const Expression> roots,
                                           const std::vector<ParameterInfo>& parameters, bool inside_bounded) {
  std::vector<Expression> out, open(roots.begin(), roots.end());
  std::unordered_set<std::uint32_t> met;
  while (!open.empty()) {
    const Expression part = open.back();
    open.pop_back();
    if (!met.insert(part.index).second) continue;
    const Node n = graph.node(part);
    if (!inside_bounded && jumps_at_poles(n.operation)) continue;
    if (operands(n.operation) > 0) open.push_back(n.a);
    if (operands(n.operation) > 1) open.push_back(n.b);
    const auto quotient = as_quotient(graph, part, parameters);
    if (quotient && std::none_of(out.begin(), out.end(),
                                 [&](Expression known) { return same_up_to_sign(graph, known, quotient->divisor) != 0; }))
      out.push_back(quotient->divisor);
  }
  return out;
}

int same_up_to_sign(Graph& graph, Expression a, Expression b) {
  if (a == b) return 1;
  const Expression first = normal_form(graph, a);
  if (first == normal_form(graph, b)) return 1;
  return first == normal_form(graph, graph.negate(b)) ? -1 : 0;
}

RegularFraction without_quotients(Graph& graph, Expression e, const std::vector<SignedDivisor>& divisors,
                                  const std::vector<ParameterInfo>& parameters) {
  if (divisors.empty()) return {e, graph.constant(1.0)};
  return CommonDenominator(graph, divisors, parameters).regular(e);
}

}  // namespace graze::equations
