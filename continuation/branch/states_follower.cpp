// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch/branch_end.hpp>
#include <graze/continuation/branch/branch_step.hpp>
#include <graze/continuation/branch/kink.hpp>
#include <graze/continuation/branch/states_follower.hpp>
#include <graze/continuation/conditions/grazing_in_step.hpp>
#include <graze/continuation/conditions/hopf.hpp>
#include <graze/continuation/problems/clear_section.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze {

bool is_plastic(const HybridSystem& system, const Vector& p) {
  return std::any_of(system.events.begin(), system.events.end(), [&](const Event& event) {
    return event.accumulation && event.log_volume_change && std::isinf(event.log_volume_change(p));
  });
}

namespace {

/// Ends the branch of an autonomous system if its orbit shrinks to an equilibrium in the step. Empty: it does not. A step that
/// seems to pass an equilibrium without a Hopf point went over to the same orbit half a turn later, and is shortened.
std::optional<Verdict> end_at_equilibrium(OrbitProblem& problem, BranchRecord& record, const CurvePoint& before,
                                          CurvePoint& after) {
  constexpr double middle = 0.5, shortest = 1e-6;
  std::optional<double> part = zero_crossing(field_at_first_node(problem, before.u), field_at_first_node(problem, after.u));
  if (!part && is_equilibrium(problem, after.u)) part = middle;
  if (!part) return std::nullopt;
  const double length = after.arclength - before.arclength;
  const std::optional<double> hopf = locate_hopf(problem, before.u);
  if (!hopf || std::abs(*hopf - problem.value(before.u)) > 2.0 * length * problem.scale())
    return length > shortest ? std::optional<Verdict>({Verdict::reject, "the step passes an equilibrium"}) : std::nullopt;
  const Verdict verdict = record.end_before(problem, before, *part, after);
  if (verdict == Verdict::stop)
    record.end_with(
        {BranchStop::equilibrium, *hopf,
         fmt::format("the orbit shrinks to an equilibrium at {} = {:.12g} (a Hopf point)", record.branch().parameter, *hopf)});
  return verdict;
}

/// Ends the branch at its last point, where a chatter becomes complete or ceases to be.
void end_at_chatter(const HybridSystem& system, BranchRecord& record) {
  const Branch& branch = record.branch();
  const BranchPoint& end = branch.points.back();
  const bool sticks = end.isolated_impacts < end.impacts;
  const std::string event =
      end.impacts == 0 && holds_something(system, end.signature.mode)
          ? "a mass that is held along all orbits before is released there and returns to its stop by complete chatter"
          : fmt::format("the chatter {} complete, and the mass {}", sticks ? "is no longer" : "becomes",
                        sticks ? "does not stick beyond" : "sticks beyond");
  record.end_with({BranchStop::chatter, end.value, fmt::format("at {} = {:.12g} {}", branch.parameter, end.value, event)});
}

/// Moves `last`, the end of the branch, beyond the grazing of a stiff contact. That grazing is a corner of the branch, narrower
/// than the steps can be (proportional to stiffness^-2); beyond it the branch continues like that of a hard contact. False if
/// there is no corner.
bool step_around_corner(const FollowSettings& settings, OrbitProblem& problem, BranchRecord& record, CurvePoint& last) {
  constexpr double near = 1e-4;
  const ZeroProblem zero = problem.zero_problem();
  const Branch& branch = record.branch();
  const BranchPoint& end = branch.points.back();
  for (const bool weakest : {true, false}) {
    const std::optional<GrazingGuess> guess = weakest ? weakest_contact(problem, last.u) : nearest_miss(problem, last.u);
    if (!guess) continue;
    const LocatedGrazing located = locate_grazing(problem, last.u, *guess);
    if (!located.confirmed || located.scenario != GrazingScenario::smooth ||
        weighted_norm(zero.weights, located.u - last.u) > near)
      continue;
    // The branch may have passed the grazing already, with the tip of the corner still ahead.
    const double value = problem.value(located.u);
    const SpecialPoint& met_last = branch.special_points.back();
    const bool passed = met_last.type == PointType::GR && std::abs(met_last.value - value) < 1e-9 * problem.size_of_value(value);
    const bool to_contact = passed ? std::get<std::string>(met_last.details.at("kind")) == "gained" : !weakest;
    const int impacts = end.isolated_impacts + (passed ? 0 : to_contact ? 1 : -1);
    for (const double speed : {1e-3, 3e-3, 1e-2, 3e-4, 3e-2}) {
      // With contact: at that impact speed, as for a hard contact. Without: at that distance from the grazing.
      const double height = speed * speed / (2.0 * -located.curvature), side = located.top_dp > 0.0 ? -1.0 : 1.0;
      const double change = to_contact ? (located.response * speed + height) / located.top_dp : side * speed * problem.unit();
      Vector away = change * located.family_dp;
      if (to_contact) away += speed * located.impulse;
      CurvePoint next;
      next.u = located.u + away;
      if (!away.allFinite() || !correct(zero, problem.parameter_direction(), next.u, settings.options.trace).converged())
        continue;
      if (weighted_norm(zero.weights, next.u - located.u - away) > 0.5 * weighted_norm(zero.weights, away)) continue;
      next.tangent = tangent_at(zero, next.u, next.u - located.u);
      next.arclength = last.arclength + weighted_norm(zero.weights, next.u - last.u);
      BranchPoint point = problem.branch_point(next.u, end.arclength + next.arclength - last.arclength);
      if (next.tangent.size() == 0 || !point.multipliers.valid || point.isolated_impacts != impacts) continue;
      std::vector<PointInStep> met;
      if (!passed)
        met.push_back({place_of(zero, last, located.u), located.u,
                       grazing_point(settings.system, located, end.impacts, point.impacts, branch)});
      const Corner corner{value, place_of(zero, last, located.u), to_contact};
      if (!record.take(problem, last, next, std::move(point), std::move(met), corner)) continue;
      last = std::move(next);
      return true;
    }
  }
  return false;
}

}  // namespace

