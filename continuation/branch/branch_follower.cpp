// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch/branch_end.hpp>
#include <graze/continuation/branch/branch_follower.hpp>
#include <graze/continuation/branch/branch_step.hpp>
#include <graze/continuation/branch/kink.hpp>
#include <graze/continuation/conditions/grazing_by_events.hpp>
#include <graze/continuation/conditions/hopf.hpp>
#include <graze/continuation/problems/clear_section.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

/// All representations of the orbit at a point of a branch: a branch that returns to any of them is closed.
std::vector<CurvePoint> images_of(const BranchProblem& problem, const CurvePoint& point) {
  std::vector<CurvePoint> list;
  for (BranchProblem::Image& image : problem.images(point.u, point.tangent)) {
    CurvePoint same = point;
    same.u = std::move(image.u);
    same.tangent = std::move(image.tangent);
    list.push_back(std::move(same));
  }
  return list;
}

/// True if the restitution is zero (k_r = 0): each impact is its own complete chatter, and the mass leaves as soon as no force
/// presses it to the barrier. The state changes continuously there.
bool is_plastic(const HybridSystem& system, const Vector& p) {
  return std::any_of(system.events.begin(), system.events.end(), [&](const Event& event) {
    return event.accumulation && event.log_volume_change && std::isinf(event.log_volume_change(p));
  });
}

struct ValueAt {
  double arclength, value;
};

/// Whether a test function may pass zero twice in the last step. Criterion: the parabola through its values at three
/// consecutive points, the last two of one sign, passes zero in that step or comes close to it.
bool may_pass_zero_twice(const ValueAt& earlier, const ValueAt& before, const ValueAt& after) {
  constexpr double near = 0.1;  // of the value at the beginning of the step
  const double slope = (before.value - earlier.value) / (before.arclength - earlier.arclength);
  const double bend =
      ((after.value - before.value) / (after.arclength - before.arclength) - slope) / (after.arclength - earlier.arclength);
  const double turn = 0.5 * (earlier.arclength + before.arclength - slope / bend);
  if (!(turn > before.arclength && turn < after.arclength)) return false;
  const double there =
      earlier.value + slope * (turn - earlier.arclength) + bend * (turn - earlier.arclength) * (turn - before.arclength);
  return there / before.value < near;
}

}  // namespace

BranchFollower::BranchFollower(const HybridSystem& system, const ContinuationOptions& options, double low, double high)
    : system_(system), options_(options), low_(low), high_(high), hard_contacts_(has_hard_contacts(system)),
      tests_(test_functions()) {
  tests_.insert(tests_.end(), options.further_tests.begin(), options.further_tests.end());
}

bool BranchFollower::interrupted_now() {
  interrupted_ = interrupted_ || (options_.cancelled && options_.cancelled());
  return interrupted_;
}

/// Handles the end of the range: moves the end of the step onto it. Empty if the step does not reach it. A step that begins on
/// the end of the range and ends outside has passed a fold and must be shortened.
std::optional<Verdict> BranchFollower::end_of_range(BranchProblem& problem, const CurvePoint& before, CurvePoint& after) const {
  const double value = problem.value(after.u), last = problem.value(before.u);
  const double tolerance = 1e-14 * (1.0 + std::abs(high_));
  const bool above = value >= high_ - tolerance && last < high_ && value > last;
  const bool below = value <= low_ + tolerance && last > low_ && value < last;
  if (!above && !below) {
    const bool outside = value > high_ + tolerance || value < low_ - tolerance;
    return outside ? std::optional(Verdict::reject) : std::nullopt;
  }
  const double bound = above ? high_ : low_;
  const Vector u = at_value(problem, before.u + (bound - last) / (value - last) * (after.u - before.u), bound, options_.trace);
  if (u.size() == 0) return Verdict::reject;
  const double length = after.arclength - before.arclength;
  after.arclength = before.arclength + length * std::clamp((bound - last) / (value - last), 0.0, 1.0);
  after.u = u;
  after.tangent = tangent_at(problem.zero_problem(), u, before.tangent);
  return after.tangent.size() == 0 ? Verdict::reject : Verdict::stop;
}

void BranchFollower::begin(BranchProblem& problem, const Vector& u, Branch& branch) {
  branch.points.push_back(problem.branch_point(u, 0.0));
  last_ = u;
  earlier_ = {};
  mark(problem, u, PointType::EP, branch);
}

