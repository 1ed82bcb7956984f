// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/graph/continuation.hpp>

#include <graze/continuation/graph/branch_graph.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace graze {

namespace {

struct Range {
  double low, high;
};

Range range_of(const HybridSystem& system, std::size_t parameter, double from, double to) {
  const ParameterInfo& info = system.parameters[parameter];
  for (const double value : {from, to}) {
    if (!std::isfinite(value) || value < info.lower || value > info.upper || (info.lower_open && value == info.lower))
      throw std::invalid_argument(fmt::format("the range of {} goes to {}; allowed is {}", info.name, value, range_text(info)));
  }
  return {std::min(from, to), std::max(from, to)};
}

/// The interval near +- reach within the model's limits.
Range range_near(const ParameterInfo& info, double near, double reach) {
  if (!(reach > 0.0)) throw std::invalid_argument(fmt::format("the reach is {}; allowed is > 0", reach));
  Range range{std::max(near - reach, info.lower), std::min(near + reach, info.upper)};
  if (info.lower_open && range.low == info.lower) range.low += 1e-3 * (range.high - range.low);
  return range;
}

/// A grazing seen with the parameter decreasing: an impact gained in one direction is lost in the other.
SpecialPoint with_parameter_decreasing(SpecialPoint point, const Branch& branch) {
  const std::size_t k = point.after_point;
  const bool inside = k + 1 < branch.points.size();
  const double ahead = inside ? branch.points[k + 1].value : point.value;
  if (point.type != PointType::GR || k >= branch.points.size() || ahead < branch.points[k].value) return point;
  const auto impacts = std::get<std::vector<double>>(point.details["impacts"]);
  set_impacts(point, static_cast<int>(impacts.back()), static_cast<int>(impacts.front()));
  return point;
}

}  // namespace

std::vector<Branch> continue_orbit(const HybridSystem& system, const PeriodicOrbit& orbit, const ContinuationOptions& options) {
  const std::size_t parameter = parameter_index(system.parameters, options.parameter);
  if (!orbit.converged()) throw std::invalid_argument("continuation needs a converged orbit to start from");
  const double start = orbit.parameters[static_cast<Eigen::Index>(parameter)];
  const double from = options.from.value_or(start);
  const Range given = range_of(system, parameter, from, options.to);
  const Range range{std::min(given.low, start), std::max(given.high, start)};
  if (range.low == range.high)
    throw std::invalid_argument(fmt::format("the range of {} is empty: it starts and ends at {}", options.parameter, start));
  const int sign = options.to >= start ? 1 : -1;
  ContinuationOptions whole = options;
  whole.from = options.to >= start ? range.low : range.high;
  whole.to = options.to >= start ? range.high : range.low;
  BranchSeed seed{orbit, {sign}};
  if (options.both_directions) seed.directions.push_back(-sign);
  return follow_branches(system, {seed}, whole).branches;
}

std::vector<Branch> follow_near(const HybridSystem& system, const PeriodicOrbit& orbit, double near, double reach,
                                const ContinuationOptions& given) {
  const std::size_t parameter = parameter_index(system.parameters, given.parameter);
  const double start = orbit.parameters[static_cast<Eigen::Index>(parameter)];
  const Range within = range_near(system.parameters[parameter], near, reach);
  ContinuationOptions options = given;
  options.to = std::min(within.low, start);
  options.from = std::max(within.high, start);
  options.both_directions = true;
  options.switch_generations = 0;
  return continue_orbit(system, orbit, options);
}

LocateResult nearest_point(const HybridSystem& system, const std::vector<Branch>& branches, const std::string& parameter,
                           PointType type, double near, double reach) {
  const Range within = range_near(system.parameters[parameter_index(system.parameters, parameter)], near, reach);
  LocateResult result;
  std::vector<std::string> found, reasons;
  const auto add_once = [](std::vector<std::string>& list, std::string text) {
    if (std::find(list.begin(), list.end(), text) == list.end()) list.push_back(std::move(text));
  };
  for (const Branch& branch : branches) {
    for (const SpecialPoint& point : branch.special_points) {
      if (point.value < within.low || point.value > within.high) continue;
      if (point.type == type) {
        const bool nearer = !result.point || std::abs(point.value - near) < std::abs(result.point->value - near);
        if (nearer) result.point = with_parameter_decreasing(point, branch);
      } else if (point.type != PointType::EP) {
        add_once(found, fmt::format("{} at {:.9g}", point_type_name(point.type), point.value));
      }
    }
    if (branch.stop != BranchStop::reached_bound) add_once(reasons, branch.message);
  }
  if (result.point) return result;
  result.message =
      fmt::format("no {} lies on {} for {} in [{:.9g}, {:.9g}]; ", point_type_name(type),
                  branches.empty() ? "a branch" : "the branches that were followed", parameter, within.low, within.high);
  result.message += found.empty() ? "no special point was found" : fmt::format("found instead: {}", fmt::join(found, ", "));
  for (const std::string& reason : reasons) result.message += "; " + reason;
  return result;
}

LocateResult locate(const HybridSystem& system, const PeriodicOrbit& orbit, PointType type, double near, double reach,
                    const ContinuationOptions& options) {
  return nearest_point(system, follow_near(system, orbit, near, reach, options), options.parameter, type, near, reach);
}

}  // namespace graze
