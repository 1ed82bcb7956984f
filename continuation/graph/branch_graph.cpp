// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/graph/branch_graph.hpp>

#include <graze/continuation/branch/branch_end.hpp>
#include <graze/continuation/branch/follow_branch.hpp>
#include <graze/continuation/conditions/grazing_turns.hpp>
#include <graze/continuation/graph/chatter_series.hpp>
#include <graze/continuation/graph/task_queues.hpp>
#include <graze/continuation/problems/clear_section.hpp>
#include <graze/continuation/problems/labels.hpp>
#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/orbit/mirror.hpp>
#include <graze/floquet/orbit/returns.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <stdexcept>

namespace graze {

namespace {

/// Number of branches followed in parallel before the results are accepted. Fixed, so that the result does not depend on the
/// number of threads.
constexpr std::size_t round_size = 4;
using Origin = BranchOrigin;
using Family = GrazingFamily::Kind;
using Task = BranchTask;
using Outcome = BranchOutcome;

/// True if the branch is stable somewhere.
bool is_stable(const Branch& branch) {
  return std::any_of(branch.points.begin(), branch.points.end(), [](const BranchPoint& point) { return point.stable; });
}

/// Width of the parameter interval of the branch.
double width(const Branch& branch) {
  const auto [least, most] = std::minmax_element(branch.points.begin(), branch.points.end(),
                                                 [](const BranchPoint& a, const BranchPoint& b) { return a.value < b.value; });
  return branch.points.empty() ? 0.0 : most->value - least->value;
}

/// True if the branch is stable on either side of its special point.
bool is_stable_beside(const Branch& branch, const SpecialPoint& point) {
  const auto stable = [&](std::size_t k) { return k < branch.points.size() && branch.points[k].stable; };
  return stable(point.after_point) || stable(point.after_point + 1);
}

/// A series towards complete chatter that is not followed further.
struct ChatterSeries {
  int period = 0, impacts = 0;  ///< of the last family followed
  double from = 0.0, to = 0.0;  ///< last grazing but one, and accumulation point

  /// True if an orbit belongs to one of its further families, or to a family of a multiple of their period.
  bool explains(const PeriodicOrbit& orbit, double value) const {
    const bool inside = value >= std::min(from, to) && value <= std::max(from, to);
    return inside && orbit.period % period == 0 && orbit.impacts == orbit.isolated_impacts &&
           orbit.impacts * period > impacts * orbit.period;
  }
};

class Graph {
 public:
  Graph(const HybridSystem& system, const ContinuationOptions& options, const FamilyChoice& choice)
      : system_(system), options_(options), choice_(choice), parameter_(parameter_index(system.parameters, options.parameter)),
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
    while (!tasks_.empty() && !cancelled()) {
      if (static_cast<int>(graph_.branches.size()) >= options_.max_branches) {
        cut_off_rest(fmt::format("{} branches are the limit", options_.max_branches));
        break;
      }
      std::vector<Task> round = tasks_.next_round(round_size);
      if (!choice_.all) std::erase_if(round, [&](const Task& task) { return excludes(task); });
      std::vector<Outcome> outcomes(round.size());
      const std::size_t known = graph_.branches.size();
      in_parallel_on(options_.threads, round.size(), [&](std::size_t k) {
        if (!cancelled()) outcomes[k] = follow(round[k], static_cast<int>(known + k) + 1);
      });
      for (std::size_t k = 0; k < round.size(); ++k) {
        const bool full = static_cast<int>(graph_.branches.size()) >= options_.max_branches;
        if (!outcomes[k].nothing.empty() && !cancelled()) {
          if (round[k].is(Family::partner))
            set_scenario_without_partner(graph_.branches[round[k].parent], outcomes[k].nothing, outcomes[k].none);
          cut_off(round[k], std::move(outcomes[k].nothing));
        } else if (outcomes[k].branch && !full) {
          accept(round[k], std::move(outcomes[k]));
        } else if (outcomes[k].branch || cancelled()) {
          cut_off(round[k], full ? fmt::format("{} branches are the limit", options_.max_branches) : was_interrupted);
        }
      }
      if (options_.complete) options_.complete(graph_.branches);
    }
    for (std::size_t k = 0; k < graph_.branches.size(); ++k) {
      confirm_grazing(k);
      confirm_return(graph_.branches[k]);
    }
    graph_.interrupted = cancelled();
    if (graph_.interrupted) cut_off_rest(was_interrupted);
    if (!choice_.all && !graph_.interrupted) keep_stable();
    for (const auto& [reason, count] : left_out_) graph_.cut_off.push_back({0, "left out", reason, count});
    return std::move(graph_);
  }

