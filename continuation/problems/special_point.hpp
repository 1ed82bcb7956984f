// SPDX-License-Identifier: GPL-3.0-or-later
// SpecialPoint: a bifurcation, grazing or other labelled point of a branch, with its type, precision and bracket.
#pragma once

#include <graze/floquet/orbit/periodic_orbit.hpp>

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace graze {

/// Orbits beyond the grazing of a hard contact (Nordmark, J. Sound Vib. 145 (1991) 279; di Bernardo et al. 2008, ch. 7).
///
/// Let h_top be the free maximum of the guard function, continued as if there were no barrier, and v the speed of the weak
/// impact. To first order in v the orbit with the weak impact exists at h_top = response v. If response > 0 this is beyond the
/// barrier: persistence, the impacting orbit replaces the other one. If response < 0 it is before the barrier: nonsmooth fold,
/// both orbits exist on the same side and annihilate at the grazing. For one impact per n periods of a linear oscillator the
/// sign of the response is that of sin(sqrt(1 - b^2) n T).
///
/// At a nondegenerate grazing one of these two cases always occurs. Proof: with v as an unknown the equations of the orbit are
/// smooth through v = 0 (Ghosh & Simpson, arXiv 2510.16218; Simpson & Ghosh, arXiv 2602.22797, use it in the same way). Let M
/// be the monodromy matrix without the contact. If det(I - M) != 0, d h_top / d parameter != 0, and the response is neither 0
/// nor infinite, the implicit function theorem gives one solution for each small v of either sign. These solutions form a
/// curve, and the parameter changes along it at a nonzero rate in v. The solutions with v > 0 therefore lie on one side.
///
/// These solutions are admissible near the grazing. After the weak impact the motion leaves the barrier (curvature < 0). Other
/// impacts keep their speeds and other maxima their distances, which are positive at the grazing. The size of this
/// neighbourhood is the smallest ratio of such a speed or distance to its own response, and these responses grow with the
/// multipliers. The third outcome of border collisions, no orbit on one side, requires both orbits on the other side: this is
/// the nonsmooth fold.
///
/// If several contacts touch at once (an orbit symmetric between two barriers), their speeds v >= 0 solve a linear
/// complementarity problem: R v >= h_top, with equality for each v > 0. The numbers of its solutions on the two sides of the
/// grazing are both even or both odd, and the orbit without impacts is one of them. Therefore another family begins in this
/// case too, with one or several of the impacts.
///
/// `none`: no admissible orbit exists beyond the grazing, because the contact leads to another mode and the motion does not
/// return. `undecided`: no partner was found at a degenerate grazing (response 0 or infinite) or for an orbit that sticks.
enum class GrazingScenario { unknown, smooth, persistence, nonsmooth_fold, none, undecided };
std::string_view grazing_scenario_name(GrazingScenario scenario);

/// EP: end of the branch; LP: fold (limit point); PD: period doubling; BP: branch point; NS: Neimark-Sacker; GR: grazing; UZ: a
/// value given by the user; MX: end of the branch because the corrector fails at the smallest step.
enum class PointType { EP, LP, PD, BP, NS, GR, UZ, MX };

/// "EP", "LP", ... and back. @throws std::invalid_argument with the valid names.
std::string_view point_type_name(PointType type);
PointType point_type(std::string_view given);

enum class PointStatus { bracketed, converged };

/// Value of a named detail: a text, a number, or several numbers (grazing: the impacts before and after).
using Detail = std::variant<std::string, double, std::vector<double>>;

struct SpecialPoint {
  PointType type = PointType::MX;
  std::string label;    ///< type and running number along the run, for example "PD1"
  double value = 0.0;   ///< of the continuation parameter
  PeriodicOrbit orbit;  ///< at the point; period and impacts are those of its branch
  PointStatus status = PointStatus::bracketed;
  double precision = 0.0;       ///< estimated error of `value`
  double interval[2] = {0, 0};  ///< parameter values that bracket the point
  std::size_t after_point = 0;  ///< the point lies between points[after_point] and points[after_point + 1] of the branch
  NewtonReport newton;          ///< of the extended system
  std::map<std::string, Detail> details;
  /// For a grazing: the touching contacts as events of speed zero. They are also among the events of `orbit` if its number of
  /// impacts counts them.
  std::vector<EventRecord> touching = {};
};

/// Sets the numbers of impacts before and after a grazing: the details "impacts" and "kind" ("lost" or "gained"), and the
/// numbers of impacts of its orbit (those in complete chatters stay the same). If impacts are lost, the touching contacts are
/// added to the events of the orbit; otherwise they are removed.
void set_impacts(SpecialPoint& grazing, int before, int after);

/// Whether the type is defined by a multiplier on the unit circle (LP, PD, BP, NS). Rounding puts that multiplier inside or
/// outside.
bool is_marginal(PointType type);

/// Whether the scenario of a grazing is smooth: the return map has a derivative there.
bool is_smooth(const SpecialPoint& grazing);

/// Whether the orbit at the point is stable. Empty if its multipliers cannot decide: the point is marginal, the return map has
/// no derivative there (grazing of a hard contact), or the multipliers are not valid.
std::optional<bool> stable_at(const SpecialPoint& point);

}  // namespace graze