StatesFollower::StatesFollower(const FollowSettings& settings, OrbitProblem& problem, BranchRecord& record)
    : settings_(settings), problem_(problem), record_(record) {}

Curve StatesFollower::follow(const BranchStart& given) {
  Branch& branch = record_.branch();
  Vector start = given.u, direction = given.orientation;
  // Moves start and direction to a section clear of impacts, if needed.
  const auto clear_section = [&] {
    const double current = problem_.equations().section_phase(), section = better_section(start);
    if (section == current) return;
    // Without forcing the phase is counted from the first node.
    const bool autonomous = problem_.equations().autonomous();
    OrbitProblem moved = problem_.with_section(autonomous ? current : section);
    const auto move = [&](const Vector& u) {
      const double turn = problem_.equations().duration(problem_.orbit_part(u)) / problem_.period();
      return autonomous ? problem_.carried_on(u, (section - current) * turn) : problem_.to_section(moved, u);
    };
    // Small against the square of the speed of a weak impact: the impact exists within that distance of the barrier.
    const double small = 1e-8 / std::max(1e-300, problem_.largest_change(direction));
    const auto here = move(start), before = move(start - small * direction);
    if (!here) return;
    direction = before ? Vector((*here - *before) / small) : Vector(moved.value(direction) * moved.parameter_direction());
    start = *here;
    moved.pin_as(problem_, start);
    problem_ = std::move(moved);
  };
  clear_section();
  Curve curve;
  // Start of the branch: a closed branch returns there, possibly with its nodes on another section.
  std::optional<CurvePoint> first, origin;
  double first_section = 0.0;
  const ClosurePoints closure_points = [&](const CurvePoint& start_point) {
    return images_of(problem_, origin.value_or(start_point));
  };
  TraceOptions trace_options = settings_.options.trace;
  for (;;) {
    section_blocked_ = false;
    const ZeroProblem zero = traced_problem(settings_, problem_);
    // A curve that continues the branch repeats the branch's last point as its first.
    const int kept = std::max(1, static_cast<int>(branch.points.size()));
    trace_options.max_points = std::max(1, settings_.options.trace.max_points - kept + 1);
    const auto on_branch = [&](const CurvePoint& before, CurvePoint& after) {
      if (record_.empty()) record_.begin(problem_, before.u);
      if (!first) {
        first = before;
        first_section = problem_.equations().section_phase();
      }
      return monitor(before, after);
    };
    curve = trace(zero, start, direction, trace_options, on_branch, closure_points);
    const Vector plain = std::copysign(1.0, problem_.value(direction)) * problem_.parameter_direction();
    if (curve.stop == TraceStop::start_failed && record_.empty() && direction != plain) {
      direction = plain;
      continue;
    }
    if (curve.stop == TraceStop::monitor && holds_more_) {
      trace_options.initial_step = 1e-6;
      start = record_.last();
      direction = std::copysign(1.0, problem_.value(direction)) * pin_held_states();
      continue;
    }
    // A start that fails may be the last point of the branch, too close to a kink to be reproduced.
    const bool not_begun = curve.stop == TraceStop::start_failed && !record_.empty();
    const bool fails = curve.stop == TraceStop::min_step && !record_.empty();
    CurvePoint last;
    if (not_begun) {
      last.u = start;
      last.tangent = direction / weighted_norm(zero.weights, direction);
    } else if (fails) {
      last = curve.points.back();
    }
    if ((fails && !settings_.hard_contacts && step_around_corner(settings_, problem_, record_, last)) ||
        ((fails || not_begun) && step_over_kink(last))) {
      trace_options.initial_step = 1e-6;
      start = last.u;
      direction = last.tangent;
      continue;
    }
    if (fails && !settings_.hard_contacts) {
      trace_options.initial_step = 1e-6;
      // States within a stiff contact vary as steeply as those at a hard impact.
      section_blocked_ = !clear_of_soft_;
      clear_of_soft_ = true;
      section_blocked_ = section_blocked_ && better_section(last.u) != problem_.equations().section_phase();
      if (!section_blocked_) break;
    } else if (curve.stop != TraceStop::monitor || !section_blocked_) {
      break;
    }
    start = curve.points.back().u;
    direction = curve.points.back().tangent;
    const double arclength = branch.points.back().arclength;
    clear_section();
    branch.points.back() = problem_.branch_point(start, arclength);
    record_.set_last(start);
    origin.reset();
    OrbitProblem at_first = problem_.with_section(first_section);
    if (const auto u = at_first.to_section(problem_, first->u)) {
      const double forward = std::copysign(1.0, problem_.value(first->tangent));
      origin.emplace();
      origin->u = *u;
      origin->tangent = tangent_at(problem_.zero_problem(), *u, forward * problem_.parameter_direction());
      if (origin->tangent.size() == 0) origin.reset();
    }
  }
  return curve;
}

