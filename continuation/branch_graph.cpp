// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch_graph.hpp>

#include <graze/continuation/branch_follower.hpp>
#include <graze/continuation/branch_switching.hpp>
#include <graze/continuation/grazing_edge.hpp>

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <deque>
#include <map>
#include <mutex>

namespace graze {

namespace {

/// Branches followed before what they brought is taken up. Fixed, so that the result does not depend on the number of threads.
constexpr std::size_t round_size = 4;

/// Hands out "PD1", "PD2", "LP1", ... over a whole run.
class Labels {
 public:
  std::string next(PointType type) { return fmt::format("{}{}", point_type_name(type), ++count_[type]); }
  /// A label that is taken already.
  void take(const SpecialPoint& point) {
    const std::string number = point.label.substr(std::min(point.label.size(), point_type_name(point.type).size()));
    int value = 0;
    std::from_chars(number.data(), number.data() + number.size(), value);
    count_[point.type] = std::max(count_[point.type], value);
  }

 private:
  std::map<PointType, int> count_;
};

enum class Origin { seed, doubled, beyond_grazing };

/// A branch to be followed.
struct Task {
  Origin origin = Origin::seed;
  PeriodicOrbit orbit;  ///< seed
  int direction = 1;
  std::size_t parent = 0, special = 0;  ///< the accepted branch and its special point
  int generation = 0;
  int seed = 0;  ///< number of the seed, from 1; 0: none. Both directions from a seed have the same.
};

struct Outcome {
  std::optional<Branch> branch;             ///< empty: nothing new begins there
  std::optional<GrazingEnd> grazing;        ///< on which it ended
  std::optional<PeriodicOrbit> half;        ///< the orbit of half the period to which it returned
  std::optional<GrazingEdge> begins, ends;  ///< at grazings
};

class Graph {
 public:
  Graph(const HybridSystem& system, const ContinuationOptions& options)
      : system_(system), options_(options), parameter_(parameter_index(system.parameters, options.parameter)),
        low_(std::min(*options.from, options.to)), high_(std::max(*options.from, options.to)) {
    if (options.progress) {
      options_.progress = [this, tell = options.progress](const Branch& branch) {
        const std::lock_guard lock(progress_);
        tell(branch);
      };
    }
  }

  BranchGraph all(const std::vector<BranchSeed>& seeds, const std::vector<Branch>& so_far) {
    for (const Branch& branch : so_far)
      if (branch.stop != BranchStop::interrupted && !branch.points.empty()) restore(branch);
    for (const BranchSeed& seed : seeds) add_seed(seed, 0);
    oneapi::tbb::task_arena arena(std::max(1, options_.threads));
    while (!(tasks_.empty() && seed_tasks_.empty()) && !cancelled()) {
      if (static_cast<int>(graph_.branches.size()) >= options_.max_branches) {
        cut_off_rest(fmt::format("{} branches are the limit", options_.max_branches));
        break;
      }
      std::vector<Task> round;
      for (; !tasks_.empty() && round.size() < round_size; tasks_.pop_front()) round.push_back(std::move(tasks_.front()));
      // The next seed only when all that hangs together with the last one is done: most of the others lie on it.
      if (round.empty()) {
        const int seed = seed_tasks_.front().seed;
        for (; !seed_tasks_.empty() && seed_tasks_.front().seed == seed; seed_tasks_.pop_front())
          round.push_back(std::move(seed_tasks_.front()));
      }
      std::vector<Outcome> outcomes(round.size());
      const std::size_t known = graph_.branches.size();
      arena.execute([&] {
        oneapi::tbb::parallel_for(std::size_t{0}, round.size(), [&](std::size_t k) {
          if (!cancelled()) outcomes[k] = follow(round[k], static_cast<int>(known + k) + 1);
        });
      });
      for (std::size_t k = 0; k < round.size(); ++k) {
        const bool full = static_cast<int>(graph_.branches.size()) >= options_.max_branches;
        if (outcomes[k].branch && !full) {
          accept(round[k], std::move(outcomes[k]));
        } else if (outcomes[k].branch || cancelled()) {
          cut_off(round[k], full ? fmt::format("{} branches are the limit", options_.max_branches) : "it was interrupted");
        }
      }
    }
    graph_.interrupted = cancelled();
    if (graph_.interrupted) cut_off_rest("it was interrupted");
    return std::move(graph_);
  }

 private:
  bool cancelled() const { return options_.cancelled && options_.cancelled(); }

