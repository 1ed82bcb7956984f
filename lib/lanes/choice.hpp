// SPDX-License-Identifier: GPL-3.0-or-later
// Choice: selects the next task of a register set, and exchanges motions between two register sets, so that the lanes of each
// are at the same task.
#pragma once

#include <graze/lib/lanes/memory.hpp>

#include <bit>
#include <utility>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// A task and the number of lanes at it.
struct Choice {
  Task task;
  int lanes;
};

/// The task that most lanes are at. The two longest tasks wait until enough lanes need them: a step of contact (with a table of
/// contacts such steps are rare, and fewer lanes suffice) and the end of a flight at the barrier (flights by series end within
/// a step).
template <class Real> [[gnu::always_inline]] inline Choice choose(const Memory<Real>& m, bool with_table, bool alone) {
  constexpr std::size_t W = width<Real>;
  if constexpr (W == 1) return {m.task(0), 1};  // there is nothing to choose
  const int most = static_cast<int>(with_table ? (W + 3) / 4 : alone ? (W + 1) / 2 : (7 * W + 7) / 8);
  constexpr int many = static_cast<int>((5 * W + 7) / 8);
  const int contacts = m.count(Task::contact), crossings = m.count(Task::crossing), flights = m.count(Task::flight),
            ends = m.count(Task::period_end), marching = m.count(Task::marching);
  const int others = marching + flights + ends;
  if (contacts >= most || (contacts > 0 && crossings + others == 0)) return {Task::contact, contacts};
  if (crossings >= many || (crossings > 0 && others == 0)) return {Task::crossing, crossings};
  if (marching > 0 && marching >= flights && marching >= ends) return {Task::marching, marching};
  if (flights > 0 && flights >= ends) return {Task::flight, flights};
  if (ends > 0) return {Task::period_end, ends};
  const int given_up = m.count(Task::given_up);  // only at the start: after a step there are none
  return {given_up > 0 ? Task::given_up : Task::idle, given_up};
}

/// Whether a register set should let the other go first: a step of contact, or of flight by series, takes as long for few lanes
/// as for all.
template <bool Cubic, class Real> bool waits(const Choice& choice) {
  const bool takes_long = choice.task == Task::contact || (Cubic && choice.task == Task::flight);
  return choice.task == Task::idle || (takes_long && choice.lanes < static_cast<int>(width<Real>));
}

/// Exchanges the motions in these lanes of two register sets.
template <class Real> void exchange(Memory<Real>& a, std::size_t i, Memory<Real>& b, std::size_t j) {
  if (a.coefficients_of[i] != b.coefficients_of[j])
    for (std::size_t k = 0; k < coefficients; ++k) std::swap(a.coefficient[k][i], b.coefficient[k][j]);
  for (std::size_t k = 0; k < fields; ++k) std::swap(a.field[k][i], b.field[k][j]);
  const Task of_a = a.task(i), of_b = b.task(j);
  a.assign(i, of_b);
  b.assign(j, of_a);
  std::swap(a.motion[i], b.motion[j]);
  std::swap(a.coefficients_of[i], b.coefficients_of[j]);
  std::swap(a.grid[i], b.grid[j]);
  std::swap(a.table[i], b.table[j]);
  std::swap(a.met[i], b.met[j]);
}

/// Gathers the motions in contact in one of two register sets, and the others in the other, as far as there is room.
template <class Real> void gather_contacts(Memory<Real>& a, Memory<Real>& b) {
  const bool more_in_a = a.count(Task::contact) >= b.count(Task::contact);
  Memory<Real>&many = more_in_a ? a : b, &few = more_in_a ? b : a;
  if (many.count(Task::contact) == 0) return;
  constexpr unsigned all = (1U << width<Real>)-1;
  const auto change_places = [&](unsigned come, unsigned go) {
    for (; come != 0 && go != 0; come &= come - 1, go &= go - 1)
      exchange(many, static_cast<std::size_t>(std::countr_zero(go)), few, static_cast<std::size_t>(std::countr_zero(come)));
  };
  change_places(few.at(Task::contact), all & ~many.at(Task::contact));
  change_places(few.at(Task::idle), all & ~(many.at(Task::contact) | many.at(Task::idle)));
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
