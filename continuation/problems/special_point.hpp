// SPDX-License-Identifier: GPL-3.0-or-later
// SpecialPoint: a point of a branch that has a name: how it was located, how well, and between which values it lies.
#pragma once

#include <graze/floquet/orbit/periodic_orbit.hpp>

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace graze {

/// What lies beyond the grazing of a hard contact (Nordmark, J. Sound Vib. 145 (1991) 279; di Bernardo et al. 2008, ch. 7). To
/// first order in its speed v an orbit with the weak impact exists where the free maximum of the guard, continued as if nothing
/// were there, would be h_top = response v: beyond the barrier (response > 0: persistence, the impacting orbit takes over) or
/// short of it (response < 0: nonsmooth fold, the two annihilate). For one impact per n periods of a linear oscillator its sign
/// is that of sin(sqrt(1 - b^2) n T).
///
/// One of the two always happens at a nondegenerate grazing: with the weak impact's speed as unknown the equations of the orbit
/// are smooth through v = 0 (Ghosh & Simpson, arXiv 2510.16218; Simpson & Ghosh, arXiv 2602.22797, use it in the same way), and
/// where det(I - M) is not 0 (M: monodromy without that contact), d h_top / d parameter not 0 and the response neither 0 nor
/// infinite, the implicit function theorem gives one solution for every small v of either sign, on a curve whose parameter moves
/// with v at a rate that is not 0: those with v > 0 lie on one side. They are admissible near the grazing: after the weak impact
/// the motion leaves the barrier (curvature < 0), other impacts keep their speeds and other maxima their distance, both positive
/// at the grazing. How near is another matter: as near as the smallest of these speeds and distances over their own responses,
/// which grow with the multipliers. The third outcome of border collisions, neither orbit on one side, needs both on the other:
/// that is the nonsmooth fold.
///
/// Where several contacts touch at once (an orbit symmetric between two barriers) the speeds v >= 0 solve a linear
/// complementarity problem, R v >= h_top with equality where v > 0. The numbers of its solutions on both sides of the grazing are
/// both even or both odd, and the orbit without any impact is one of them: then too another family begins, with one of the
/// impacts or with several.
///
/// `none`, no admissible orbit beyond the grazing, is kept for contacts after which the motion does not return (they lead to
/// another mode); `undecided` for degenerate grazings (response 0 or infinite) and those of orbits that stick, where no partner
/// was found.
enum class GrazingScenario { unknown, smooth, persistence, nonsmooth_fold, none, undecided };
std::string_view grazing_scenario_name(GrazingScenario scenario);

enum class PointType { EP, LP, PD, BP, NS, GR, UZ, MX };

/// "EP", "LP", ... and back. @throws std::invalid_argument with the valid names.
std::string_view point_type_name(PointType type);
PointType point_type(std::string_view name);

enum class PointStatus { bracketed, converged };

/// Details are small named values: text, a number, or numbers (grazing: impacts before and after).
using Detail = std::variant<std::string, double, std::vector<double>>;

struct SpecialPoint {
  PointType type = PointType::MX;
  std::string label;    ///< type and running number along the run, for example "PD1"
  double value = 0.0;   ///< of the continuation parameter
  PeriodicOrbit orbit;  ///< at the point, period and impacts those of the branch it lies on
  PointStatus status = PointStatus::bracketed;
  double precision = 0.0;       ///< estimated error of `value`
  double interval[2] = {0, 0};  ///< values between which the point certainly lies
  std::size_t after_point = 0;  ///< it lies between points[after_point] and points[after_point + 1] of the branch
  NewtonReport newton;          ///< of the extended system
  std::map<std::string, Detail> details;
  /// Of a grazing: the contacts that touch, as events of speed zero. Among those of the orbit where its impacts count them.
  std::vector<EventRecord> touching = {};
};

/// Of a grazing: impacts before and after, "lost" or "gained", and those of its orbit (those in complete chatters are as they
/// were), with the contacts that touch where they are lost.
void set_impacts(SpecialPoint& grazing, int before, int after);

/// Located by a multiplier on the unit circle (LP, PD, BP, NS): rounding puts it inside or outside.
bool is_marginal(PointType type);

/// Whether the scenario of a grazing is smooth: its orbit has derivatives there.
bool is_smooth(const SpecialPoint& grazing);

/// Whether the orbit at the point is stable. Empty where that is not for its multipliers to tell: the point is marginal, or the
/// return map has no derivative there (the grazing of a hard contact).
std::optional<bool> stable_at(const SpecialPoint& point);

}  // namespace graze