/// Locates the special points between the last point and the next, and appends the next point. False if the step must be
/// halved. `met`: special points that are already located in the step.
bool BranchFollower::take(BranchProblem& problem, const CurvePoint& before, const CurvePoint& after, BranchPoint point,
                          std::vector<PointInStep> met, Branch& branch) {
  // A special point that is announced but not found may be a step onto a nearby branch.
  constexpr double smallest_doubt = 1e-5, smallest_step = 1e-8;
  const bool long_step = !corner_ && after.arclength - before.arclength > smallest_doubt;
  const auto doubtful = [&](const PointInStep& special) { return special.point.status != PointStatus::converged && long_step; };
  if (std::any_of(met.begin(), met.end(), doubtful)) return false;
  const TestPoint a{before, branch.points.back()}, b{after, point};
  constexpr double longest_undivided = 1e-3;
  const bool divisible = !corner_ && met.empty() && after.arclength - before.arclength > longest_undivided;
  EarlierValues values{a.branch.arclength, {}};
  for (const TestFunction& test : tests_) {
    const double f_a = test.value(a), f_b = test.value(b);
    values.values.push_back(f_a);
    if (!std::isfinite(f_a) || !std::isfinite(f_b)) continue;
    if ((f_a < 0.0) == (f_b < 0.0)) {
      const std::size_t index = values.values.size() - 1;
      if (divisible && !earlier_.values.empty() &&
          may_pass_zero_twice({earlier_.arclength, earlier_.values[index]}, {a.branch.arclength, f_a}, {point.arclength, f_b}))
        return false;
      continue;
    }
    const bool confirmed = test.confirm(a, b);
    if (!confirmed && !(test.too_far_apart && test.too_far_apart(a, b))) continue;
    if (in_rounding(test, a, b)) continue;
    std::optional<PointInStep> special =
        locate_in_step(problem, test, a, b, {.halve = !confirmed, .at_corner = corner_.has_value()}, branch, options_.trace);
    if (!special) {
      if (confirmed && long_step) return false;
      continue;
    }
    // A fold beyond the end of the range: the branch leaves the range and returns within the step.
    const bool outside = special->point.value < low_ || special->point.value > high_;
    if (outside && test.type == PointType::LP && long_step) return false;
    met.push_back(std::move(*special));
    if (corner_) {  // at the tip of the corner: within the smallest step of the grazing, on the contact side
      SpecialPoint& tip = met.back().point;
      tip.status = PointStatus::bracketed;
      tip.value = corner_->value;
      tip.precision = smallest_step;
      tip.interval[0] = tip.value - tip.precision;
      tip.interval[1] = tip.value + tip.precision;
      met.back().place = corner_->place + (corner_->to_contact ? 1e-12 : -1e-12);
    }
    if (doubtful(met.back())) return false;
  }
  add_user_points(problem, before, after, options_.user_values, options_.trace, branch, met);
  std::stable_sort(met.begin(), met.end(), [](const PointInStep& x, const PointInStep& y) { return x.place < y.place; });
  for (PointInStep& special : met) branch.special_points.push_back(std::move(special.point));
  earlier_ = std::move(values);
  branch.points.push_back(std::move(point));
  last_ = after.u;
  if (options_.progress) options_.progress(branch);
  return true;
}

/// Ends the branch just before a place in the step where its orbits end, and locates the special points up to there.
Verdict BranchFollower::end_before(BranchProblem& problem, const CurvePoint& before, double part, CurvePoint& after,
                                   Branch& branch) {
  constexpr double just_before = 0.9;
  const Vector chord = after.u - before.u;
  CurvePoint last;
  last.u = before.u + just_before * part * chord;
  last.arclength = before.arclength + just_before * part * (after.arclength - before.arclength);
  if (!correct(problem.zero_problem(), chord, last.u, options_.trace).converged()) return Verdict::reject;
  last.tangent = tangent_at(problem.zero_problem(), last.u, before.tangent);
  BranchPoint point = problem.branch_point(last.u, branch.points.back().arclength + last.arclength - before.arclength);
  if (last.tangent.size() == 0 || !point.multipliers.valid || !problem.is_motion(last.u)) return Verdict::reject;
  if (point.isolated_impacts != branch.points.back().isolated_impacts) return Verdict::reject;
  if (!take(problem, before, last, std::move(point), {}, branch)) return Verdict::reject;
  after = std::move(last);
  return Verdict::stop;
}

/// Ends a doubled branch if it passes through the orbit of half its period in the step. Empty: it does not.
std::optional<Verdict> BranchFollower::end_at_half(BranchProblem& problem, const CurvePoint& before, CurvePoint& after,
                                                   Branch& branch) {
  const auto part = zero_crossing(problem.half_difference(before.u), problem.half_difference(after.u));
  if (!part) return std::nullopt;
  const Verdict verdict = end_before(problem, before, *part, after, branch);
  const double end = branch.points.back().value;
  if (verdict == Verdict::stop)
    ending_ = {BranchStop::returned, end,
               fmt::format("the doubled orbit has returned to its parent near {} = {:.12g}", branch.parameter, end)};
  return verdict;
}

/// Ends the branch of an autonomous system if its orbit shrinks to an equilibrium in the step. Empty: it does not. A step that
/// seems to pass an equilibrium without a Hopf point went over to the same orbit half a turn later, and is shortened.
std::optional<Verdict> BranchFollower::end_at_equilibrium(OrbitProblem& problem, const CurvePoint& before, CurvePoint& after,
                                                          Branch& branch) {
  constexpr double middle = 0.5, shortest = 1e-6;
  std::optional<double> part = zero_crossing(field_at_first_node(problem, before.u), field_at_first_node(problem, after.u));
  if (!part && is_equilibrium(problem, after.u)) part = middle;
  if (!part) return std::nullopt;
  const double length = after.arclength - before.arclength;
  const std::optional<double> hopf = locate_hopf(problem, before.u);
  if (!hopf || std::abs(*hopf - problem.value(before.u)) > 2.0 * length * problem.scale())
    return length > shortest ? std::optional(Verdict::reject) : std::nullopt;
  const Verdict verdict = end_before(problem, before, *part, after, branch);
  if (verdict == Verdict::stop)
    ending_ = {BranchStop::equilibrium, *hopf,
               fmt::format("the orbit shrinks to an equilibrium at {} = {:.12g} (a Hopf point)", branch.parameter, *hopf)};
  return verdict;
}

/// Ends the branch at its last point, where a chatter becomes complete or ceases to be.
void BranchFollower::end_at_chatter(const Branch& branch) {
  const BranchPoint& end = branch.points.back();
  const bool sticks = end.isolated_impacts < end.impacts;
  const std::string event =
      end.impacts == 0 && holds_something(system_, end.signature.mode)
          ? "a mass that is held along all orbits before is released there and returns to its stop by complete chatter"
          : fmt::format("the chatter {} complete, and the mass {}", sticks ? "is no longer" : "becomes",
                        sticks ? "does not stick beyond" : "sticks beyond");
  ending_ = {BranchStop::chatter, end.value, fmt::format("at {} = {:.12g} {}", branch.parameter, end.value, event)};
}