 private:
  bool cancelled() const { return options_.cancelled && options_.cancelled(); }

  void cut_off(const Task& task, std::string reason, int families = 0) {
    if (task.origin == Origin::seed) return graph_.cut_off.push_back({0, "seed", std::move(reason)});
    const Branch& parent = graph_.branches[task.parent];
    if (task.is(Family::multiple)) reason = "families of several times its period: " + reason;
    CutOff entry{parent.id, parent.special_points[task.special].label, std::move(reason), families};
    const auto same = [&](const CutOff& other) { return other.label == entry.label && other.reason == entry.reason; };
    if (std::none_of(graph_.cut_off.begin(), graph_.cut_off.end(), same)) graph_.cut_off.push_back(std::move(entry));
  }

  /// The branch that the task follows from a special point; null if it begins elsewhere.
  const Birth* birth_of(const Task& task) const {
    if (task.origin != Origin::born) return nullptr;
    return born_at(graph_.branches[task.parent].special_points[task.special], options_.further_tests);
  }

  /// True if FamilyChoice excludes the task; the task is then counted or listed.
  bool excludes(const Task& task) {
    const auto because = [&](std::string reason) {
      ++left_out_[std::move(reason)];
      return true;
    };
    const bool seed = task.origin == Origin::seed;
    const Branch* parent = seed ? nullptr : &graph_.branches[task.parent];
    const int impacts = seed ? task.orbit.isolated_impacts : parent->points.front().isolated_impacts;
    if (impacts > choice_.most_impacts * (seed ? task.orbit.period : parent->period))
      return because(
          fmt::format("more than {} impacts in a {}", choice_.most_impacts, is_forced(system_) ? "forcing period" : "return"));
    if (seed && std::any_of(series_.begin(), series_.end(),
                            [&](const ChatterSeries& series) { return series.explains(task.orbit, value_of(task.orbit)); }))
      return because("of a series towards complete chatter");
    const Birth* birth = birth_of(task);
    if (birth && birth->multiple > 1 && birth->multiple * impacts > choice_.most_impacts_unseen &&
        width(*parent) < choice_.narrowest * (high_ - low_)) {
      cut_off(task, fmt::format("more than {} impacts, born on a branch narrower than {:g} of the range",
                                choice_.most_impacts_unseen, choice_.narrowest));
      return true;
    }
    const bool promising = seed ? task.orbit.stable() : is_stable_beside(*parent, parent->special_points[task.special]);
    if (promising || unstable_in_a_row_ < choice_.patience) return false;
    return because(fmt::format("beyond unstable orbits; {} branches in a row were stable nowhere", choice_.patience));
  }

  /// Place of the parent of a branch; empty if it has none, or if an earlier run did not leave it.
  std::optional<std::size_t> parent_of(const Branch& branch) const {
    if (!branch.parent) return std::nullopt;
    const auto with_id = [&](const Branch& other) { return other.id == branch.parent->branch; };
    const auto found = std::find_if(graph_.branches.begin(), graph_.branches.end(), with_id);
    if (found == graph_.branches.end()) return std::nullopt;
    return static_cast<std::size_t>(found - graph_.branches.begin());
  }

