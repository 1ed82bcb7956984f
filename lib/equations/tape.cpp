// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/tape.hpp>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <unordered_map>

namespace graze::equations {

Tape::Tape(const Graph& graph, std::span<const Expression> outputs) {
  const std::vector<Expression> nodes = reachable(graph, outputs);
  std::unordered_map<std::uint32_t, Part> part_of;
  // argument -> its sine and cosine
  std::unordered_map<std::uint32_t, std::pair<std::optional<Expression>, std::optional<Expression>>> turns;
  for (const Expression e : nodes) {
    const Node& n = graph.node(e);
    if (n.operation == Operation::rate) throw std::invalid_argument("a rate was evaluated before its mode was known");
    const int count = operands(n.operation);
    Part part = n.operation == Operation::time ? of_time : n.operation == Operation::state ? of_states : of_parameters;
    if (count > 0) part = std::max(part, part_of.at(n.a.index));
    if (count > 1) part = std::max(part, part_of.at(n.b.index));
    part_of[e.index] = part;
    if (n.operation == Operation::sin) turns[n.a.index].first = e;
    if (n.operation == Operation::cos) turns[n.a.index].second = e;
  }
  std::unordered_map<std::uint32_t, std::uint32_t> slot;
  const auto add_leaves = [&](Operation operation) {
    for (const Expression e : nodes) {
      const Node& n = graph.node(e);
      if (n.operation != operation) continue;
      slot[e.index] = static_cast<std::uint32_t>(leaves_.size());
      leaves_.push_back({n.index, n.value});
    }
    return leaves_.size();
  };
  has_pi_ = add_leaves(Operation::pi) > 0;
  constants_ = add_leaves(Operation::constant);
  parameters_ = add_leaves(Operation::parameter);
  times_ = add_leaves(Operation::time);
  add_leaves(Operation::state);
  const auto place = [&](Expression e, bool with_cosine) {
    const Node& n = graph.node(e);
    slot[e.index] = static_cast<std::uint32_t>(workspace());
    instructions_.push_back({.operation = n.operation,
                             .with_cosine = with_cosine,
                             .a = slot.at(n.a.index),
                             .b = operands(n.operation) > 1 ? slot.at(n.b.index) : 0,
                             .index = n.index,
                             .value = n.value});
  };
  for (std::size_t part = 0; part < parts; ++part) {
    begin_[part] = instructions_.size();
    for (const Expression e : nodes) {
      if (part_of[e.index] != part || slot.contains(e.index)) continue;
      const Node& n = graph.node(e);
      if (n.operation == Operation::sin || n.operation == Operation::cos) {
        const auto& [sine, cosine] = turns.at(n.a.index);
        if (sine && cosine) {
          place(*sine, true);
          place(*cosine, false);
          continue;
        }
      }
      place(e, false);
    }
  }
  begin_[parts] = instructions_.size();
  for (const Expression e : outputs) outputs_.push_back(slot.at(e.index));
  const bool needs_tables = std::any_of(instructions_.begin(), instructions_.end(),
                                        [](const Instruction& q) { return q.operation == Operation::spline; });
  if (needs_tables) splines_ = graph.splines();
}

}  // namespace graze::equations