  void cut_off(const Task& task, std::string reason) {
    if (task.origin == Origin::seed) {
      graph_.cut_off.push_back({0, "seed", std::move(reason)});
      return;
    }
    const Branch& parent = graph_.branches[task.parent];
    graph_.cut_off.push_back({parent.id, parent.special_points[task.special].label, std::move(reason)});
  }

  void cut_off_rest(const std::string& reason) {
    for (const auto& queue : {tasks_, seed_tasks_})
      for (const Task& task : queue) cut_off(task, reason);
  }

  void add_seed(const BranchSeed& seed, int generation) {
    ++last_seed_;
    for (const int direction : seed.directions) {
      Task task{Origin::seed, seed.orbit, direction, 0, 0, generation};
      task.seed = last_seed_;
      seed_tasks_.push_back(std::move(task));
    }
  }

  OrbitProblem problem_at(const PeriodicOrbit& orbit, int copies = 1) const {
    const double scale = std::max(high_ - low_, 1e-6 * (1.0 + std::abs(high_)));
    return {system_, orbit.parameters,       copies * orbit.period, copies * static_cast<int>(orbit.nodes.size()), parameter_,
            scale,   options_.shooting.flow, orbit.section_phase};
  }

  double value_of(const PeriodicOrbit& orbit) const { return orbit.parameters[static_cast<Eigen::Index>(parameter_)]; }

  /// Branches from the seed `except` do not count.
  bool is_known(const std::vector<Vector>& states, double value, int except = 0) const {
    for (std::size_t k = 0; k < graph_.branches.size(); ++k)
      if ((except == 0 || seeds_[k] != except) && lies_on(system_, graph_.branches[k], states, value)) return true;
    return false;
  }

  bool is_known(const GrazingEdge& edge) const {
    return std::any_of(edges_.begin(), edges_.end(), [&](const GrazingEdge& known) { return same_edge(known, edge); });
  }

  static GrazingEdge edge_at(const SpecialPoint& point, const PeriodicOrbit& orbit, int impacts) {
    return {point.value, orbit.period, impacts, orbit.states};
  }

  Branch new_branch(const PeriodicOrbit& orbit, int period, int provisional_id) const {
    Branch branch;
    branch.id = provisional_id;
    branch.period = period;
    branch.parameter = options_.parameter;
    branch.parameters = orbit.parameters;
    return branch;
  }

  // What follows up to accept() is run side by side, and only looks at what is there.

  Outcome follow(const Task& task, int provisional_id) const {
    switch (task.origin) {
    case Origin::seed:
      return follow_seed(task, provisional_id);
    case Origin::doubled:
      return follow_doubled(task, provisional_id);
    case Origin::beyond_grazing:
      return follow_beyond_grazing(task, provisional_id);
    }
    return {};
  }

  void follow_from(const BranchStart& start, OrbitProblem& problem, Branch branch, Outcome& out) const {
    ContinuationOptions options = options_;
    if (start.step > 0.0) options.trace.initial_step = start.step;
    BranchFollower follower(system_, options, low_, high_);
    out.grazing = follower.follow(problem, start, branch);
    if (out.grazing)
      out.ends = edge_at(branch.special_points.back(), branch.special_points.back().orbit, branch.points.back().impacts);
    if (branch.stop == BranchStop::returned && branch.period % 2 == 0 && options_.follow_parents) out.half = half_of(branch);
    out.branch = std::move(branch);
  }

  Outcome follow_seed(const Task& task, int provisional_id) const {
    Outcome out;
    const double value = value_of(task.orbit);
    if (task.direction > 0 ? value >= high_ : value <= low_) return out;  // straight out of the range
    if (is_known(task.orbit.states, value, task.seed)) return out;
    OrbitProblem problem = problem_at(task.orbit);
    const Vector u = problem.pack(task.orbit.nodes, task.orbit.duration, value);
    follow_from({u, task.direction * problem.parameter_direction()}, problem,
                new_branch(task.orbit, task.orbit.period, provisional_id), out);
    return out;
  }