  /// Drops the branches that FamilyChoice does not keep.
  void keep_stable() {
    std::vector<Branch>& branches = graph_.branches;
    std::vector<char> kept(branches.size());
    for (std::size_t k = 0; k < branches.size(); ++k) {
      const Branch& branch = branches[k];
      if (const auto parent = parent_of(branch))
        for (const SpecialPoint& point : branches[*parent].special_points)
          if (point.label == branch.parent->label && is_stable_beside(branches[*parent], point)) kept[k] = 1;
      if (!is_stable(branch)) continue;
      kept[k] = 1;
      if (branch.stop != BranchStop::grazing || !branch.points.back().stable || !ends_[k]) continue;
      if (const KnownEdge* edge = partner_edge_among(edges_, k, branch.special_points.back(), *ends_[k], unit()))
        kept[edge->branch] = 1;
    }
    // Parents precede their children in the list.
    for (std::size_t k = branches.size(); k-- > 0;)
      if (const auto parent = kept[k] ? parent_of(branches[k]) : std::nullopt) kept[*parent] = 1;
    std::vector<Branch> list;
    for (std::size_t k = 0; k < branches.size(); ++k)
      if (kept[k]) list.push_back(std::move(branches[k]));
    if (const auto dropped = static_cast<int>(branches.size() - list.size()); dropped > 0)
      left_out_["stable nowhere, and no bound of a stable branch"] = dropped;
    const auto is_there = [&](const CutOff& cut) {
      return cut.branch == 0 || std::any_of(list.begin(), list.end(), [&](const Branch& b) { return b.id == cut.branch; });
    };
    std::erase_if(graph_.cut_off, [&](const CutOff& cut) { return !is_there(cut); });
    branches = std::move(list);
  }

  /// The accumulation point, if the grazing at the end of the branch `index` is the last of a series towards complete chatter.
  std::optional<SeriesLimit> series_at(std::size_t index) const {
    std::array<double, grazings_of_series> values{};
    for (std::size_t k = 0; k < values.size(); ++k) {
      const Branch& branch = graph_.branches[index];
      if (branch.stop != BranchStop::grazing) return std::nullopt;
      const SpecialPoint& end = branch.special_points.back();
      const auto kind = end.details.find("kind");
      if (kind == end.details.end() || std::get<std::string>(kind->second) != "gained") return std::nullopt;
      values[k] = end.value;
      if (k + 1 == values.size()) break;
      const std::optional<std::size_t> before = parent_of(branch);
      if (!before) return std::nullopt;
      index = *before;
      const Branch& parent = graph_.branches[index];
      if (parent.special_points.back().label != branch.parent->label || !is_partner(branch, parent) ||
          parent.period != branch.period)
        return std::nullopt;
    }
    return limit_of_series(values);
  }

  /// Records the series, and continues with the sticking orbits beyond its accumulation point.
  void end_series(std::size_t index, const SeriesLimit& found, int generation) {
    const Branch& branch = graph_.branches[index];
    const SpecialPoint& end = branch.special_points.back();
    const double before = found.value - (found.value - end.value) / found.ratio;  // last grazing but one
    series_.push_back({branch.period, branch.points.back().impacts, before, found.value});
    cut_off(
        {Origin::grazing, {}, 1, index, branch.special_points.size() - 1},
        fmt::format("a series towards complete chatter, one impact more at each grazing, their distances in the ratio {:.3g}, "
                    "which accumulates at {} = {:.9g}: it is not followed impact by impact",
                    found.ratio, options_.parameter, found.value));
    // The start lies as far beyond the accumulation point as the last family lies before it.
    const double beyond = std::clamp(2.0 * found.value - before, low_, high_);
    Vector p = branch.parameters;
    p[static_cast<Eigen::Index>(parameter_)] = beyond;
    AttractorOptions settling;
    settling.recurrence = usual_recurrence;
    settling.lyapunov.flow = options_.shooting.flow;
    settling.lyapunov.cancelled = options_.cancelled;
    if (!mode_at(system_, 0.0, end.orbit.state, p)) return;
    const Attractor attractor = approach_attractor(system_, p, end.orbit.state, settling);
    if (!attractor.orbit || attractor.orbit->isolated_impacts >= attractor.orbit->impacts) return;
    add_seed({at_nodes(*attractor.orbit->whole)}, generation);
  }

