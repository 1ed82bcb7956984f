// SPDX-License-Identifier: GPL-3.0-or-later
// The coordinates q and velocities v of mechanics as the states x = (q, v), expressions of the text in them, and the linear
// algebra of the equations of motion. Internal.
//
// Whether an expression is zero or a pivot positive is decided with the values at one state: the start, or a state without
// symmetry if the text gives none.
#pragma once

#include <graze/lib/equations/names.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace graze::equations {

using Column = std::vector<Expression>;
using Square = std::vector<Column>;  // rows

/// Refers to the names, which must hold mechanics.
struct Coordinates {
  explicit Coordinates(Names& of)
      : names(of), graph(of.graph), scope(of.scope(true)), text(*of.text.mechanics), n(text.coordinates.size()) {}

  Names& names;
  Graph& graph;
  Scope scope;  ///< all names and the time
  const MechanicsText& text;
  std::size_t n;

  Expression q(std::size_t i) const { return graph.state(i); }
  Expression v(std::size_t i) const { return graph.state(n + i); }
  Expression zero() const { return graph.constant(0.0); }
  Expression dot(const Column& a, const Column& b) const;
  /// (v, a)
  Column field_of(const Column& acceleration) const;

  bool has_velocity(Expression e) const;
  /// The name of the last velocity in e, which has one.
  const std::string& velocity_in(Expression e) const { return names.symbols.states[dependence(graph, e).states.back()]; }
  /// At the state described above and the default parameters.
  double value(Expression e) const;
  /// True if the expression vanishes identically; a nonzero value is the faster proof that it does not.
  bool vanishes(Expression e) const;
  /// The normal form, unless the expression is long.
  Expression tidy(Expression e) const;
};

/// Replaces the rates of coordinates, of expressions in them, and of names in `known`; an acceleration is refused.
/// @throws EquationError
Expression without_rates(const Coordinates& coordinates, Expression e, const Place& place, const std::string& where,
                         Replacement known = {});

/// The expression of the text without rates. `where` says in messages where it stands. @throws EquationError
Expression read_expression(const Coordinates& coordinates, const Text& text, const std::string& where, const Scope& scope);
Expression read_expression(const Coordinates& coordinates, const Text& text, const std::string& where);

/// The names of the scope and one more. If the file already defines that name, it cannot be used.
Scope with_name(const Scope& scope, const std::string& name, Expression meaning);

/// X with A X = B for a positive definite A; nullopt: A is not positive definite, in row `row`.
std::optional<Square> solve_linear(const Coordinates& coordinates, Square A, Square B, std::size_t* row = nullptr);

}  // namespace graze::equations