  Outcome follow_doubled(const Task& task, int provisional_id) const {
    Outcome out;
    const SpecialPoint& pd = graph_.branches[task.parent].special_points[task.special];
    PeriodicOrbit at_pd = pd.orbit;
    at_pd.parameters[static_cast<Eigen::Index>(parameter_)] = pd.value;
    OrbitProblem parent = problem_at(at_pd), doubled = problem_at(at_pd, 2);
    Branch branch = new_branch(at_pd, 2 * at_pd.period, provisional_id);
    branch.parent = BranchParent{graph_.branches[task.parent].id, pd.label};
    if (const std::optional<BranchStart> start = doubled_start(pd, parent, doubled, options_.trace)) {
      const double value = doubled.value(start->u);
      if (value < low_ || value > high_ || is_known(doubled.orbit(start->u, {}).states, value)) return out;
      follow_from(*start, doubled, std::move(branch), out);
      return out;
    }
    branch.stop = BranchStop::start_failed;
    branch.stop_value = pd.value;
    branch.message = fmt::format("no doubled orbit was found beside {}", pd.label);
    out.branch = std::move(branch);
    return out;
  }

  /// The orbits with the impact removed (or added) from the grazing on: they exist on one side of it only.
  Outcome follow_beyond_grazing(const Task& task, int provisional_id) const {
    Outcome out;
    const std::optional<GrazingEnd> known_end =
        ends_[task.parent] ? ends_[task.parent] : found_again(graph_.branches[task.parent]);
    if (!known_end) return out;
    GrazingEnd end = *known_end;
    const SpecialPoint& point = graph_.branches[task.parent].special_points[task.special];
    PeriodicOrbit at_grazing = point.orbit;
    int impacts = end.grazing.orbit.impacts + (end.lost ? 0 : 1);
    if (end.lost) impacts = impacts * to_least_period(at_grazing, end.grazing) / point.orbit.period;
    const GrazingEdge partner = edge_at(point, at_grazing, impacts);
    if (is_known(partner)) return out;
    OrbitProblem problem = problem_at(at_grazing);
    const std::optional<BranchStart> start = partner_start(problem, end.grazing, end.lost, options_.trace);
    if (!start || problem.value(start->u) < low_ || problem.value(start->u) > high_) return out;
    out.begins = partner;
    Branch branch = new_branch(at_grazing, at_grazing.period, provisional_id);
    branch.parent = BranchParent{graph_.branches[task.parent].id, point.label};
    follow_from(*start, problem, std::move(branch), out);
    return out;
  }

  /// The orbit in the middle of the two halves of the last point, which have all but met.
  std::optional<PeriodicOrbit> half_of(const Branch& branch) const {
    const BranchPoint& last = branch.points.back();
    const std::size_t half = last.states.size() / 2;
    std::vector<Vector> guess;
    for (std::size_t k = 0; k < half; ++k) guess.push_back(0.5 * (last.states[k] + last.states[k + half]));
    Vector p = branch.parameters;
    p[static_cast<Eigen::Index>(parameter_)] = last.value;
    try {
      PeriodicOrbit orbit = shoot(system_, p, guess, branch.period / 2, options_.shooting);
      if (orbit.converged() && orbit.admissible == Admissibility::admissible) return orbit;
    } catch (const std::invalid_argument&) {  // the middle lies inside a barrier
    }
    return std::nullopt;
  }

  void accept(const Task& task, Outcome outcome) {
    Branch& branch = *outcome.branch;
    if (outcome.begins && is_known(*outcome.begins)) return;
    if (outcome.ends && is_known(*outcome.ends)) return;
    // Others of the same round may have been the same family: points inside the branch tell, which are nobody's ends (and of
    // which one may lie next to a fold, where lies_on sees nothing).
    for (const std::size_t quarter : {1, 2, 3}) {
      if (branch.points.size() <= 4) break;
      const BranchPoint& inside = branch.points[branch.points.size() * quarter / 4];
      if (is_known(inside.states, inside.value)) return;
    }
    branch.id = ++last_id_;
    for (SpecialPoint& point : branch.special_points) point.label = labels_.next(point.type);
    if (task.origin == Origin::doubled)
      confirm_criticality(branch, graph_.branches[task.parent].special_points[task.special], graph_.branches[task.parent]);
    for (const auto& edge : {outcome.begins, outcome.ends})
      if (edge) edges_.push_back(*edge);
    ends_.push_back(std::move(outcome.grazing));
    seeds_.push_back(task.seed);
    graph_.branches.push_back(std::move(branch));
    add_tasks(task.generation + (task.origin == Origin::doubled ? 1 : 0), std::move(outcome.half));
  }