  /// The partner born on the grazing at the end of this branch; null if there is none.
  const Branch* child_at(const Branch& branch) const {
    for (const Branch& other : graph_.branches)
      if (other.parent && other.parent->label == branch.special_points.back().label && is_partner(other, branch)) return &other;
    return nullptr;
  }

  /// Confirms the scenario of a grazing with the family on the other side: a child, a parent, or a branch from another seed.
  void confirm_grazing(std::size_t index) {
    Branch& branch = graph_.branches[index];
    if (branch.stop != BranchStop::grazing || branch.points.empty()) return;
    const SpecialPoint& point = branch.special_points.back();
    const Branch* beyond = child_at(branch);
    bool begins = true;
    if (const KnownEdge* edge =
            !beyond && ends_[index] ? partner_edge_among(edges_, index, point, *ends_[index], unit()) : nullptr) {
      beyond = &graph_.branches[edge->branch];
      begins = edge->begins;
    }
    if (!beyond) return;
    set_scenario(branch, [&](SpecialPoint& grazing) { confirm_scenario(grazing, branch, *beyond, begins); });
  }

  /// Confirms the special point at which a branch of a multiple of its period ends (a period doubling, for a doubled branch): the
  /// one nearest to its last point.
  void confirm_return(const Branch& child) {
    constexpr double max_distance = 0.1;  // two of the longest steps
    if (child.stop != BranchStop::returned || child.points.empty()) return;
    const BranchPoint& end = child.points.back();
    double nearest = max_distance;
    std::function<void()> confirm;
    for (Branch& parent : graph_.branches) {
      for (SpecialPoint& point : parent.special_points) {
        const Birth* birth = born_at(point, options_.further_tests);
        if (!birth || birth->multiple == 1 || !birth->confirm) continue;
        if (birth->multiple * parent.period != child.period || birth->multiple * point.orbit.impacts != end.impacts) continue;
        double distance = std::numeric_limits<double>::infinity();
        for (const Vector& state : point.orbit.states)
          distance =
              std::min(distance, (state - end.state()).lpNorm<Eigen::Infinity>() / (1.0 + state.lpNorm<Eigen::Infinity>()));
        distance = std::max(distance, std::abs(point.value - end.value) / (high_ - low_));
        if (!(distance < nearest)) continue;
        nearest = distance;
        confirm = [&, birth] { birth->confirm(child, point, parent, false); };
      }
    }
    if (confirm) confirm();
  }

  void cut_off_rest(const std::string& reason) {
    tasks_.for_each([&](const Task& task) { cut_off(task, reason); });
  }

  void add_seed(const BranchSeed& seed, int generation) {
    ++last_seed_;
    for (const int direction : seed.directions) {
      Task task{Origin::seed, seed.orbit, direction, 0, 0, generation};
      if (!is_forced(system_)) task.orbit = by_returns(seed.orbit);
      task.seed = last_seed_;
      tasks_.add(std::move(task));
    }
  }

  /// An autonomous orbit with its number of returns as period, and one node per return: this distinguishes a doubled orbit from
  /// its parent.
  PeriodicOrbit by_returns(const PeriodicOrbit& orbit) const {
    const int returns = count_returns(system_, orbit);
    if (returns < 2) return orbit;
    // Start in the widest gap between events, so that the nodes stay clear of them.
    std::vector<double> places;
    const double length = orbit.duration / returns;
    for (const EventRecord& event : orbit.events) places.push_back(std::fmod(event.t / length, 1.0));
    std::sort(places.begin(), places.end());
    Propagator propagator(system_, orbit.parameters, {}, options_.shooting.flow);
    Transition transition;
    std::vector<Vector> nodes;
    Vector state = orbit.nodes.front();
    for (double ahead = std::fmod(widest_gap(places).middle, 1.0) * length; static_cast<int>(nodes.size()) < returns;
         ahead = length) {
      carry(propagator, 0.0, ahead, state, {.sensitivity = Sensitivity::none}, transition);
      if (transition.termination != Termination::time) return orbit;
      state = transition.x1;
      nodes.push_back(state);
    }
    PeriodicOrbit out = orbit;
    out.period = returns;
    out.nodes = out.states = nodes;
    out.state = nodes.front();
    return out;
  }

