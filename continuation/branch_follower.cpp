// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch_follower.hpp>
#include <graze/continuation/branch_step.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

/// Multipliers that cannot be told from those of the bifurcation all along a step pass it in rounding alone: where a doubled branch
/// begins, and along orbits of a conservative resonance, which all have the same. Two that coincide are known to the root of
/// rounding only.
bool in_rounding(const TestFunction& test, const TestPoint& a, const TestPoint& b) {
  constexpr double rounding = 1e-8, root = 1e-5;
  const double farthest = std::max(test.distance(a.branch), test.distance(b.branch));
  const auto coincide = [](const BranchPoint& point) {
    const auto values = nontrivial(point.multipliers);
    return values.size() > 1 && std::abs(values[0] - values[1]) < 4.0 * root;
  };
  return farthest < (coincide(a.branch) && coincide(b.branch) ? root : rounding);
}

/// A point of a branch as every orbit that is the same one: a branch that comes back to any of them is closed.
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

}  // namespace

BranchFollower::BranchFollower(const HybridSystem& system, const ContinuationOptions& options, double low, double high)
    : system_(system), options_(options), low_(low), high_(high), hard_contacts_(has_hard_contacts(system)) {}

bool BranchFollower::interrupted_now() {
  interrupted_ = interrupted_ || (options_.cancelled && options_.cancelled());
  return interrupted_;
}

/// The end of the range: the step's end is moved onto it. Empty: not there yet. A step that begins on the end of the range and
/// ends outside has passed a fold, and is to be made shorter.
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
  const Vector u = at_value(problem, before.u + (bound - last) / (value - last) * (after.u - before.u), bound);
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
  mark(problem, u, PointType::EP, branch);
}

/// Locates what lies between the last point and the next, and takes the next one up; false where the step is to be halved. `met`:
/// what is known already to lie there.
bool BranchFollower::take(BranchProblem& problem, const CurvePoint& before, const CurvePoint& after, BranchPoint point,
                          std::vector<MetPoint> met, Branch& branch) {
  // What is not found where it was announced may be no such point, but a step onto another branch close by.
  constexpr double smallest_doubt = 1e-5, smallest_step = 1e-8;
  const bool long_step = !corner_ && after.arclength - before.arclength > smallest_doubt;
  const auto doubtful = [&](const MetPoint& special) { return special.point.status != PointStatus::converged && long_step; };
  if (std::any_of(met.begin(), met.end(), doubtful)) return false;
  const TestPoint a{before, branch.points.back()}, b{after, point};
  for (const TestFunction& test : test_functions()) {
    const double f_a = test.value(a), f_b = test.value(b);
    if (!std::isfinite(f_a) || !std::isfinite(f_b) || (f_a < 0.0) == (f_b < 0.0) || !test.confirm(a, b)) continue;
    if (in_rounding(test, a, b)) continue;
    std::optional<MetPoint> special = locate(problem, test, a, b, branch);
    if (!special) {
      if (long_step) return false;
      continue;
    }
    // A fold beyond the end of the range: the branch leaves the range and comes back within the step.
    const bool outside = special->point.value < low_ || special->point.value > high_;
    if (outside && test.type == PointType::LP && long_step) return false;
    met.push_back(std::move(*special));
    if (corner_) {  // at its tip, which lies within the smallest step of the grazing, on the side of the contact
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
  user_points(problem, before, after, branch, met);
  std::stable_sort(met.begin(), met.end(), [](const MetPoint& x, const MetPoint& y) { return x.place < y.place; });
  for (MetPoint& special : met) branch.special_points.push_back(std::move(special.point));
  branch.points.push_back(std::move(point));
  last_ = after.u;
  if (options_.progress) options_.progress(branch);
  return true;
}

/// The branch ends just before the orbit of half its period: what lies on the way there is located.
Verdict BranchFollower::end_at_half(BranchProblem& problem, const CurvePoint& before, double part, CurvePoint& after,
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
  returned_ = true;
  return Verdict::stop;
}

Verdict BranchFollower::monitor_states(OrbitProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch) {
  if (interrupted_now()) return Verdict::stop;
  const std::optional<Verdict> end = end_of_range(problem, before, after);
  if (end == Verdict::reject) return Verdict::reject;
  BranchPoint point = problem.branch_point(after.u, branch.points.back().arclength + after.arclength - before.arclength);
  if (!point.multipliers.valid || leaves_branch(system_, branch, point)) return Verdict::reject;
  // Where a chatter becomes incomplete infinitely many impacts come apart, each with a grazing of its own.
  const bool sticks = point.isolated_impacts < point.impacts;
  if (hard_contacts_ && sticks != (branch.points.back().isolated_impacts < branch.points.back().impacts)) {
    chatter_ends_ = after.arclength - before.arclength <= 1e-7;
    return chatter_ends_ ? Verdict::stop : Verdict::reject;
  }
  // One grazing at a time: a step across several is halved, down to where they cannot be told apart. Contacts that touch together
  // (an orbit symmetric between two barriers) are one.
  const int change = std::abs(point.isolated_impacts - branch.points.back().isolated_impacts);
  // Orbits on both sides of a hard grazing are different families, even where the corrector finds its way across: never step over
  // one.
  if (change == 1 && hard_contacts_) return Verdict::reject;
  const bool close = after.arclength - before.arclength <= 1e-7;
  if (change > 1 && hard_contacts_ && !close) return Verdict::reject;
  if (const auto part = goes_through_half(problem, before.u, after.u)) return end_at_half(problem, before, *part, after, branch);
  std::vector<MetPoint> met;
  if (change == 1 || (change > 1 && !hard_contacts_)) met.push_back(locate_impact_change(problem, before, after, point, branch));
  if (change > 1 && !close && met.back().point.status != PointStatus::converged) return Verdict::reject;
  if (!take(problem, before, after, std::move(point), std::move(met), branch)) return Verdict::reject;
  if (end) return Verdict::stop;
  section_blocked_ = better_section(problem, after.u) != problem.equations().section_phase();
  return section_blocked_ ? Verdict::stop : Verdict::go_on;
}

/// A branch that starts on its grazing begins with the first orbit beyond it whose impacts are fast enough. One that ends before
/// there is such an orbit is kept with the one whose weakest impact is fastest: between two grazings close together, or at the
/// end of the range.
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
    if (speed < weakest_kept) return Verdict::go_on;
    const std::optional<CurvePoint> nearer = beside_grazing(problem, beginning_, after);
    begin(problem, nearer ? nearer->u : after.u, branch);
    if (!nearer) return Verdict::go_on;
    BranchPoint point = problem.branch_point(after.u, after.arclength - nearer->arclength);
    if (point.multipliers.valid && take(problem, *nearer, after, std::move(point), {}, branch)) return Verdict::go_on;
    branch.points.clear();
    branch.special_points.clear();
    return Verdict::reject;
  }
  if (fastest_ < weakest_told) return outside ? Verdict::stop : Verdict::reject;
  begin(problem, fastest_point_, branch);
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
  if (!point.multipliers.valid || leaves_branch(system_, branch, point)) return Verdict::reject;
  if (const auto part = goes_through_half(problem, before.u, after.u)) return end_at_half(problem, before, *part, after, branch);
  if (!take(problem, before, after, std::move(point), {}, branch)) return Verdict::reject;
  return end.value_or(Verdict::go_on);
}