Verdict StatesFollower::monitor(const CurvePoint& before, CurvePoint& after) {
  constexpr const char* several_graze = "several impacts graze close together";
  if (record_.interrupted_now()) return Verdict::stop;
  const Branch& branch = record_.branch();
  const std::optional<Verdict> end = end_of_range(settings_, problem_, before, after);
  if (end == Verdict::reject) return *end;
  BranchPoint point = problem_.branch_point(after.u, branch.points.back().arclength + after.arclength - before.arclength);
  if (const auto verdict = record_.rejection_of(point)) return *verdict;
  if (releases_pinned(problem_, point)) return {Verdict::reject, "a mass that friction holds is released"};
  // When a chatter becomes incomplete, infinitely many impacts separate, each with its own grazing.
  const bool sticks = point.isolated_impacts < point.impacts;
  const bool switches = sticks != (branch.points.back().isolated_impacts < branch.points.back().impacts);
  const bool plastic = switches && is_plastic(settings_.system, problem_.equations().parameters());
  if (settings_.hard_contacts && switches && !plastic) {
    if (after.arclength - before.arclength > 1e-7) return {Verdict::reject, "a chatter becomes complete or ceases to be"};
    end_at_chatter(settings_.system, record_);
    return Verdict::stop;
  }
  // A step must not cross several grazings: it is halved until one remains or they cannot be separated. Contacts that graze
  // together (an orbit symmetric between two barriers) count as one.
  const int change = plastic && point.impacts == branch.points.back().impacts
                         ? 0
                         : std::abs(point.isolated_impacts - branch.points.back().isolated_impacts);
  // Orbits on the two sides of a hard grazing are different families, even if the corrector converges across it: never step
  // over one.
  if (change == 1 && settings_.hard_contacts) return {Verdict::reject, "an impact grazes"};
  const bool close = after.arclength - before.arclength <= 1e-7;
  if (change > 1 && settings_.hard_contacts && !close) return {Verdict::reject, several_graze};
  // Friction holds a body all along from here on: the orbits beyond keep its place, which is pinned.
  holds_more_ = point.signature != branch.points.back().signature && holds_more(problem_, after.u);
  if (holds_more_ || is_kink(branch.points.back(), point)) {
    if (!close) return {Verdict::reject, "the branch has a kink"};
    const bool rises = problem_.value(after.u) > problem_.value(before.u), rose = problem_.value(before.tangent) > 0.0;
    append_beyond_kink(after.u, std::move(point), rises == rose);
    holds_more_ = holds_more_ && !end;
    return end || holds_more_ ? Verdict::stop : Verdict::go_on;
  }
  if (const auto verdict = record_.end_at_half(problem_, before, after)) return *verdict;
  if (const auto verdict = end_at_equilibrium(problem_, record_, before, after)) return *verdict;
  std::vector<PointInStep> met;
  if (change == 1 || (change > 1 && !settings_.hard_contacts)) {
    GrazingInStep grazing = grazing_in_step(problem_, before, after, point, branch);
    met.push_back({place_of(problem_.zero_problem(), before, grazing.u), grazing.u, std::move(grazing.point)});
  }
  if (change > 1 && !close && met.back().point.status != PointStatus::converged) return {Verdict::reject, several_graze};
  if (auto kink = kink_in_step(problem_, {before, branch.points.back()}, {after, point}, branch, settings_.options.trace))
    met.push_back(std::move(*kink));
  if (!record_.take(problem_, before, after, std::move(point), std::move(met)))
    return {Verdict::reject, BranchRecord::special_points_lost};
  if (end) return Verdict::stop;
  section_blocked_ = better_section(after.u) != problem_.equations().section_phase();
  return section_blocked_ ? Verdict::stop : Verdict::go_on;
}