  OrbitProblem problem_at(const PeriodicOrbit& orbit, int copies = 1) const {
    return orbit_problem(system_, orbit, options_, low_, high_, copies);
  }

  double unit() const { return parameter_unit(low_, high_); }
  double value_of(const PeriodicOrbit& orbit) const { return orbit.parameters[static_cast<Eigen::Index>(parameter_)]; }

  /// The branch on which an orbit lies. Branches from the seed `except` are ignored.
  std::optional<std::size_t> branch_through(const std::vector<Vector>& states, double value, int except = 0) const {
    for (std::size_t k = 0; k < graph_.branches.size(); ++k)
      if ((except == 0 || seeds_[k] != except) && branch_contains(system_, graph_.branches[k], states, value)) return k;
    return std::nullopt;
  }

  bool is_known(const std::vector<Vector>& states, double value, int except = 0) const {
    return branch_through(states, value, except).has_value();
  }

  /// The mirror images of the orbit under each symmetry of the system at this value of the parameter.
  std::vector<std::pair<Symmetry, std::vector<Vector>>> images(Vector p, const std::vector<Vector>& states, double value) const {
    p[static_cast<Eigen::Index>(parameter_)] = value;
    std::vector<std::pair<Symmetry, std::vector<Vector>>> list;
    for (const Symmetry& symmetry : symmetries(system_, p))
      if (std::vector<Vector> image = mirror_image(system_, p, symmetry, states); !image.empty())
        list.emplace_back(symmetry, std::move(image));
    return list;
  }

  bool is_known(const GrazingEdge& edge) const {
    return std::any_of(edges_.begin(), edges_.end(), [&](const KnownEdge& known) { return same_edge(known.edge, edge, unit()); });
  }

  Branch new_branch(const Task& task, const PeriodicOrbit& orbit, int period, int provisional_id) const {
    Branch branch;
    if (task.origin != Origin::seed) {
      const Branch& parent = graph_.branches[task.parent];
      branch.parent = BranchParent{parent.id, parent.special_points[task.special].label};
    }
    branch.id = provisional_id;
    branch.period = period;
    branch.parameter = options_.parameter;
    branch.parameters = orbit.parameters;
    return branch;
  }

  // The functions from here to accept() run in parallel and only read the graph.

  /// Follows one task. A branch that cannot be started must not lose the results so far; that of a seed is listed as failed.
  Outcome follow(const Task& task, int provisional_id) const {
    try {
      return follow_origin(task, provisional_id);
    } catch (const std::invalid_argument& refused) {
      Outcome out;
      std::string message = fmt::format("the branch could not be started ({})", refused.what());
      if (task.origin != Origin::seed) {
        out.nothing = std::move(message);
        return out;
      }
      out.branch = new_branch(task, task.orbit, task.orbit.period, provisional_id);
      out.branch->stop = BranchStop::start_failed;
      out.branch->stop_value = value_of(task.orbit);
      out.branch->message = std::move(message);
      return out;
    }
  }

  Outcome follow_origin(const Task& task, int provisional_id) const {
    switch (task.origin) {
    case Origin::seed:
      return follow_seed(task, provisional_id);
    case Origin::born:
      return follow_born(task, provisional_id);
    case Origin::grazing:
      return follow_from_grazing(task, provisional_id);
    }
    return {};
  }