Verdict BranchFollower::monitor_states(OrbitProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch) {
  if (interrupted_now()) return Verdict::stop;
  const std::optional<Verdict> end = end_of_range(problem, before, after);
  if (end == Verdict::reject) return Verdict::reject;
  BranchPoint point = problem.branch_point(after.u, branch.points.back().arclength + after.arclength - before.arclength);
  if (!point.multipliers.valid || leaves_branch(system_, symmetries_, branch, point)) return Verdict::reject;
  if (releases_pinned(problem, point)) return Verdict::reject;
  // When a chatter becomes incomplete, infinitely many impacts separate, each with its own grazing.
  const bool sticks = point.isolated_impacts < point.impacts;
  const bool switches = sticks != (branch.points.back().isolated_impacts < branch.points.back().impacts);
  const bool plastic = switches && is_plastic(system_, problem.equations().parameters());
  if (hard_contacts_ && switches && !plastic) {
    if (after.arclength - before.arclength > 1e-7) return Verdict::reject;
    end_at_chatter(branch);
    return Verdict::stop;
  }
  // A step must not cross several grazings: it is halved until one remains or they cannot be separated. Contacts that graze
  // together (an orbit symmetric between two barriers) count as one.
  const int change = plastic && point.impacts == branch.points.back().impacts
                         ? 0
                         : std::abs(point.isolated_impacts - branch.points.back().isolated_impacts);
  // Orbits on the two sides of a hard grazing are different families, even if the corrector converges across it: never step
  // over one.
  if (change == 1 && hard_contacts_) return Verdict::reject;
  const bool close = after.arclength - before.arclength <= 1e-7;
  if (change > 1 && hard_contacts_ && !close) return Verdict::reject;
  // Friction holds a body all along from here on: the orbits beyond keep its place, which is pinned.
  holds_more_ = point.signature != branch.points.back().signature && holds_more(problem, after.u);
  if (holds_more_ || is_kink(branch.points.back(), point)) {
    if (!close) return Verdict::reject;
    const bool rises = problem.value(after.u) > problem.value(before.u), rose = before.tangent[before.tangent.size() - 1] > 0.0;
    append_beyond_kink(problem, after.u, std::move(point), rises == rose, branch);
    holds_more_ = holds_more_ && !end;
    return end || holds_more_ ? Verdict::stop : Verdict::go_on;
  }
  if (const auto verdict = end_at_half(problem, before, after, branch)) return *verdict;
  if (const auto verdict = end_at_equilibrium(problem, before, after, branch)) return *verdict;
  std::vector<PointInStep> met;
  if (change == 1 || (change > 1 && !hard_contacts_)) met.push_back(locate_impact_change(problem, before, after, point, branch));
  if (change > 1 && !close && met.back().point.status != PointStatus::converged) return Verdict::reject;
  if (auto kink = kink_in_step(problem, {before, branch.points.back()}, {after, point}, branch, options_.trace))
    met.push_back(std::move(*kink));
  if (!take(problem, before, after, std::move(point), std::move(met), branch)) return Verdict::reject;
  if (end) return Verdict::stop;
  section_blocked_ = better_section(problem, after.u) != problem.equations().section_phase();
  return section_blocked_ ? Verdict::stop : Verdict::go_on;
}

/// A branch that starts on a grazing begins with the first orbit beyond it whose impacts are fast enough. If the branch ends
/// before (between two grazings close together, or at the end of the range), it keeps the orbit whose weakest impact is
/// fastest.
Verdict BranchFollower::monitor_beyond_grazing(SignatureProblem& problem, const CurvePoint& before, CurvePoint& after,
                                               Branch& branch) {
  const double value = problem.value(after.u);
  const bool outside = value < low_ || value > high_;
  refused_ = problem.violation(after.u);
  if (!outside && !refused_) {
    const double speed = problem.least_speed(after.u);
    if (speed > fastest_) {
      fastest_ = speed;
      fastest_point_ = after.u;
    }
    if (speed < least_kept_speed) return Verdict::go_on;
    const std::optional<CurvePoint> nearer = special_point_near_grazing(problem, beginning_, after);
    begin(problem, nearer ? nearer->u : after.u, branch);
    if (!nearer) return Verdict::go_on;
    BranchPoint point = problem.branch_point(after.u, after.arclength - nearer->arclength);
    if (point.multipliers.valid && take(problem, *nearer, after, std::move(point), {}, branch)) return Verdict::go_on;
    branch.points.clear();
    branch.special_points.clear();
    return Verdict::reject;
  }
  if (fastest_ < least_resolved_speed) return outside ? Verdict::stop : Verdict::reject;
  begin(problem, fastest_point_, branch);
  const double bound = std::clamp(value, low_, high_);
  if (outside)
    ending_ = {
        BranchStop::reached_bound, bound,
        fmt::format("the end of the range, {} = {:.12g}, was reached with an impact slower than {} all along; the orbit with "
                    "the fastest is kept",
                    branch.parameter, bound, least_kept_speed)};
  if (outside || reaches_grazing(problem, before, after, branch)) return Verdict::stop;
  branch.points.clear();
  branch.special_points.clear();
  return Verdict::reject;
}

