// SPDX-License-Identifier: GPL-3.0-or-later
// SpecialPoint: a point of a branch that has a name: how it was located, how well, and between which values it lies.
#pragma once

#include <graze/floquet/periodic_orbit.hpp>

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace graze {

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

/// Whether the orbit at the point is stable. Empty where that is not for its multipliers to tell: the point is marginal, or the
/// return map has no derivative there (the grazing of a hard contact).
std::optional<bool> stable_at(const SpecialPoint& point);

}  // namespace graze