  void follow_from(const BranchStart& start, OrbitProblem& problem, Branch branch, Outcome& out) const {
    ContinuationOptions options = options_;
    if (start.step > 0.0) options.trace.initial_step = start.step;
    out.grazing = follow_branch({system_, options, low_, high_}, problem, start, branch);
    if (out.grazing)
      out.ends = edge_at(branch.special_points.back(), branch.special_points.back().orbit, branch.points.back().impacts);
    if (branch.stop == BranchStop::returned && branch.period % 2 == 0 && options_.follow_parents)
      out.half = half_period_orbit(system_, branch, options_);
    const bool nothing = out.begins && branch.stop == BranchStop::start_failed;
    if (nothing) out.nothing = branch.message;
    if (!nothing) out.branch = std::move(branch);
  }

  Outcome follow_seed(const Task& task, int provisional_id) const {
    Outcome out;
    const double value = value_of(task.orbit);
    if (task.direction > 0 ? value >= high_ : value <= low_) return out;  // leads directly out of the range
    if (is_known(task.orbit.states, value, task.seed)) return out;
    OrbitProblem problem = problem_at(task.orbit);
    const Vector u = problem.pack(task.orbit.nodes, task.orbit.duration, value);
    follow_from({u, task.direction * problem.parameter_direction()}, problem,
                new_branch(task, task.orbit, task.orbit.period, provisional_id), out);
    return out;
  }

  /// The branch that is born at a special point, on one side of it.
  Outcome follow_born(const Task& task, int provisional_id) const {
    Outcome out;
    const Birth& birth = *birth_of(task);
    const Branch& on = graph_.branches[task.parent];
    const SpecialPoint& point = on.special_points[task.special];
    PeriodicOrbit there = point.orbit;
    there.parameters[static_cast<Eigen::Index>(parameter_)] = point.value;
    OrbitProblem states = problem_at(there);
    Branch branch = new_branch(task, there, birth.multiple * there.period, provisional_id);
    if (const std::optional<BranchStart> start = birth.start(point, on, states, task.direction, options_.trace)) {
      const double value = states.value(start->u);
      if (value < low_ || value > high_ || is_known(start->states, value)) return out;
      std::optional<OrbitProblem> longer;
      if (birth.multiple > 1) longer.emplace(problem_at(there, birth.multiple));
      follow_from(*start, longer ? *longer : states, std::move(branch), out);
    } else if (birth.certain) {
      branch.stop = BranchStop::start_failed;
      branch.stop_value = point.value;
      branch.message = fmt::format("{} beside {}", birth.missing, point.label);
      out.branch = std::move(branch);
    } else {
      out.nothing = birth.missing;
    }
    return out;
  }

  /// The grazing at the end of a branch; that of a restored branch is located again.
  std::optional<GrazingEnd> grazing_end(std::size_t index) const {
    return ends_[index] ? ends_[index] : relocate_grazing_end(system_, graph_.branches[index], options_, low_, high_);
  }

  /// A family that may begin at the grazing on which a branch ended.
  Outcome follow_from_grazing(const Task& task, int provisional_id) const {
    Outcome out;
    const bool partner = task.is(Family::partner);
    const Branch& parent = graph_.branches[task.parent];
    if (partner && child_at(parent)) return out;
    const std::optional<GrazingEnd> end = grazing_end(task.parent);
    if (!end && partner) out.nothing = "the grazing was not found again";
    const std::optional<GrazingBirth> birth =
        end ? birth_at_grazing(task.family, parent.special_points[task.special], *end) : std::nullopt;
    if (!birth || (birth->identified && is_known(birth->edge))) return out;
    OrbitProblem problem = problem_at(birth->orbit, birth->turns);
    const std::optional<BranchStart> start = birth->start(problem, options_.trace);
    out.none = !end->lost && end->grazing.leads_away;
    if (!start) out.nothing = birth->missing;
    if (!start || problem.value(start->u) < low_ || problem.value(start->u) > high_) return out;
    out.begins = birth->edge;
    follow_from(*start, problem, new_branch(task, birth->orbit, birth->edge.period, provisional_id), out);
    const bool found = out.branch && !out.branch->points.empty();
    if (!found && !birth->identified) return {};
    // More than one impact more if several contacts touch together.
    if (found && birth->turns == 1) out.begins->impacts = out.branch->points.front().impacts;
    return out;
  }