Verdict BranchFollower::monitor_signature(SignatureProblem& problem, const CurvePoint& before, CurvePoint& after,
                                          Branch& branch) {
  if (interrupted_now()) return Verdict::stop;
  if (branch.points.empty()) return monitor_beyond_grazing(problem, before, after, branch);
  const std::optional<Verdict> end = end_of_range(problem, before, after);
  if (end == Verdict::reject) return Verdict::reject;
  refused_ = problem.violation(after.u);
  if (refused_) return reaches_grazing(problem, before, after, branch) ? Verdict::stop : Verdict::reject;
  BranchPoint point = problem.branch_point(after.u, branch.points.back().arclength + after.arclength - before.arclength);
  if (!point.multipliers.valid || leaves_branch(system_, symmetries_, branch, point)) return Verdict::reject;
  if (const auto verdict = end_at_half(problem, before, after, branch)) return *verdict;
  if (!take(problem, before, after, std::move(point), {}, branch)) return Verdict::reject;
  return end.value_or(Verdict::go_on);
}

/// Makes the last step onto the end of the range: if the model allows no value beyond it, no step leads across it.
bool BranchFollower::end_on_bound(BranchProblem& problem, Branch& branch) {
  const BranchPoint& end = branch.points.back();
  for (const double bound : {low_, high_}) {
    if (end.value == bound || std::abs(end.value - bound) > 1e-6 * (1.0 + std::abs(bound))) continue;
    const Vector u = at_value(problem, last_, bound, options_.trace);
    if (u.size() == 0) return false;
    BranchPoint point = problem.branch_point(u, end.arclength + std::abs(end.value - bound) / (high_ - low_));
    if (!point.multipliers.valid || point.signature != end.signature) return false;
    branch.points.push_back(std::move(point));
    last_ = u;
    return true;
  }
  return false;
}

Curve BranchFollower::follow_states(OrbitProblem& problem, const BranchStart& given, Branch& branch) {
  Vector start = given.u, direction = given.orientation;
  // Moves start and direction to a section clear of impacts, if needed.
  const auto clear_section = [&] {
    const double current = problem.equations().section_phase(), section = better_section(problem, start);
    if (section == current) return;
    // Without forcing the phase is counted from the first node.
    const bool autonomous = problem.equations().autonomous();
    OrbitProblem moved = problem.with_section(autonomous ? current : section);
    const auto move = [&](const Vector& u) {
      const double turn = problem.equations().duration(u.head(u.size() - 1)) / problem.period();
      return autonomous ? problem.carried_on(u, (section - current) * turn) : problem.to_section(moved, u);
    };
    // Small against the square of the speed of a weak impact: the impact exists within that distance of the barrier.
    const double small = 1e-8 / std::max(1e-300, direction.lpNorm<Eigen::Infinity>());
    const auto here = move(start), before = move(start - small * direction);
    if (!here) return;
    direction =
        before ? Vector((*here - *before) / small) : Vector(direction[direction.size() - 1] * moved.parameter_direction());
    start = *here;
    moved.pin_as(problem, start);
    problem = std::move(moved);
  };
  clear_section();
  Curve curve;
  // Start of the branch: a closed branch returns there, possibly with its nodes on another section.
  std::optional<CurvePoint> first, origin;
  double first_section = 0.0;
  const ClosurePoints closure_points = [&](const CurvePoint& start_point) {
    return images_of(problem, origin.value_or(start_point));
  };
  TraceOptions trace_options = options_.trace;
  for (;;) {
    section_blocked_ = false;
    const ZeroProblem zero = problem.zero_problem();
    // A curve that continues the branch repeats the branch's last point as its first.
    const int kept = std::max(1, static_cast<int>(branch.points.size()));
    trace_options.max_points = std::max(1, options_.trace.max_points - kept + 1);
    const auto on_branch = [&](const CurvePoint& before, CurvePoint& after) {
      if (branch.points.empty()) begin(problem, before.u, branch);
      if (!first) {
        first = before;
        first_section = problem.equations().section_phase();
      }
      return monitor_states(problem, before, after, branch);
    };
    curve = trace(zero, start, direction, trace_options, on_branch, closure_points);
    const Vector plain = std::copysign(1.0, direction[direction.size() - 1]) * problem.parameter_direction();
    if (curve.stop == TraceStop::start_failed && branch.points.empty() && direction != plain) {
      direction = plain;
      continue;
    }
    if (curve.stop == TraceStop::monitor && holds_more_) {
      trace_options.initial_step = 1e-6;
      start = last_;
      direction = std::copysign(1.0, direction[direction.size() - 1]) * pin_what_is_held(problem);
      continue;
    }
    // A start that fails may be the last point of the branch, too close to a kink to be reproduced.
    const bool not_begun = curve.stop == TraceStop::start_failed && !branch.points.empty();
    const bool fails = curve.stop == TraceStop::min_step && !branch.points.empty();
    CurvePoint last;
    if (not_begun) {
      last.u = start;
      last.tangent = direction / weighted_norm(zero.weights, direction);
    } else if (fails) {
      last = curve.points.back();
    }
    if ((fails && !hard_contacts_ && step_around_corner(problem, branch, last)) ||
        ((fails || not_begun) && step_over_kink(problem, branch, last))) {
      trace_options.initial_step = 1e-6;
      start = last.u;
      direction = last.tangent;
      continue;
    }
    if (fails && !hard_contacts_) {
      trace_options.initial_step = 1e-6;
      // States within a stiff contact vary as steeply as those at a hard impact.
      section_blocked_ = !clear_of_soft_;
      clear_of_soft_ = true;
      section_blocked_ = section_blocked_ && better_section(problem, last.u) != problem.equations().section_phase();
      if (!section_blocked_) break;
    } else if (curve.stop != TraceStop::monitor || !section_blocked_) {
      break;
    }
    start = curve.points.back().u;
    direction = curve.points.back().tangent;
    const double arclength = branch.points.back().arclength;
    clear_section();
    branch.points.back() = problem.branch_point(start, arclength);
    last_ = start;
    origin.reset();
    OrbitProblem at_first = problem.with_section(first_section);
    if (const auto u = at_first.to_section(problem, first->u)) {
      const double forward = std::copysign(1.0, first->tangent[first->tangent.size() - 1]);
      origin.emplace();
      origin->u = *u;
      origin->tangent = tangent_at(problem.zero_problem(), *u, forward * problem.parameter_direction());
      if (origin->tangent.size() == 0) origin.reset();
    }
  }
  return curve;
}

