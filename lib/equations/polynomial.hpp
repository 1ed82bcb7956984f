// SPDX-License-Identifier: GPL-3.0-or-later
// Expressions as sums of products: a normal form in which equal polynomials are equal, and conclusions from it.
//
// A generator is a state, the time, a parameter or any expression that is not a sum or product (cos(eta t), 1/(1 + x), a root).
// A term is a coefficient times a product of powers of generators. A property proved here holds for all values; an unproved one
// may still be true.
#pragma once

#include <graze/lib/equations/expression.hpp>
#include <graze/lib/system/parameters.hpp>

#include <map>
#include <memory>
#include <optional>

namespace graze::equations {

/// Generator -> exponent, in the order of the generators.
using Monomial = std::vector<std::pair<std::uint32_t, double>>;
/// Monomial -> coefficient. Empty: zero.
using Polynomial = std::map<Monomial, Expression>;

/// Allowed coefficients: numbers, or all expressions of the parameters only.
enum class Coefficients { numbers, parameters };

class Expander {
 public:
  Expander(Graph& graph, Coefficients coefficients) : graph_(graph), coefficients_(coefficients) {}
  /// The polynomial of e; nullopt: it has too many terms.
  const std::optional<Polynomial>& expand(Expression e);
  /// The sum of the terms of e, with numbers as coefficients; e itself if it is too long.
  Expression normal(Expression e);
  /// The original form of a generator, before its arguments were brought to normal form.
  Expression original(std::uint32_t generator) const;

 private:
  std::optional<Polynomial> make(const Node& node, Expression self);
  std::optional<Polynomial> generator(Expression normal, Expression original, double exponent = 1.0);

  Graph& graph_;
  Coefficients coefficients_;
  std::unordered_map<std::uint32_t, std::optional<Polynomial>> known_;
  std::unordered_map<std::uint32_t, bool> is_coefficient_;
  std::unordered_map<std::uint32_t, Expression> original_, normal_;
  std::unique_ptr<Expander> numbers_;  // for normal forms, if the coefficients are parameters
};

/// The sum of the terms as an expression.
Expression assemble(Graph& graph, const Polynomial& polynomial);
/// An expression that is the same for equal polynomials; e itself if it is too long.
Expression normal_form(Graph& graph, Expression e);
/// True if e is proved to vanish identically.
bool is_zero(Graph& graph, Expression e);
/// The number of the parameter to which e is equal; nullopt: none.
std::optional<std::size_t> as_parameter(Graph& graph, Expression e);

/// Bounds of a value over all states, times and parameters in their ranges.
struct Bounds {
  double lower, upper;
};
Bounds bounds(const Graph& graph, Expression e, const std::vector<ParameterInfo>& parameters);

}  // namespace graze::equations
