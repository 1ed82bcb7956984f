// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/continuation.hpp>

#include <graze/continuation/branch_follower.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace graze {

namespace {

/// Hands out "PD1", "PD2", "LP1", ... over a whole run.
class Labels {
 public:
  std::string next(PointType type) { return fmt::format("{}{}", point_type_name(type), ++count_[type]); }

 private:
  std::map<PointType, int> count_;
};

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

/// The first point of the branch that is born at a period doubling: the orbit run through twice, pushed apart along the
/// eigenvector of -1. The corrector's arclength condition keeps the push, so that it cannot fall back onto the parent.
struct DoubledStart {
  Vector u, orientation;
};

std::optional<DoubledStart> doubled_start(const HybridSystem& system, const SpecialPoint& pd, OrbitProblem& parent,
                                          OrbitProblem& doubled, const TraceOptions& options) {
  const double value = pd.value;
  std::vector<Vector> twice = pd.orbit.nodes;
  twice.insert(twice.end(), pd.orbit.nodes.begin(), pd.orbit.nodes.end());
  const Vector at_birth = doubled.pack(twice, 2.0 * pd.orbit.duration, value);
  const LocatedPoint located =
      locate_multiplier(parent, parent.pack(pd.orbit.nodes, pd.orbit.duration, value), {.theta = std::numbers::pi});
  if (located.v.size() == 0) return std::nullopt;
  const Vector v = located.v.real();
  Vector direction = Vector::Zero(at_birth.size());
  direction.head(v.size()) = v;
  direction.segment(v.size(), v.size()) = -v;
  const ZeroProblem zero = doubled.zero_problem();
  direction /= std::sqrt(zero.weights.dot(direction.cwiseAbs2()));
  static_cast<void>(system);
  for (double push = 2e-3; push > 1e-6; push *= 0.5) {
    DoubledStart start{at_birth + push * direction, {}};
    if (!correct(zero, direction, start.u, options).converged()) continue;
    start.orientation = start.u - at_birth;
    const double length = std::sqrt(zero.weights.dot(start.orientation.cwiseAbs2()));
    if (length < 1.5 * push) return start;  // a correction as long as the push has found something else
  }
  return std::nullopt;
}

/// Compares the side on which the doubled branch starts with the normal form's prediction.
void confirm_criticality(const Branch& child, SpecialPoint& pd, const Branch& parent) {
  if (child.points.empty()) return;
  const std::size_t k = pd.after_point;
  if (k + 1 >= parent.points.size()) return;
  const BranchPoint &before = parent.points[k], &after = parent.points[k + 1];
  const bool unstable_above = (after.multipliers.unstable() > before.multipliers.unstable()) == (after.value > before.value);
  const bool child_above = child.points.front().value > pd.value;
  // Supercritical: the doubled orbit lives where its parent has become unstable.
  const std::string seen = unstable_above == child_above ? "supercritical" : "subcritical";
  const auto predicted = pd.details.find("criticality");
  if (predicted == pd.details.end()) {
    pd.details["criticality"] = seen;
    pd.details["criticality_from"] = "branch";
    return;
  }
  const bool agrees = std::get<std::string>(predicted->second) == seen;
  pd.details["criticality_from"] =
      agrees ? "normal form, confirmed by the branch" : "normal form; the branch starts on the other side";
}

class Run {
 public:
  Run(const HybridSystem& system, const ContinuationOptions& options, std::size_t parameter, Range range)
      : system_(system), options_(options), parameter_(parameter), range_(range),
        follower_(system, options_, range.low, range.high, [this](PointType type) { return labels_.next(type); }) {}

  std::vector<Branch> all(const PeriodicOrbit& orbit) {
    const auto index = static_cast<Eigen::Index>(parameter_);
    const double start = orbit.parameters[index];
    const double sign = options_.to >= start ? 1.0 : -1.0;
    OrbitProblem problem = problem_at(orbit);
    const Vector u0 = problem.pack(orbit.nodes, orbit.duration, start);
    for (const double direction : {sign, -sign}) {
      if (direction != sign && !options_.both_directions) break;
      Branch branch = new_branch(orbit, orbit.period);
      follower_.follow(problem, u0, direction * problem.parameter_direction(), branch);
      branches_.push_back(std::move(branch));
    }
    // Breadth first: a generation is complete before the next begins.
    const std::size_t first_generation = branches_.size();
    std::vector<int> generation(first_generation, 0);
    for (std::size_t k = 0; k < branches_.size(); ++k) {
      if (generation[k] >= options_.switch_generations) continue;
      for (std::size_t s = 0; s < branches_[k].special_points.size(); ++s) {
        if (branches_[k].special_points[s].type != PointType::PD || cancelled()) continue;
        if (static_cast<int>(branches_.size()) >= options_.max_branches) break;
        if (follow_doubled(k, s)) generation.push_back(generation[k] + 1);
      }
    }
    return std::move(branches_);
  }