/// The start in the coordinates of its signature; nullopt if it sticks or has no events.
std::optional<BranchStart> BranchFollower::to_signature(OrbitProblem& problem, const BranchStart& start) const {
  const std::optional<EventNodes> here = event_nodes(problem.orbit(start.u));
  if (!here) return std::nullopt;
  BranchStart out;
  out.sequence = here->sequence;
  out.step = start.step;
  const SignatureProblem moved(system_, problem.equations().parameters(), problem.period(), here->sequence, problem.parameter(),
                               problem.scale(), problem.equations().options());
  out.u = moved.pack(*here, problem.value(start.u));
  out.orientation = start.orientation[start.orientation.size() - 1] * moved.parameter_direction();
  // If only the parameter gives the direction, differences are useless: the displaced states are no orbits.
  if (start.orientation.head(start.orientation.size() - 1).isZero(0.0)) return out;
  // The direction by finite differences. The difference is small against the square of the speed of a weak impact, because the
  // impact exists within that distance of the barrier.
  const double small = 1e-8 / std::max(1e-300, start.orientation.lpNorm<Eigen::Infinity>());
  const Vector u_before = start.u - small * start.orientation;
  const std::optional<EventNodes> before = event_nodes(problem.orbit(u_before));
  if (before && before->sequence == here->sequence) {
    const Vector direction = (out.u - moved.pack(*before, problem.value(u_before))) / small;
    if (direction.allFinite() && direction.lpNorm<Eigen::Infinity>() < 1e6) out.orientation = direction;
  }
  return out;
}

Curve BranchFollower::follow_signature(SignatureProblem& problem, const BranchStart& start, Branch& branch) {
  if (start.on_grazing) beginning_ = start.u;
  return trace(
      problem.zero_problem(), start.u, start.orientation, options_.trace,
      [&](const CurvePoint& before, CurvePoint& after) {
        if (branch.points.empty() && !start.on_grazing) begin(problem, before.u, branch);
        return monitor_signature(problem, before, after, branch);
      },
      [&](const CurvePoint& first) { return images_of(problem, first); });
}

/// The start for continuing the branch in states where the coordinates of the events end: where an impact with zero restitution
/// turns into sticking, or where events of a contact that leads through other modes coincide. `problem` is moved to the section
/// of the branch's last point.
std::optional<BranchStart> BranchFollower::continuation_in_states(OrbitProblem& problem, const SignatureProblem& signature,
                                                                  const Curve& curve, const Branch& branch) const {
  if (curve.stop != TraceStop::min_step || grazing_ || branch.points.empty() || curve.points.empty()) return std::nullopt;
  const std::vector<std::size_t>& sequence = signature.equations().sequence();
  const bool sticks = refused_ && refused_->met && !begins_contact(system_.events[refused_->met->event].kind);
  const bool through_modes = std::any_of(sequence.begin(), sequence.end(), [&](std::size_t event) {
    return system_.events[event].to != system_.events[event].from;
  });
  if (!through_modes && !sticks && !is_plastic(system_, signature.equations().parameters())) return std::nullopt;
  const BranchPoint& end = branch.points.back();
  OrbitProblem there = problem.with_section(end.section_phase);
  if (there.nodes() != static_cast<int>(end.nodes.size())) return std::nullopt;
  BranchStart from;
  from.u = there.pack(end.nodes, end.duration, end.value);
  const Vector& tangent = curve.points.back().tangent;
  const double way = tangent.size() > 0 ? std::copysign(1.0, tangent[tangent.size() - 1]) : 1.0;
  from.orientation = way * there.parameter_direction();
  problem = std::move(there);
  problem.measure_by(from.u);
  problem.pin_as(signature, from.u);
  return from;
}

std::optional<GrazingEnd> BranchFollower::follow(OrbitProblem& problem, const BranchStart& start, Branch& branch) {
  symmetries_ = flight_symmetries(system_, branch.parameters);
  interrupted_ = clear_of_soft_ = holds_more_ = false;
  fastest_ = 0.0;
  ending_.reset();
  refused_.reset();
  grazing_.reset();
  std::optional<BranchStart> by_events;
  if (start.sequence) {
    by_events = start;
  } else if (hard_contacts_ && !problem.equations().autonomous()) {
    by_events = to_signature(problem, start);
  }
  if (by_events) {
    SignatureProblem signature(system_, branch.parameters, problem.period(), *by_events->sequence, problem.parameter(),
                               problem.scale(), problem.equations().options());
    signature.measure_by(by_events->u);
    signature.pin(signature.kept_states(by_events->u));
    const Curve curve = follow_signature(signature, *by_events, branch);
    if (const auto states = continuation_in_states(problem, signature, curve, branch)) {
      last_ = states->u;
      const Curve on = follow_states(problem, *states, branch);
      return finish(problem, on, branch, false);
    }
    if (!branch.points.empty() || start.sequence) return finish(signature, curve, branch, start.on_grazing);
  }
  problem.measure_by(start.u);
  problem.pin(problem.kept_states(start.u));
  const Curve curve = follow_states(problem, start, branch);
  return finish(problem, curve, branch, false);
}

