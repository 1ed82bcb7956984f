// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/output/notes.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/lib/motion/sampled_motion.hpp>

#include <graze/lib/motion/order_of_events.hpp>

#include <fmt/format.h>

#include <algorithm>

namespace graze::apps {

namespace {

/// Whether two different events change the state.
bool can_meet(const HybridSystem& system) {
  const Event* first = nullptr;
  for (const Event& event : system.events) {
    if (!event.reset.map) continue;
    if (first && first->name != event.name) return true;
    first = &event;
  }
  return false;
}

std::string shown(const Problem& problem, const Vector& state) {
  const std::vector<std::string> names = state_columns(problem);
  std::vector<std::string> list;
  for (std::size_t i = 0; i < names.size(); ++i)
    list.push_back(fmt::format("{} = {}", names[i], rounded(state[static_cast<Eigen::Index>(i)] + 0.0, 9)));  // + 0.0: no -0
  return fmt::format("{}", fmt::join(list, ", "));
}

}  // namespace

std::vector<std::string> order_notes(const Problem& problem, const std::vector<EventRecord>& events) {
  std::vector<std::string> notes;
  for (const OrderedPair& pair : noncommuting_events(problem.system, problem.parameters, events))
    notes.push_back(
        fmt::format("{0} and {1} meet at tau = {2}, and their order matters: {0} goes first and leads to {3}, {1} first "
                    "would lead to {4}",
                    problem.system.events[pair.first].name, problem.system.events[pair.second].name, rounded(pair.t, 9),
                    shown(problem, pair.x_plus), shown(problem, pair.x_plus_other)));
  return notes;
}

std::vector<std::string> order_notes(const Problem& problem, const Vector& state, int periods) {
  if (!can_meet(problem.system) || !mode_at(problem.system, 0.0, state, problem.parameters)) return {};
  return order_notes(problem, run_motion(problem.system, problem.parameters, state, {.periods = periods}).events);
}

std::vector<std::string> order_notes(const Problem& problem, const std::string& parameter, const std::vector<SweepRow>& rows) {
  if (!can_meet(problem.system)) return {};
  Problem at = problem;
  for (const SweepRow& row : rows) {
    set_parameter(at, parameter, row.value);
    std::vector<std::string> notes = order_notes(at, row.attractor.state, std::max(1, row.attractor.period));
    if (!notes.empty()) return notes;
  }
  return {};
}

std::vector<std::string> branch_notes(const Problem& problem, const PeriodicOrbit& orbit) {
  constexpr double small = 0.01;
  std::vector<std::string> notes = order_notes(problem, orbit.events);
  double size = 0.0;
  for (const Vector& state : orbit.states) size = std::max(size, state.lpNorm<Eigen::Infinity>());
  for (const EventRecord& event : orbit.events) size = std::max(size, event.x_minus.lpNorm<Eigen::Infinity>());
  if (size > 0.0 && size < small)
    notes.push_back(
        fmt::format("the states of the orbit are of size {:.0e}, but tolerances are relative to 1 + |x|: branches may "
                    "miss points or end falsely; with other units of length and time, in which states are of order 1, "
                    "they do not",
                    size));
  return notes;
}

void add_notes(Result& result, const std::vector<std::string>& notes) {
  if (!notes.empty()) result.json["notes"] = notes;
  for (const std::string& note : notes) result.text += fmt::format("\nnote: {}\n", note);
}

}  // namespace graze::apps