 private:
  bool cancelled() const { return options_.cancelled && options_.cancelled(); }

  OrbitProblem problem_at(const PeriodicOrbit& orbit, int copies = 1) const {
    const double scale = std::max(range_.high - range_.low, 1e-6 * (1.0 + std::abs(range_.high)));
    return {system_, orbit.parameters,      copies * orbit.period, copies * static_cast<int>(orbit.nodes.size()), parameter_,
            scale,   options_.shooting.flow};
  }

  Branch new_branch(const PeriodicOrbit& orbit, int period) {
    Branch branch;
    branch.id = static_cast<int>(branches_.size()) + 1;
    branch.period = period;
    branch.parameter = options_.parameter;
    branch.parameters = orbit.parameters;
    return branch;
  }

  bool follow_doubled(std::size_t parent_index, std::size_t special_index) {
    SpecialPoint& pd = branches_[parent_index].special_points[special_index];
    PeriodicOrbit at_pd = pd.orbit;
    at_pd.parameters[static_cast<Eigen::Index>(parameter_)] = pd.value;
    OrbitProblem parent = problem_at(at_pd), doubled = problem_at(at_pd, 2);
    const std::optional<DoubledStart> start = doubled_start(system_, pd, parent, doubled, options_.trace);
    Branch branch = new_branch(at_pd, 2 * at_pd.period);
    branch.parent = BranchParent{branches_[parent_index].id, pd.label};
    if (start) {
      follower_.follow(doubled, start->u, start->orientation, branch);
      confirm_criticality(branch, pd, branches_[parent_index]);
    } else {
      branch.stop = BranchStop::start_failed;
      branch.stop_value = pd.value;
      branch.message = fmt::format("no doubled orbit was found beside {}", pd.label);
    }
    branches_.push_back(std::move(branch));
    return true;
  }

  const HybridSystem& system_;
  ContinuationOptions options_;
  std::size_t parameter_;
  Range range_;
  Labels labels_;
  BranchFollower follower_;
  std::vector<Branch> branches_;
};

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
  return Run(system, options, parameter, range).all(orbit);
}

LocateResult locate(const HybridSystem& system, const PeriodicOrbit& orbit, PointType type, double near, double reach,
                    const ContinuationOptions& given) {
  LocateResult result;
  const std::size_t parameter = parameter_index(system.parameters, given.parameter);
  const ParameterInfo& info = system.parameters[parameter];
  const double start = orbit.parameters[static_cast<Eigen::Index>(parameter)];
  if (!(reach > 0.0)) throw std::invalid_argument(fmt::format("the reach is {}; allowed is > 0", reach));
  double low = std::max(near - reach, info.lower), high = std::min(near + reach, info.upper);
  if (info.lower_open && low == info.lower) low += 1e-3 * (high - low);
  ContinuationOptions options = given;
  options.to = std::min(low, start);
  options.from = std::max(high, start);
  options.both_directions = true;
  options.switch_generations = 0;
  const std::vector<Branch> branches = continue_orbit(system, orbit, options);
  std::string met;
  for (const Branch& branch : branches) {
    for (const SpecialPoint& point : branch.special_points) {
      if (point.type == type) {
        const bool nearer = !result.point || std::abs(point.value - near) < std::abs(result.point->value - near);
        if (nearer) result.point = point;
      } else if (point.type != PointType::EP) {
        met += fmt::format("{}{} at {:.9g}", met.empty() ? "" : ", ", point_type_name(point.type), point.value);
      }
    }
  }
  if (!result.point) {
    result.message = fmt::format("no {} lies on the branch of this orbit for {} in [{:.9g}, {:.9g}]; ", point_type_name(type),
                                 given.parameter, options.to, *options.from);
    result.message += met.empty() ? "no special point was met" : "met were " + met;
    for (const Branch& branch : branches)
      if (branch.stop != BranchStop::reached_bound) result.message += "; " + branch.message;
  }
  return result;
}

}  // namespace graze
