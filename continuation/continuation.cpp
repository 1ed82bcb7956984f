// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/continuation.hpp>

#include <graze/continuation/branch_follower.hpp>
#include <graze/continuation/branch_switching.hpp>

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

/// A grazing as it looks to someone who decreases the parameter: what is gained one way is lost the other.
SpecialPoint with_parameter_decreasing(SpecialPoint point, const Branch& branch) {
  const std::size_t k = point.after_point;
  const bool inside = k + 1 < branch.points.size();
  const double ahead = inside ? branch.points[k + 1].value : point.value;
  if (point.type != PointType::GR || k >= branch.points.size() || ahead < branch.points[k].value) return point;
  auto& impacts = std::get<std::vector<double>>(point.details["impacts"]);
  std::swap(impacts.front(), impacts.back());
  point.details["kind"] = impacts.back() < impacts.front() ? "lost" : "gained";
  point.orbit.impacts = static_cast<int>(impacts.front());
  return point;
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
      add(std::move(branch), 0, problem, u0, direction * problem.parameter_direction());
    }
    // Breadth first: a generation is complete before the next begins. Beyond a grazing the generation stays the same.
    for (std::size_t k = 0; k < branches_.size(); ++k) {
      if (ends_[k] && room()) follow_beyond_grazing(k);
      if (generation_[k] >= options_.switch_generations) continue;
      for (std::size_t s = 0; s < branches_[k].special_points.size(); ++s)
        if (branches_[k].special_points[s].type == PointType::PD && room()) follow_doubled(k, s);
    }
    return std::move(branches_);
  }

 private:
  bool room() const {
    return static_cast<int>(branches_.size()) < options_.max_branches && !(options_.cancelled && options_.cancelled());
  }

  void add(Branch branch, int generation, OrbitProblem& problem, const Vector& u0, const Vector& orientation) {
    ends_.push_back(follower_.follow(problem, u0, orientation, branch));
    if (ends_.back())
      edges_.push_back(
          edge(branch.special_points.back().orbit, branch.special_points.back().value, branch.points.back().impacts));
    generation_.push_back(generation);
    branches_.push_back(std::move(branch));
  }

  OrbitProblem problem_at(const PeriodicOrbit& orbit, int copies = 1) const {
    const double scale = std::max(range_.high - range_.low, 1e-6 * (1.0 + std::abs(range_.high)));
    return {system_, orbit.parameters,       copies * orbit.period, copies * static_cast<int>(orbit.nodes.size()), parameter_,
            scale,   options_.shooting.flow, orbit.section_phase};
  }

  Branch new_branch(const PeriodicOrbit& orbit, int period) {
    Branch branch;
    branch.id = static_cast<int>(branches_.size()) + 1;
    branch.period = period;
    branch.parameter = options_.parameter;
    branch.parameters = orbit.parameters;
    return branch;
  }

  void follow_doubled(std::size_t parent_index, std::size_t special_index) {
    SpecialPoint& pd = branches_[parent_index].special_points[special_index];
    PeriodicOrbit at_pd = pd.orbit;
    at_pd.parameters[static_cast<Eigen::Index>(parameter_)] = pd.value;
    OrbitProblem parent = problem_at(at_pd), doubled = problem_at(at_pd, 2);
    const std::optional<BranchStart> start = doubled_start(pd, parent, doubled, options_.trace);
    Branch branch = new_branch(at_pd, 2 * at_pd.period);
    branch.parent = BranchParent{branches_[parent_index].id, pd.label};
    if (start) {
      add(std::move(branch), generation_[parent_index] + 1, doubled, start->u, start->orientation);
      confirm_criticality(branches_.back(), branches_[parent_index].special_points[special_index], branches_[parent_index]);
      return;
    }
    branch.stop = BranchStop::start_failed;
    branch.stop_value = pd.value;
    branch.message = fmt::format("no doubled orbit was found beside {}", pd.label);
    ends_.emplace_back();
    generation_.push_back(generation_[parent_index] + 1);
    branches_.push_back(std::move(branch));
  }

  /// The orbits with the impact removed (or added) from the grazing on: they exist on one side of it only.
  void follow_beyond_grazing(std::size_t parent_index) {
    GrazingEnd end = *ends_[parent_index];
    const SpecialPoint point = branches_[parent_index].special_points.back();
    PeriodicOrbit at_grazing = point.orbit;
    int impacts = end.grazing.orbit.impacts + (end.lost ? 0 : 1);
    if (end.lost) impacts = impacts * to_least_period(at_grazing, end.grazing) / point.orbit.period;
    const GrazingEdge partner = edge(at_grazing, point.value, impacts);
    if (std::any_of(edges_.begin(), edges_.end(), [&](const GrazingEdge& known) { return same_edge(known, partner); })) return;
    edges_.push_back(partner);
    OrbitProblem problem = problem_at(at_grazing);
    const std::optional<BranchStart> start = partner_start(problem, end.grazing, end.lost, options_.trace);
    if (!start || problem.value(start->u) < range_.low || problem.value(start->u) > range_.high) return;
    Branch branch = new_branch(at_grazing, at_grazing.period);
    branch.parent = BranchParent{branches_[parent_index].id, point.label};
    add(std::move(branch), generation_[parent_index], problem, start->u, start->orientation);
  }

  /// The end of a family of orbits at a grazing: families that share one are the same.
  struct GrazingEdge {
    double value;
    int period, impacts;
    std::vector<Vector> states;
  };
  static GrazingEdge edge(const PeriodicOrbit& orbit, double value, int impacts) {
    return {value, orbit.period, impacts, orbit.states};
  }
  static bool same_edge(const GrazingEdge& a, const GrazingEdge& b) {
    const auto near = [](const Vector& x, const Vector& y) {
      return (x - y).lpNorm<Eigen::Infinity>() < 1e-9 * (1.0 + x.lpNorm<Eigen::Infinity>());
    };
    return a.period == b.period && a.impacts == b.impacts && std::abs(a.value - b.value) < 1e-9 * (1.0 + std::abs(a.value)) &&
           std::any_of(b.states.begin(), b.states.end(), [&](const Vector& x) { return near(x, a.states.front()); });
  }

  /// Without its weak impact the orbit may close after a divisor of its period: then that shorter orbit is the partner. Returns
  /// its period.
  static int to_least_period(PeriodicOrbit& orbit, LocatedGrazing& grazing) {
    const auto nodes = static_cast<Eigen::Index>(orbit.nodes.size()), n = orbit.state.size();
    for (int period = 1; period <= orbit.period / 2; ++period) {
      const Eigen::Index shift = nodes * period / orbit.period * n;
      if (orbit.period % period != 0 || nodes * period % orbit.period != 0) continue;
      const Vector u = grazing.u.head(nodes * n);
      if ((u.tail(nodes * n - shift) - u.head(nodes * n - shift)).lpNorm<Eigen::Infinity>() > 1e-10) continue;
      const auto shorten = [&](Vector& v) {
        Vector kept(shift + 1);
        kept << v.head(shift), v[v.size() - 1];
        v = kept;
      };
      shorten(grazing.u);
      shorten(grazing.family_dp);
      orbit.period = period;
      orbit.nodes.resize(static_cast<std::size_t>(shift / n));
      orbit.states.resize(static_cast<std::size_t>(period));
      return period;
    }
    return orbit.period;
  }

  const HybridSystem& system_;
  ContinuationOptions options_;
  std::size_t parameter_;
  Range range_;
  Labels labels_;
  BranchFollower follower_;
  std::vector<Branch> branches_;
  std::vector<int> generation_;
  std::vector<std::optional<GrazingEnd>> ends_;
  std::vector<GrazingEdge> edges_;
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
        if (nearer) result.point = with_parameter_decreasing(point, branch);
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