/// Where the model allows no value beyond the end of the range, no step leads across it: the last one is made onto it.
bool BranchFollower::end_on_bound(BranchProblem& problem, Branch& branch) {
  const BranchPoint& end = branch.points.back();
  for (const double bound : {low_, high_}) {
    if (end.value == bound || std::abs(end.value - bound) > 1e-6 * (1.0 + std::abs(bound))) continue;
    const Vector u = at_value(problem, last_, bound);
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
  // Moves start and direction to a section clear of impacts, if need be.
  const auto clear_section = [&] {
    const double section = better_section(problem, start);
    if (section == problem.equations().section_phase()) return;
    OrbitProblem moved = problem.with_section(section);
    // Small against the square of the speed of a weak impact, which lives within that distance of the barrier.
    const double small = 1e-8 / std::max(1e-300, direction.lpNorm<Eigen::Infinity>());
    const auto here = problem.to_section(moved, start), before = problem.to_section(moved, start - small * direction);
    if (!here) return;
    direction =
        before ? Vector((*here - *before) / small) : Vector(direction[direction.size() - 1] * moved.parameter_direction());
    start = *here;
    problem = std::move(moved);
  };
  clear_section();
  Curve curve;
  // Where the branch began: a closed one comes back there, perhaps with its nodes on another section.
  std::optional<CurvePoint> first, origin;
  double first_section = 0.0;
  const OriginsOf origins_of = [&](const CurvePoint& start_point) { return images_of(problem, origin.value_or(start_point)); };
  TraceOptions trace_options = options_.trace;
  for (;;) {
    section_blocked_ = false;
    const ZeroProblem zero = problem.zero_problem();
    // The first point of a curve that goes on is the last one that the branch has.
    const int kept = std::max(1, static_cast<int>(branch.points.size()));
    trace_options.max_points = std::max(1, options_.trace.max_points - kept + 1);
    const auto on_branch = [&](const CurvePoint& before, CurvePoint& after) {
      if (branch.points.empty()) {
        begin(problem, before.u, branch);
        first = before;
        first_section = problem.equations().section_phase();
      }
      return monitor_states(problem, before, after, branch);
    };
    curve = trace(zero, start, direction, trace_options, on_branch, origins_of);
    const Vector plain = std::copysign(1.0, direction[direction.size() - 1]) * problem.parameter_direction();
    if (curve.stop == TraceStop::start_failed && branch.points.empty() && direction != plain) {
      direction = plain;
      continue;
    }
    if (curve.stop == TraceStop::min_step && !hard_contacts_ && !branch.points.empty()) {
      CurvePoint last = curve.points.back();
      trace_options.initial_step = 1e-6;
      if (around_corner(problem, branch, last)) {
        start = last.u;
        direction = last.tangent;
        continue;
      }
      // States in a stiff contact are as steep as those at a hard one.
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

/// The start in the coordinates of its signature; nullopt where it has none without sticking.
std::optional<BranchStart> BranchFollower::to_signature(OrbitProblem& problem, const BranchStart& start) const {
  const std::optional<EventNodes> here = event_nodes(problem.orbit(start.u, {}));
  if (!here) return std::nullopt;
  BranchStart out;
  out.sequence = here->sequence;
  out.step = start.step;
  const SignatureProblem moved(system_, problem.equations().parameters(), problem.period(), here->sequence, problem.parameter(),
                               problem.scale(), problem.equations().options());
  out.u = moved.pack(*here, problem.value(start.u));
  out.orientation = start.orientation[start.orientation.size() - 1] * moved.parameter_direction();
  // The parameter alone says which way: the differences of motions that are no orbits say nothing.
  if (start.orientation.head(start.orientation.size() - 1).isZero(0.0)) return out;
  // The direction by differences: small against the square of the speed of a weak impact, which lives within that distance of the
  // barrier.
  const double small = 1e-8 / std::max(1e-300, start.orientation.lpNorm<Eigen::Infinity>());
  const Vector u_before = start.u - small * start.orientation;
  const std::optional<EventNodes> before = event_nodes(problem.orbit(u_before, {}));
  if (before && before->sequence == here->sequence) {
    const Vector direction = (out.u - moved.pack(*before, problem.value(u_before))) / small;
    if (direction.allFinite() && direction.lpNorm<Eigen::Infinity>() < 1e6) out.orientation = direction;
  }
  return out;
}

Curve BranchFollower::follow_signature(SignatureProblem& problem, const BranchStart& start, Branch& branch) {
  if (start.on_grazing) beginning_ = start.u;
  return trace(problem.zero_problem(), start.u, start.orientation, options_.trace,
               [&](const CurvePoint& before, CurvePoint& after) {
                 if (branch.points.empty() && !start.on_grazing) begin(problem, before.u, branch);
                 return monitor_signature(problem, before, after, branch);
               },
               [&](const CurvePoint& first) { return images_of(problem, first); });
}

std::optional<GrazingEnd> BranchFollower::follow(OrbitProblem& problem, const BranchStart& start, Branch& branch) {
  interrupted_ = returned_ = chatter_ends_ = clear_of_soft_ = false;
  fastest_ = 0.0;
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
    const Curve curve = follow_signature(signature, *by_events, branch);
    if (!branch.points.empty() || start.sequence) return finish(signature, curve, branch, start.on_grazing);
  }
  problem.measure_by(start.u);
  const Curve curve = follow_states(problem, start, branch);
  return finish(problem, curve, branch, false);
}

std::optional<GrazingEnd> BranchFollower::finish(BranchProblem& problem, const Curve& curve, Branch& branch, bool on_grazing) {
  TraceStop why = curve.stop;
  branch.time_carried = problem.time_carried();
  // Orbits that were met between two grazings, the second of which could not be told, are kept.
  if (branch.points.empty() && on_grazing && why == TraceStop::min_step && fastest_ >= weakest_told)
    begin(problem, fastest_point_, branch);
  const bool nothing_beyond = branch.points.empty() && on_grazing && !curve.points.empty();
  if (branch.points.empty() && !curve.points.empty() && !on_grazing) begin(problem, curve.points.front().u, branch);
  if (branch.points.empty()) {
    branch.stop = interrupted_ ? BranchStop::interrupted : BranchStop::start_failed;
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
  if (why == TraceStop::min_step && states) grazing_ = broken_off_at_grazing(*states, branch);
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
  } else if (returned_) {
    stop(BranchStop::returned,
         fmt::format("the doubled orbit has returned to its parent near {} = {:.12g}", branch.parameter, end.value));
  } else if (chatter_ends_) {
    const bool sticks = end.isolated_impacts < end.impacts;
    stop(BranchStop::chatter, fmt::format("at {} = {:.12g} the chatter {} complete, and the mass {}", branch.parameter, end.value,
                                          sticks ? "is no longer" : "becomes", sticks ? "does not stick beyond" : "sticks beyond"));
  } else if (why == TraceStop::monitor) {
    stop(BranchStop::reached_bound, fmt::format("the end of the range, {} = {:.12g}, was reached", branch.parameter, end.value));
  } else if (why == TraceStop::closed) {
    stop(BranchStop::returned,
         fmt::format("the branch is closed: at {} = {:.12g} it is back where it was before", branch.parameter, end.value));
  } else if (why == TraceStop::point_limit) {
    stop(BranchStop::point_limit, fmt::format("{} points were computed, the limit", branch.points.size()));
  } else {
    const std::string reason =
        refused_ ? "several contacts graze there so close together that they cannot be told apart" : curve.failure;
    stop(BranchStop::step_too_small, fmt::format("no point is found beyond {} = {:.12g} even with the smallest step ({})",
                                                 branch.parameter, problem.value(curve.points.back().u), reason));
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

}  // namespace graze