  void accept(const Task& task, Outcome outcome) {
    Branch& branch = *outcome.branch;
    if (outcome.begins && is_known(*outcome.begins)) return;
    if (outcome.ends && is_known(*outcome.ends)) return;
    // Another task of the same round may have found the same family. Points inside the branch decide: the ends of a branch may
    // belong to other branches too. Three points are tested, since branch_contains detects nothing next to a fold.
    std::optional<Symmetry> mirrored;  // under it the image of the branch is another one
    for (const std::size_t quarter : {1, 2, 3}) {
      if (branch.points.size() <= 4) break;
      const BranchPoint& inside = branch.points[branch.points.size() * quarter / 4];
      if (is_known(inside.states, inside.value)) return;
      std::optional<Symmetry> to_another;  // (the orbit is on no listed branch: an image that is on one is another orbit)
      for (const auto& [symmetry, image] : images(branch.parameters, inside.states, inside.value)) {
        if (const auto listed = branch_through(image, inside.value)) {
          graph_.branches[*listed].mirrored = symmetry;
          return;
        }
        if (!to_another && !branch_contains(system_, branch, image, inside.value)) to_another = symmetry;
      }
      if (quarter == 1 || !to_another) mirrored = to_another;
    }
    branch.mirrored = mirrored;
    branch.id = ++last_id_;
    for (SpecialPoint& point : branch.special_points) point.label = labels_.next(point.type);
    if (const Birth* birth = birth_of(task); birth && birth->confirm)
      birth->confirm(branch, graph_.branches[task.parent].special_points[task.special], graph_.branches[task.parent], true);
    const std::size_t index = graph_.branches.size();
    if (outcome.begins) edges_.push_back({*outcome.begins, index, true});
    if (outcome.ends) edges_.push_back({*outcome.ends, index, false});
    ends_.push_back(std::move(outcome.grazing));
    seeds_.push_back(task.seed);
    graph_.branches.push_back(std::move(branch));
    const bool longer = task.origin == Origin::born || task.is(Family::multiple);
    add_tasks(task.generation + (longer ? 1 : 0), std::move(outcome.half));
  }