  /// A branch of an earlier run takes its place as it is; what begins on it is followed unless it is there too.
  void restore(const Branch& branch) {
    last_id_ = std::max(last_id_, branch.id);
    for (const SpecialPoint& point : branch.special_points) labels_.take(point);
    const auto with_id = [&](const Branch& other) { return branch.parent && other.id == branch.parent->branch; };
    const auto parent = std::find_if(graph_.branches.begin(), graph_.branches.end(), with_id);
    int generation = 0;
    if (parent != graph_.branches.end()) {
      generation = generations_[static_cast<std::size_t>(parent - graph_.branches.begin())];
      for (const SpecialPoint& point : parent->special_points) {
        if (point.label != branch.parent->label) continue;
        if (point.type == PointType::PD) ++generation;
        if (point.type != PointType::GR) continue;
        PeriodicOrbit shortened = point.orbit;
        shortened.period = branch.period;
        shortened.states.resize(static_cast<std::size_t>(branch.period));
        edges_.push_back(edge_at(point, shortened, branch.points.front().impacts));
      }
    }
    if (branch.stop == BranchStop::grazing)
      edges_.push_back(edge_at(branch.special_points.back(), branch.special_points.back().orbit, branch.points.back().impacts));
    graph_.branches.push_back(branch);
    ends_.emplace_back();
    seeds_.push_back(0);
    add_tasks(generation, branch.stop == BranchStop::returned && options_.follow_parents ? half_of(branch) : std::nullopt);
  }

  /// The grazing at the end of a branch that was restored, from the last of its points that Newton reproduces.
  std::optional<GrazingEnd> found_again(const Branch& branch) const {
    const SpecialPoint& point = branch.special_points.back();
    for (std::size_t back = 1; back <= 8 && back <= branch.points.size(); ++back) {
      const BranchPoint& last = branch.points[branch.points.size() - back];
      Vector p = branch.parameters;
      p[static_cast<Eigen::Index>(parameter_)] = last.value;
      ShootingOptions shooting = options_.shooting;
      shooting.reduce_period = false;
      const PeriodicOrbit orbit = shoot(system_, p, last.states, branch.period, shooting);
      if (!orbit.converged() || orbit.impacts != last.impacts) continue;
      OrbitProblem problem = problem_at(orbit);
      const Vector u = problem.pack(orbit.nodes, orbit.duration, last.value);
      const double direction = point.value >= last.value ? 1.0 : -1.0;
      Branch again = new_branch(orbit, branch.period, 0);
      ContinuationOptions quiet = options_;
      quiet.progress = nullptr;
      quiet.trace.initial_step = 1e-4;
      BranchFollower follower(system_, quiet, low_, high_);
      std::optional<GrazingEnd> end = follower.follow(problem, {u, direction * problem.parameter_direction()}, again);
      if (end && std::abs(again.special_points.back().value - point.value) < 1e-9 * (1.0 + std::abs(point.value))) return end;
    }
    return std::nullopt;
  }

  /// What begins on the branch accepted last.
  void add_tasks(int generation, std::optional<PeriodicOrbit> half) {
    generations_.push_back(generation);
    const std::size_t index = graph_.branches.size() - 1;
    const Branch& branch = graph_.branches[index];
    if (branch.stop == BranchStop::grazing) {
      const Task beyond{Origin::beyond_grazing, {}, 1, index, branch.special_points.size() - 1, generation};
      tasks_.push_back(beyond);
    }
    if (half) add_seed({*half}, generation);
    for (std::size_t s = 0; s < branch.special_points.size(); ++s) {
      if (branch.special_points[s].type != PointType::PD) continue;
      const Task doubled{Origin::doubled, {}, 1, index, s, generation};
      if (generation >= options_.switch_generations) continue;
      if (options_.max_period > 0 && 2 * branch.period > options_.max_period) {
        cut_off(doubled, fmt::format("period {} is above the limit, {}", 2 * branch.period, options_.max_period));
        continue;
      }
      tasks_.push_back(doubled);
    }
  }

  const HybridSystem& system_;
  ContinuationOptions options_;
  std::size_t parameter_;
  double low_, high_;
  std::mutex progress_;
  Labels labels_;
  BranchGraph graph_;
  std::deque<Task> tasks_, seed_tasks_;
  std::vector<std::optional<GrazingEnd>> ends_;  ///< of each branch
  std::vector<int> generations_;
  std::vector<int> seeds_;  ///< of each branch: the seed it came from, or 0
  std::vector<GrazingEdge> edges_;
  int last_seed_ = 0, last_id_ = 0;
};

}  // namespace

BranchGraph follow_branches(const HybridSystem& system, const std::vector<BranchSeed>& seeds, const ContinuationOptions& options,
                            const std::vector<Branch>& so_far) {
  return Graph(system, options).all(seeds, so_far);
}

}  // namespace graze
