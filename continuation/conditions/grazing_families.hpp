// SPDX-License-Identifier: GPL-3.0-or-later
// The families of orbits that begin at the grazing of a hard contact, several at one grazing (at other special points one branch
// is born: TestFunction::born). Their orbits have the impact or lack it, or have it in some of several turns.
#pragma once

#include <graze/continuation/conditions/birth.hpp>
#include <graze/continuation/conditions/grazing_edge.hpp>

#include <functional>
#include <optional>
#include <string>

namespace graze {

/// Largest number of contacts that may graze together.
inline constexpr int max_simultaneous_contacts = 8;

/// One of the families that may begin at a grazing. partner: the orbits without the impact that the branch loses, or with the one
/// that it gains. symmetric: those of an orbit that is symmetric in itself, which gain the impact and all its images together.
/// multiple: orbits of several turns, with the impact in some of them.
struct GrazingFamily {
  enum class Kind { partner, symmetric, multiple };
  Kind kind = Kind::partner;
  TurnPattern pattern = {};  ///< of a multiple
};

/// How the orbits of a family begin at a grazing.
struct GrazingBirth {
  GrazingEdge edge;     ///< of the family at the grazing
  PeriodicOrbit orbit;  ///< the grazing orbit, which the family's orbits approach
  int turns = 1;        ///< times that they follow it in their period
  /// Whether the edge identifies the family. Otherwise the number of its impacts is only known from the first orbit.
  bool identified = true;
  /// The family must exist unless orbits lead away from the grazing: message if none of its orbits is found. Empty: it need not.
  std::string missing = {};
  /// The first orbit, on the side of the grazing on which the family exists. Empty if none is found. `problem`: equations of
  /// `turns` times the orbit.
  std::function<std::optional<BranchStart>(OrbitProblem& problem, const TraceOptions& options)> start = {};
};

/// The birth of a family at the grazing `point`, on which a branch ended. Empty: the family does not exist there.
///
/// partner: exists on one side of the grazing only. If the orbits with a gained impact meet a barrier elsewhere at once, other
/// contacts graze too (the orbit is symmetric between two barriers); it then begins with the orbits with all of these impacts, if
/// they are admissible. symmetric: has no start if the orbits with all the images meet a barrier elsewhere at once, and where the
/// partner needs other coordinates than those of the events. multiple: the orbits of pattern.turns >= 2 times the period with the
/// weak impact in pattern.struck of the turns, on the side on which its speeds are positive. To first order the free maxima of
/// the turns are linear in the speeds, h_i = h_top + sum R_(i-j) v_j. With one impact h_i = -(R_0 - R_i) v, and the family is
/// admissible if R_i < R_0 in all other turns. It has no start if these maxima pass the barrier (decided on a solution 1e-6
/// away), if the orbit sticks elsewhere, or if the contact leads to another mode.
std::optional<GrazingBirth> birth_at_grazing(const GrazingFamily& family, const SpecialPoint& point, const GrazingEnd& end);

/// Decides between persistence and nonsmooth fold from the orbits of the branch that `ended` on the grazing and of the one
/// `beyond` (which begins there if `begins`, otherwise ends there): persistence if they are admissible on different sides of
/// the grazing, fold if on the same side. Two checks: the parity of multipliers beyond +1 (even, both families together:
/// persistence; Feigin's rule), and the linear response. The response takes precedence if the others contradict it, because a
/// smooth fold may lie between the grazing and the first orbit kept. Writes to the details of `grazing`, with
/// the impacts of the branch beyond: if several contacts touch together (an orbit symmetric between two barriers), it may have
/// one more impact, or as many more as contacts touch.
void confirm_scenario(SpecialPoint& grazing, const Branch& ended, const Branch& beyond, bool begins);

}  // namespace graze