double StatesFollower::better_section(const Vector& u) const {
  return settings_.hard_contacts || clear_of_soft_ ? clear_section(problem_, u) : problem_.equations().section_phase();
}

bool StatesFollower::step_over_kink(CurvePoint& last) {
  const double onwards = std::copysign(1.0, problem_.value(last.tangent));
  std::optional<BeyondKink> beyond = beyond_kink(problem_, last, record_.branch().points.back(), settings_.options.trace,
                                                 [this] { return record_.interrupted_now(); });
  if (!beyond) return false;
  last = std::move(beyond->curve);
  holds_more_ = holds_more(problem_, last.u);
  append_beyond_kink(last.u, std::move(beyond->point), beyond->goes_on);
  if (holds_more_) last.tangent = (beyond->goes_on ? onwards : -onwards) * pin_held_states();
  return true;
}

void StatesFollower::append_beyond_kink(const Vector& u, BranchPoint point, bool goes_on) {
  Branch& branch = record_.branch();
  constexpr double close = 1e-5;
  const double jump = point.arclength - branch.points.back().arclength < close ? least_jump : sure_jump;
  if (holds_more_ || is_kink(branch.points.back(), point, jump)) {
    const std::size_t before = holds_more_ ? last_before_hold(branch) : branch.points.size() - 1;
    PointBetween last, next;
    last.curve.u = record_.last();
    last.branch = branch.points[before];
    next.curve.u = u;
    next.branch = point;
    SpecialPoint kink = kink_between(problem_, last, next, branch, goes_on);
    kink.after_point = before;
    branch.special_points.push_back(std::move(kink));
  }
  record_.append_apart(u, std::move(point));
}

Vector StatesFollower::pin_held_states() {
  problem_.pin(problem_.kept_states(record_.last()));
  holds_more_ = false;
  return problem_.parameter_direction();
}

}  // namespace graze
