// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/constraints.hpp>

namespace graze::equations {

Expression rate_along(Graph& graph, Expression e, const std::function<Expression(std::size_t state)>& field) {
  Expression sum = graph.derivative(e, graph.time());
  for (const std::size_t i : dependence(graph, e).states) {
    const Expression slope = graph.derivative(e, graph.state(i));
    if (!graph.is_constant(slope, 0.0)) sum = graph.add(sum, graph.multiply(slope, field(i)));
  }
  return sum;
}

Expression rate_along(Graph& graph, Expression e, const std::vector<Expression>& field) {
  return rate_along(graph, e, [&](std::size_t i) { return field[i]; });
}

std::optional<Solution> solve_constraint(const Names& names, Expression e, const std::function<bool(std::size_t)>& allowed) {
  Graph& graph = names.graph;
  if (const auto found = solve_guard(graph, e, names.symbols.states.size(), allowed)) return found;
  for (const std::size_t i : dependence(graph, e).states) {
    if (!allowed(i)) continue;
    const Expression slope = normal_form(graph, graph.derivative(e, graph.state(i)));
    const Bounds range = bounds(graph, slope, names.parameters);
    if (dependence(graph, slope).moves() || !(range.lower > 0.0 || range.upper < 0.0)) continue;
    const Expression rest = graph.substitute(e, {{graph.state(i).index, graph.constant(0.0)}});
    return Solution{i, normal_form(graph, graph.negate(graph.divide(rest, slope)))};
  }
  return std::nullopt;
}

}  // namespace graze::equations