std::optional<GrazingEnd> BranchFollower::finish(BranchProblem& problem, const Curve& curve, Branch& branch, bool on_grazing) {
  TraceStop why = curve.stop;
  branch.time_carried = problem.time_carried();
  // Orbits between two grazings are kept if the second grazing could not be resolved.
  if (branch.points.empty() && on_grazing && why == TraceStop::min_step && fastest_ >= least_resolved_speed)
    begin(problem, fastest_point_, branch);
  const bool nothing_beyond = branch.points.empty() && on_grazing && !curve.points.empty();
  if (branch.points.empty() && !curve.points.empty() && !on_grazing) begin(problem, curve.points.front().u, branch);
  if (branch.points.empty()) {
    branch.stop = interrupted_ ? BranchStop::interrupted : BranchStop::start_failed;
    branch.stop_value = branch.parameters[static_cast<Eigen::Index>(problem.parameter())];
    if (interrupted_) {
      branch.message = "it was interrupted";
    } else if (!nothing_beyond) {
      branch.message = "the first point did not converge: " + curve.failure;
    } else if (refused_ && !refused_->lost) {
      branch.message = "the orbit with one impact more meets a barrier elsewhere at once";
    } else {
      branch.message = "no admissible orbit was found beyond the grazing: " + curve.failure;
    }
    return std::nullopt;
  }
  if (why == TraceStop::min_step && end_on_bound(problem, branch)) why = TraceStop::monitor;
  branch.direction = branch.points.size() > 1 && branch.points[1].value < branch.points[0].value ? -1 : 1;
  const BranchPoint& end = branch.points.back();
  branch.stop_value = end.value;
  const auto stop = [&](BranchStop reason, std::string message) {
    branch.stop = reason;
    branch.message = std::move(message);
  };
  auto* states = dynamic_cast<OrbitProblem*>(&problem);
  // If a free motion does not reproduce a weak impact of the last point, following in states cannot start there.
  const bool broken_off = why == TraceStop::min_step || why == TraceStop::start_failed;
  const bool released = curve.first_failed && problem.kept_states(*curve.first_failed).size() < problem.pinned().size();
  if (broken_off && states && !released) {
    const double onwards = curve.points.empty() ? 0.0 : curve.points.back().tangent[curve.points.back().tangent.size() - 1];
    grazing_ = grazing_at_failure(*states, onwards, branch);
  }
  if (grazing_) {
    const SpecialPoint& point = branch.special_points.back();
    branch.stop_value = point.value;
    if (branch.points.size() == 1) branch.direction = point.value < end.value ? -1 : 1;
    stop(BranchStop::grazing, fmt::format("grazing at {} = {:.12g}: an impact is {} ({})", branch.parameter, point.value,
                                          grazing_->lost ? "lost" : "gained", grazing_scenario_name(grazing_->grazing.scenario)));
    return std::move(grazing_);
  }
  if (interrupted_) {
    stop(BranchStop::interrupted, "it was interrupted");
  } else if (ending_) {
    branch.stop_value = ending_->value;
    stop(ending_->reason, std::move(ending_->message));
  } else if (why == TraceStop::monitor) {
    stop(BranchStop::reached_bound, fmt::format("the end of the range, {} = {:.12g}, was reached", branch.parameter, end.value));
  } else if (why == TraceStop::closed) {
    stop(BranchStop::returned,
         fmt::format("the branch is closed: at {} = {:.12g} it is back where it was before", branch.parameter, end.value));
  } else if (why == TraceStop::point_limit) {
    stop(BranchStop::point_limit, fmt::format("{} points were computed, the limit", branch.points.size()));
  } else {
    const bool meets_release = refused_ && refused_->met && system_.events[refused_->met->event].kind == EventKind::release;
    // A little farther, where the release is surely resolved.
    const double ahead = curve.first_failed ? problem.value(*curve.first_failed) - end.value : 0.0;
    const double beyond = std::max(std::abs(ahead), 1e-6 * (1.0 + std::abs(end.value)));
    const bool lifts_off = ahead != 0.0 && releases_beyond(system_, branch, end.value + std::copysign(beyond, ahead));
    const std::string reason = released || meets_release || lifts_off
                                   ? "a mass that is held along all orbits before is released there"
                               : refused_ ? "several contacts graze there so close together that they cannot be told apart"
                                          : curve.failure;
    const double last = curve.points.empty() ? end.value : problem.value(curve.points.back().u);  // empty: not begun again
    stop(BranchStop::step_too_small,
         fmt::format("no point is found beyond {} = {:.12g} even with the smallest step ({})", branch.parameter, last, reason));
    if (curve.first_failed) {
      BranchPoint failed;
      failed.value = problem.value(*curve.first_failed);
      failed.duration = end.duration;
      if (states && states->equations().section_phase() == 0.0) failed.states = {curve.first_failed->head(states->states())};
      branch.first_failed = std::move(failed);
    }
  }
  mark(problem, last_, branch.stop == BranchStop::step_too_small ? PointType::MX : PointType::EP, branch);
  return std::nullopt;
}

double BranchFollower::better_section(OrbitProblem& problem, const Vector& u) const {
  return hard_contacts_ || clear_of_soft_ ? clear_section(problem, u) : problem.equations().section_phase();
}

void BranchFollower::mark(BranchProblem& problem, const Vector& u, PointType type, Branch& branch) {
  branch.special_points.push_back(plain_point(problem, u, type, branch));
}

