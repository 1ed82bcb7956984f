// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/coordinates.hpp>

#include <graze/lib/equations/constraints.hpp>
#include <graze/lib/equations/functions.hpp>
#include <graze/lib/equations/polynomial.hpp>

#include <fmt/format.h>

#include <cmath>

namespace graze::equations {

namespace {

/// A pivot below this fraction of the diagonal is rounding error: the matrix is singular.
constexpr double smallest_pivot = 1e-12;
/// Number of nodes up to which an expression is expanded.
constexpr std::size_t longest_tidied = 100;

/// The state at which values decide.
Vector probe(const Coordinates& coordinates) {
  if (coordinates.names.start) return *coordinates.names.start;
  Vector x(static_cast<Eigen::Index>(2 * coordinates.n));
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = 0.1 * static_cast<double>(i + 1);
  return x;
}

}  // namespace

Expression Coordinates::dot(const Column& a, const Column& b) const {
  Expression sum = zero();
  for (std::size_t i = 0; i < a.size(); ++i) sum = graph.add(sum, graph.multiply(a[i], b[i]));
  return sum;
}

Column Coordinates::field_of(const Column& acceleration) const {
  Column out;
  for (std::size_t i = 0; i < n; ++i) out.push_back(v(i));
  out.insert(out.end(), acceleration.begin(), acceleration.end());
  return out;
}

bool Coordinates::has_velocity(Expression e) const {
  const auto on = dependence(graph, e).states;
  return !on.empty() && on.back() >= n;
}

double Coordinates::value(Expression e) const { return values(graph, {&e, 1}, 0.0, probe(*this), names.defaults)[0]; }

bool Coordinates::vanishes(Expression e) const {
  constexpr double rounding = 1e-9;
  return !(std::abs(value(e)) > rounding) && is_zero(graph, e);
}

Expression Coordinates::tidy(Expression e) const {
  return reachable(graph, e).size() > longest_tidied ? e : normal_form(graph, e);
}

Expression without_rates(const Coordinates& coordinates, Expression e, const Place& place, const std::string& where,
                         Replacement known) {
  Graph& graph = coordinates.graph;
  Names& names = coordinates.names;
  if (!dependence(graph, e).rate) return e;
  const Column field = coordinates.field_of(Column(coordinates.n, coordinates.zero()));
  for (const Expression part : reachable(graph, e)) {
    const Node node = graph.node(part);
    if (node.operation != Operation::rate || known.contains(part.index)) continue;
    const Expression of = graph.substitute(node.a, known);
    if (coordinates.has_velocity(of))
      names.refuse(known_place(graph, names.hazards, part).value_or(place),
                   fmt::format("an acceleration, the rate of {}, stands {}", coordinates.velocity_in(of), where));
    known.emplace(part.index, rate_along(graph, of, field));
  }
  return graph.substitute(e, known);
}

Expression read_expression(const Coordinates& coordinates, const Text& text, const std::string& where, const Scope& scope) {
  Names& names = coordinates.names;
  const Expression raw = parse_expression(names.graph, names.text.source, text, scope, where, &names.hazards);
  return without_rates(coordinates, raw, text.place, where);
}

Expression read_expression(const Coordinates& coordinates, const Text& text, const std::string& where) {
  return read_expression(coordinates, text, where, coordinates.scope);
}

Scope with_name(const Scope& scope, const std::string& name, Expression meaning) {
  Scope out = scope;
  const bool is_taken = out.find(name).has_value();
  out.find = [find = scope.find, name, meaning, is_taken](std::string_view one) {
    return one != name ? find(one) : is_taken ? std::nullopt : std::optional(meaning);
  };
  if (is_taken)
    out.refusal = [refusal = scope.refusal, name](std::string_view one) {
      if (one == name)
        return fmt::format("the name '{}' has a meaning of its own, and another one in the file, which must be renamed,", name);
      return refusal ? refusal(one) : std::string();
    };
  out.names.push_back(name);
  return out;
}

std::optional<Square> solve_linear(const Coordinates& coordinates, Square A, Square B, std::size_t* row) {
  Graph& graph = coordinates.graph;
  const std::size_t size = A.size();
  std::vector<double> diagonal;
  for (std::size_t i = 0; i < size; ++i) diagonal.push_back(coordinates.value(A[i][i]));
  const auto eliminate = [&](std::size_t i, std::size_t k) {
    if (graph.is_constant(A[i][k], 0.0)) return;
    const Expression factor = graph.divide(A[i][k], A[k][k]);
    for (std::size_t j = k; j < size; ++j) A[i][j] = graph.subtract(A[i][j], graph.multiply(factor, A[k][j]));
    for (Expression& one : B[i]) {
      const auto column = static_cast<std::size_t>(&one - B[i].data());
      one = graph.subtract(one, graph.multiply(factor, B[k][column]));
    }
  };
  for (std::size_t k = 0; k < size; ++k) {
    if (row) *row = k;
    const double pivot = coordinates.value(A[k][k]);
    if (!(pivot > smallest_pivot * std::abs(diagonal[k]))) return std::nullopt;
    for (std::size_t i = k + 1; i < size; ++i) eliminate(i, k);
  }
  for (std::size_t k = size; k-- > 0;) {
    for (std::size_t i = 0; i < k; ++i) eliminate(i, k);
    for (Expression& one : B[k]) one = graph.divide(one, A[k][k]);
  }
  return B;
}

}  // namespace graze::equations
