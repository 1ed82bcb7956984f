// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/not_finite.hpp>

#include <graze/lib/equations/functions.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze::equations {

namespace {

/// Longest text of an expression in a message.
constexpr std::size_t longest_part = 60;

double value_of(const Graph& graph, Expression e, double t, const Vector& x, const Vector& p) {
  return values(graph, {&e, 1}, t, x, p)[0];
}

std::string sentence_of(const Written& written, const Node& n, Expression node, double value,
                        const std::vector<double>& operand) {
  const auto shown = [&](Expression e) { return to_text(written.graph, e, written.symbols, longest_part); };
  switch (n.operation) {
  case Operation::divide:
    if (operand[1] == 0.0) return fmt::format("the divisor {} is zero", shown(n.b));
    break;
  case Operation::integer_power:
    if (operand[0] == 0.0) return fmt::format("the divisor {} is zero", shown(n.a));
    break;
  case Operation::log:
    return fmt::format("no {} logarithm: {} is {:.9g}", operand[0] < 0.0 ? "real" : "finite", shown(n.a), operand[0]);
  case Operation::sqrt:
  case Operation::power:
    if (operand[0] < 0.0)
      return fmt::format("no real {}: {} is {:.9g}", n.operation == Operation::sqrt ? "root" : "power", shown(n.a), operand[0]);
    return fmt::format("{} is {}, as {} is {}", shown(node), value, shown(n.a), operand[0]);
  case Operation::asin:
  case Operation::acos:
    return fmt::format("no real {}: {} is {}", n.operation == Operation::asin ? "arcsine" : "arccosine", shown(n.a), operand[0]);
  default:
    break;
  }
  if (operands(n.operation) == 1) return fmt::format("{} is {}, as {} is {}", shown(node), value, shown(n.a), operand[0]);
  return fmt::format("{} is {}", shown(node), value);
}

/// A mode's equations and guards with their places.
struct Root {
  Expression expression;
  Place place;
};
std::vector<Root> roots_of(const TextSystem& text, std::size_t mode) {
  std::vector<Root> roots;
  const ModeExpressions& own = text.modes[mode];
  for (std::size_t i = 0; i < own.field.size(); ++i) roots.push_back({own.field[i], own.equation[i]});
  for (std::size_t e = 0; e < text.events.size(); ++e)
    if (text.system.events[e].from == mode) roots.push_back({text.events[e].guard, text.events[e].when});
  return roots;
}

Written written_of(const TextSystem& text) { return {*text.graph, text.symbols, text.hazards}; }

}  // namespace

std::optional<NotFinite> find_not_finite(const Written& written, Expression root, double t, const Vector& x, const Vector& p,
                                         const Place& otherwise) {
  double value = value_of(written.graph, root, t, x, p);
  if (std::isfinite(value)) return std::nullopt;
  std::optional<Place> place;
  for (Expression node = root;;) {
    if (const auto known = known_place(written.graph, written.hazards, node)) place = known;
    const Node n = written.graph.node(node);
    std::vector<double> operand;
    std::optional<Expression> at_fault;
    for (int i = 0; i < operands(n.operation); ++i) {
      const Expression one = i == 0 ? n.a : n.b;
      operand.push_back(value_of(written.graph, one, t, x, p));
      if (!std::isfinite(operand.back()) && !at_fault) at_fault = one;
    }
    if (at_fault) {
      node = *at_fault;
      value = value_of(written.graph, node, t, x, p);
      continue;
    }
    return NotFinite{place.value_or(otherwise), sentence_of(written, n, node, value, operand),
                     dependence(written.graph, node).moves()};
  }
}

std::optional<NotFinite> find_not_finite(const TextSystem& text, std::size_t mode, double t, const Vector& x, const Vector& p) {
  for (const Root& root : roots_of(text, mode))
    if (auto found = find_not_finite(written_of(text), root.expression, t, x, p, root.place)) return found;
  return std::nullopt;
}

std::optional<NotFinite> find_not_finite_guard(const TextSystem& text, double t, const Vector& x, const Vector& p) {
  for (const EventExpressions& event : text.events)
    if (auto found = find_not_finite(written_of(text), event.guard, t, x, p, event.when)) return found;
  return std::nullopt;
}

EquationError not_finite_error(const TextSystem& text, const NotFinite& found, double t, const Vector& x) {
  std::string where = is_forced(text.system) ? fmt::format("t = {:.9g}", t) : std::string();
  for (std::size_t i = 0; i < text.symbols.states.size(); ++i)
    where += fmt::format("{}{} = {:.9g}", where.empty() ? "" : ", ", text.symbols.states[i], x[static_cast<Eigen::Index>(i)]);
  return EquationError(text.source, found.place,
                       fmt::format("{} {}", found.sentence, found.moves ? "at " + where : "at these parameters"));
}

std::optional<NotFinite> find_not_finite_derivative(const TextSystem& text, std::size_t mode, double t, const Vector& x,
                                                    const Vector& p) {
  Graph graph = *text.graph;  // a copy: the graph of the text belongs to one thread
  const Written written{graph, text.symbols, text.hazards};
  const ModeExpressions& own = text.modes[mode];
  for (std::size_t i = 0; i < own.field.size(); ++i)
    for (const std::size_t j : dependence(graph, own.field[i]).states) {
      const Expression derivative = graph.derivative(own.field[i], graph.state(j));
      std::optional<NotFinite> found = find_not_finite(written, derivative, t, x, p, own.equation[i]);
      if (!found) continue;
      found->sentence = fmt::format("the derivative of the equation of {} in {} is not finite: {}", text.symbols.states[i],
                                    text.symbols.states[j], found->sentence);
      return found;
    }
  return std::nullopt;
}

std::optional<NotFinite> find_pole(const TextSystem& text, std::size_t mode, double t0, const Vector& x0, double t1,
                                   const Vector& x1, const Vector& p, bool adjacent) {
  for (const Root& root : roots_of(text, mode))
    for (const Expression part : reachable(*text.graph, root.expression)) {
      const Node n = text.graph->node(part);
      const bool tangent = n.operation == Operation::tan;  // sin/cos
      const std::optional<Expression> divisor = tangent ? std::optional(n.a) : divisor_of(*text.graph, part);
      if (!divisor) continue;
      const auto value = [&](double t, const Vector& x) {
        const double operand = value_of(*text.graph, *divisor, t, x, p);
        return tangent ? std::cos(operand) : operand;
      };
      const double before = value(t0, x0), after = value(t1, x1);
      const bool passes = before * after < 0.0, nears = adjacent && std::abs(after) < 0.5 * std::abs(before);
      if (!passes && !nears) continue;
      return NotFinite{known_place(*text.graph, text.hazards, part).value_or(root.place),
                       fmt::format("the {} {} goes {} zero", tangent ? "cosine, in the tangent, of" : "divisor",
                                   to_text(*text.graph, *divisor, text.symbols, longest_part), passes ? "through" : "to"),
                       true};
    }
  return std::nullopt;
}

std::optional<NotFinite> find_not_finite_reset(const TextSystem& text, std::size_t event, double t, const Vector& x,
                                               const Vector& p) {
  const EventExpressions& own = text.events[event];
  for (const Expression one : own.map)
    if (auto found = find_not_finite(written_of(text), one, t, x, p, own.reset)) return found;
  return std::nullopt;
}

}  // namespace graze::equations