bool BranchFollower::reaches_grazing(SignatureProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch) {
  const ZeroProblem zero = problem.zero_problem();
  const double length = after.arclength - before.arclength;
  const Vector chord = after.u - before.u;
  auto beyond = problem.violation(after.u);
  Vector good = before.u;
  double lo = 0.0, hi = 1.0;
  // Bisects until the last motion (with impacts of at least that speed) and the first solution that is no motion are adjacent.
  const auto narrow_bracket = [&](double speed) {
    for (int i = 0; i < 40 && (hi - lo) * length > 1e-9; ++i) {
      const double middle = 0.5 * (lo + hi);
      Vector u = before.u + middle * chord;
      if (!correct(zero, chord, u, options_.trace).converged()) return false;
      const auto violation = problem.violation(u);
      if (violation) beyond = violation;
      if (violation || problem.least_speed(u) < speed) {
        hi = middle;
      } else {
        good = u;
        lo = middle;
      }
    }
    return true;
  };
  if (!narrow_bracket(least_kept_speed)) return false;
  // An orbit about to gain an impact is kept only at this distance before the grazing, where a free run separates it from the
  // grazing.
  constexpr double least_separation = 1e-8;
  CurvePoint last = before;
  last.u = good;
  double kept = lo;
  if (!beyond->lost && lo * length > least_separation) {
    const double earlier = lo - least_separation / length;
    Vector u = before.u + earlier * chord;
    if (correct(zero, chord, u, options_.trace).converged() && !problem.violation(u)) {
      last.u = std::move(u);
      kept = earlier;
    }
  }
  last.arclength = before.arclength + kept * length;
  last.tangent = tangent_at(zero, last.u, before.tangent);
  BranchPoint point;
  if (kept > 0.0 && last.tangent.size() > 0) point = problem.branch_point(last.u, branch.points.back().arclength + kept * length);
  hi = 1.0;
  if (!narrow_bracket(0.0)) return false;
  const std::size_t parameter = parameter_index(system_.parameters, options_.parameter);
  // Added to the width of the bracket: the effect of rounding in a speed or a gap.
  constexpr double next_to = 1e-7;
  std::optional<GrazingAhead> ahead = grazing_ahead(problem, good, *beyond, parameter, next_to + 4.0 * (hi - lo) * length);
  if (!ahead) return false;
  // Special points before the grazing are located in this step; the multipliers at the grazing itself are singular.
  if (point.multipliers.valid && !take(problem, before, last, std::move(point), {}, branch)) return false;
  if (!(kept > 0.0 && last.tangent.size() > 0)) last = before;
  if (!append_points_before_grazing(problem, ahead->u, last, branch)) return false;
  const int impacts = branch.points.back().impacts;
  branch.special_points.push_back(
      grazing_point(system_, ahead->grazing, impacts, impacts + (ahead->lost ? -ahead->grazing.touches : 1), branch));
  after = std::move(last);
  grazing_ = GrazingEnd{std::move(ahead->grazing), ahead->lost};
  return true;
}

/// Detects a fold or a period doubling closer to the grazing than the branch's points: the signs of its conditions, regular in
/// the coordinates of the events, differ between the grazing and `point`. Then halves the distance to the grazing until the
/// signs are those at the grazing, and returns that point; empty if there is none.
std::optional<CurvePoint> BranchFollower::special_point_near_grazing(SignatureProblem& problem, const Vector& grazing,
                                                                     const CurvePoint& point) const {
  const ZeroProblem zero = problem.zero_problem();
  struct Signs {
    bool turned, doubled;
    bool operator==(const Signs&) const = default;
  };
  const auto signs = [&](const Vector& u, const Vector& tangent) {
    return Signs{tangent[tangent.size() - 1] < 0.0, problem.cyclic(u, -1.0).real().partialPivLu().determinant() < 0.0};
  };
  const Vector tangent = tangent_at(zero, grazing, point.tangent);
  if (tangent.size() == 0) return std::nullopt;
  const Signs there = signs(grazing, tangent);
  if (there == signs(point.u, point.tangent)) return std::nullopt;
  const Vector chord = point.u - grazing;
  for (double part = 0.5; part * weighted_norm(zero.weights, chord) > least_resolved_speed; part *= 0.5) {
    CurvePoint between;
    between.u = grazing + part * chord;
    if (!correct(zero, chord, between.u, options_.trace).converged() || problem.violation(between.u)) return std::nullopt;
    between.tangent = tangent_at(zero, between.u, point.tangent);
    if (between.tangent.size() == 0) return std::nullopt;
    if (signs(between.u, between.tangent) != there) continue;
    between.arclength = point.arclength - (1.0 - part) * weighted_norm(zero.weights, chord);
    return between;
  }
  return std::nullopt;
}

bool BranchFollower::append_points_before_grazing(SignatureProblem& problem, const Vector& grazing, CurvePoint& last,
                                                  Branch& branch) {
  std::optional<CurvePoint> nearer = special_point_near_grazing(problem, grazing, last);
  if (!nearer) return true;
  nearer->arclength = 2.0 * last.arclength - nearer->arclength;  // mirrored: here the grazing lies ahead
  BranchPoint point = problem.branch_point(nearer->u, branch.points.back().arclength + nearer->arclength - last.arclength);
  if (!point.multipliers.valid) return true;
  if (!take(problem, last, *nearer, std::move(point), {}, branch)) return false;
  last = std::move(*nearer);
  return true;
}