  /// Restores a branch of an earlier run unchanged; the branches that begin on it are followed unless they are restored too.
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
        if (born_at(point, options_.further_tests)) ++generation;
        if (point.type != PointType::GR) continue;
        if (!is_partner(branch, *parent)) ++generation;
        edges_.push_back({first_edge(point, branch), graph_.branches.size(), true});
      }
    }
    if (branch.stop == BranchStop::grazing)
      edges_.push_back({edge_at(branch.special_points.back(), branch.special_points.back().orbit, branch.points.back().impacts),
                        graph_.branches.size(), false});
    graph_.branches.push_back(branch);
    ends_.push_back(options_.max_multiple > 1 ? relocate_grazing_end(system_, branch, options_, low_, high_) : std::nullopt);
    seeds_.push_back(0);
    add_tasks(generation, branch.stop == BranchStop::returned && options_.follow_parents
                              ? half_period_orbit(system_, branch, options_)
                              : std::nullopt);
  }

  /// Adds tasks for the branches that begin on the last accepted branch.
  void add_tasks(int generation, std::optional<PeriodicOrbit> half) {
    generations_.push_back(generation);
    const std::size_t index = graph_.branches.size() - 1;
    const Branch& branch = graph_.branches[index];
    unstable_in_a_row_ = is_stable(branch) ? 0 : unstable_in_a_row_ + 1;
    if (const std::optional<SeriesLimit> found = choice_.all ? std::nullopt : series_at(index)) {
      end_series(index, *found, generation);
    } else if (branch.stop == BranchStop::grazing) {
      Task beyond{Origin::grazing, {}, 1, index, branch.special_points.size() - 1, generation};
      for (const Family kind : {Family::partner, Family::symmetric}) {
        beyond.family.kind = kind;
        tasks_.add(beyond);
      }
      add_multiples(beyond);
    }
    if (branch.stop == BranchStop::step_too_small)
      cut_off({Origin::born, {}, 1, index, branch.special_points.size() - 1}, branch.message);
    if (half) add_seed({*half}, generation);
    for (std::size_t s = 0; s < branch.special_points.size(); ++s) {
      const SpecialPoint& point = branch.special_points[s];
      if (generation >= options_.switch_generations) continue;
      const Birth* birth = born_at(point, options_.further_tests);
      if (!birth || (birth->located_only && point.status != PointStatus::converged)) continue;
      for (const int side : birth->sides) {
        const Task task{Origin::born, {}, side, index, s, generation};
        if (const int period = birth->multiple * branch.period; options_.max_period > 0 && period > options_.max_period)
          cut_off(task, fmt::format("period {} is above the limit, {}", period, options_.max_period));
        else
          tasks_.add(task);
      }
    }
  }

  /// Adds tasks for the families of a multiple of the period that may begin on the grazing at the end of the last accepted
  /// branch.
  void add_multiples(const Task& beyond) {
    if (beyond.generation >= options_.switch_generations || options_.max_multiple < 2) return;
    Task task = beyond;
    task.family.kind = Family::multiple;
    if (!ends_[beyond.parent]) return cut_off(task, "the grazing was not found again");
    GrazingEnd end = *ends_[beyond.parent];
    PeriodicOrbit orbit;
    const GrazingEdge touching =
        touching_edge(graph_.branches[beyond.parent].special_points[beyond.special], end.grazing, end.lost, &orbit);
    // Several branches may end at this grazing.
    if (std::any_of(spread_.begin(), spread_.end(), [&](const GrazingEdge& done) { return same_edge(done, touching, unit()); }))
      return;
    spread_.push_back(touching);
    const int most = options_.max_multiple;
    const int longest = options_.max_period > 0 ? std::min(most, options_.max_period / touching.period) : most;
    for (const TurnPattern pattern : patterns_up_to(longest, end.lost)) {
      task.family.pattern = pattern;
      tasks_.add(task);
    }
    if (const int others = families_not_followed(end.grazing, static_cast<int>(orbit.nodes.size()), longest); others > 0)
      cut_off(task, others_text(others, longest), others);
  }

  SharedSystem system_;
  ContinuationOptions options_;
  FamilyChoice choice_;
  std::size_t parameter_;
  double low_, high_;
  std::mutex progress_;
  Labels labels_;
  BranchGraph graph_;
  TaskQueues tasks_;
  std::vector<std::optional<GrazingEnd>> ends_;  ///< for each branch
  std::vector<int> generations_;
  std::vector<int> seeds_;  ///< for each branch: the number of its seed, or 0
  std::vector<KnownEdge> edges_;
  std::vector<GrazingEdge> spread_;  ///< grazing orbits whose multiples have been searched
  std::vector<ChatterSeries> series_;
  std::map<std::string, int> left_out_;  ///< number of tasks and branches left out, by reason
  int unstable_in_a_row_ = 0;            ///< number of consecutive branches that were stable nowhere
  int last_seed_ = 0, last_id_ = 0;
};

}  // namespace

BranchGraph follow_branches(const HybridSystem& system, const std::vector<BranchSeed>& seeds, const ContinuationOptions& options,
                            const std::vector<Branch>& so_far, const FamilyChoice& choice) {
  if (options.max_multiple < 1)
    throw std::invalid_argument(fmt::format("max_multiple is {}; allowed is 1 and more", options.max_multiple));
  ContinuationOptions within = options;
  if (!within.from) {
    if (seeds.empty()) throw std::invalid_argument("without seeds the range has no start; give both of its ends");
    within.from =
        seeds.front().orbit.parameters[static_cast<Eigen::Index>(parameter_index(system.parameters, options.parameter))];
  }
  return Graph(system, within, choice).all(seeds, so_far);
}

}  // namespace graze