/// Moves `last`, the end of the branch, beyond the grazing of a stiff contact. That grazing is a corner of the branch, narrower
/// than the steps can be (proportional to stiffness^-2); beyond it the branch continues like that of a hard contact. False if
/// there is no corner.
bool BranchFollower::step_around_corner(OrbitProblem& problem, Branch& branch, CurvePoint& last) {
  constexpr double near = 1e-4;
  const ZeroProblem zero = problem.zero_problem();
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
    const bool passed = met_last.type == PointType::GR && std::abs(met_last.value - value) < 1e-9 * (1.0 + std::abs(value));
    const bool to_contact = passed ? std::get<std::string>(met_last.details.at("kind")) == "gained" : !weakest;
    const int impacts = end.isolated_impacts + (passed ? 0 : to_contact ? 1 : -1);
    for (const double speed : {1e-3, 3e-3, 1e-2, 3e-4, 3e-2}) {
      // With contact: at that impact speed, as for a hard contact. Without: at that distance from the grazing.
      const double height = speed * speed / (2.0 * -located.curvature), side = located.top_dp > 0.0 ? -1.0 : 1.0;
      const double change = to_contact ? (located.response * speed + height) / located.top_dp : side * speed;
      Vector away = change * located.family_dp;
      if (to_contact) away += speed * located.impulse;
      CurvePoint next;
      next.u = located.u + away;
      if (!away.allFinite() || !correct(zero, problem.parameter_direction(), next.u, options_.trace).converged()) continue;
      if (weighted_norm(zero.weights, next.u - located.u - away) > 0.5 * weighted_norm(zero.weights, away)) continue;
      next.tangent = tangent_at(zero, next.u, next.u - located.u);
      next.arclength = last.arclength + weighted_norm(zero.weights, next.u - last.u);
      BranchPoint point = problem.branch_point(next.u, end.arclength + next.arclength - last.arclength);
      if (next.tangent.size() == 0 || !point.multipliers.valid || point.isolated_impacts != impacts) continue;
      std::vector<PointInStep> met;
      if (!passed)
        met.push_back(
            {place_of(zero, last, located.u), located.u, grazing_point(system_, located, end.impacts, point.impacts, branch)});
      corner_ = Corner{value, place_of(zero, last, located.u), to_contact};
      const bool taken = take(problem, last, next, std::move(point), std::move(met), branch);
      corner_.reset();
      if (!taken) continue;
      last = std::move(next);
      return true;
    }
  }
  return false;
}

/// Appends the first point beyond a kink, and the kink as a grazing, if it is one: events that pass a node or change places make
/// none. No test function is continuous across it.
void BranchFollower::append_beyond_kink(OrbitProblem& problem, const Vector& u, BranchPoint point, bool goes_on, Branch& branch) {
  constexpr double close = 1e-5;
  const double jump = point.arclength - branch.points.back().arclength < close ? least_jump : sure_jump;
  if (holds_more_ || is_kink(branch.points.back(), point, jump)) {
    const std::size_t before = holds_more_ ? last_before_hold(branch) : branch.points.size() - 1;
    PointBetween last, next;
    last.curve.u = last_;
    last.branch = branch.points[before];
    next.curve.u = u;
    next.branch = point;
    SpecialPoint kink = kink_between(problem, last, next, branch, goes_on);
    kink.after_point = before;
    branch.special_points.push_back(std::move(kink));
  }
  branch.points.push_back(std::move(point));
  last_ = u;
  earlier_ = {};
  if (options_.progress) options_.progress(branch);
}

/// From the last point on, pins the place of the bodies that friction holds. Returns the direction in which the parameter grows.
Vector BranchFollower::pin_what_is_held(OrbitProblem& problem) {
  problem.pin(problem.kept_states(last_));
  holds_more_ = false;
  return problem.parameter_direction();
}

/// Steps over a kink at the end of the branch: `last` becomes the first point beyond it.
bool BranchFollower::step_over_kink(OrbitProblem& problem, Branch& branch, CurvePoint& last) {
  const double onwards = std::copysign(1.0, last.tangent[last.tangent.size() - 1]);
  std::optional<BeyondKink> beyond =
      beyond_kink(problem, last, branch.points.back(), options_.trace, [this] { return interrupted_now(); });
  if (!beyond) return false;
  last = std::move(beyond->curve);
  holds_more_ = holds_more(problem, last.u);
  append_beyond_kink(problem, last.u, std::move(beyond->point), beyond->goes_on, branch);
  if (holds_more_) last.tangent = (beyond->goes_on ? onwards : -onwards) * pin_what_is_held(problem);
  return true;
}

/// The grazing at which the branch broke off; `onwards`: direction of the parameter at its end. One that it has left behind is
/// not.
std::optional<GrazingEnd> BranchFollower::grazing_at_failure(OrbitProblem& problem, double onwards, Branch& branch) {
  constexpr double slack = 1e-6;  // relative to 1 + |value|: a fold may lie just ahead of the grazing
  const BranchPoint& end = branch.points.back();
  std::optional<LocatedGrazing> located = grazing_beside(problem, problem.pack(end.nodes, end.duration, end.value));
  if (!located) return std::nullopt;
  const double ahead = problem.value(located->u) - end.value;
  if (std::abs(ahead) > slack * (1.0 + std::abs(end.value)) && ahead * onwards < 0.0) return std::nullopt;
  // A contact too weak for the free motion to reproduce is an impact that the branch has, not one that it misses.
  const bool lost = located->orbit.impacts < end.impacts;
  branch.special_points.push_back(grazing_point(system_, *located, end.impacts, end.impacts + (lost ? -1 : 1), branch));
  return GrazingEnd{std::move(*located), lost};
}

}  // namespace graze
