// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch/branch_end.hpp>
#include <graze/continuation/branch/follow_branch.hpp>
#include <graze/continuation/branch/signature_follower.hpp>
#include <graze/continuation/branch/states_follower.hpp>
#include <graze/continuation/conditions/grazing_by_events.hpp>
#include <graze/continuation/conditions/grazing_in_step.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

/// How a branch was followed to its end.
struct Followed {
  Curve curve;                                                ///< the last one
  std::optional<SignatureEquations::Violation> refused = {};  ///< see SignatureFollower
  std::optional<GrazingEnd> grazing = {};
  bool on_grazing = false;             ///< the start is a grazing
  std::optional<Vector> fastest = {};  ///< see SignatureFollower::fastest_point
};

/// The start in the coordinates of its signature; nullopt if it sticks or has no events.
std::optional<BranchStart> to_signature(OrbitProblem& problem, const BranchStart& start) {
  const std::optional<EventNodes> here = event_nodes(problem.orbit(start.u));
  if (!here) return std::nullopt;
  BranchStart out;
  out.sequence = here->sequence;
  out.step = start.step;
  const SignatureProblem moved(problem.system(), problem.equations().parameters(), problem.period(), here->sequence,
                               problem.free(), problem.equations().options());
  out.u = moved.pack(*here, problem.value(start.u));
  out.orientation = problem.value(start.orientation) * moved.parameter_direction();
  // If only the parameter gives the direction, differences are useless: the displaced states are no orbits.
  if (problem.orbit_part(start.orientation).isZero(0.0)) return out;
  // The direction by finite differences. The difference is small against the square of the speed of a weak impact, because the
  // impact exists within that distance of the barrier.
  const double small = 1e-8 / std::max(1e-300, problem.largest_change(start.orientation));
  const Vector u_before = start.u - small * start.orientation;
  const std::optional<EventNodes> before = event_nodes(problem.orbit(u_before));
  if (before && before->sequence == here->sequence) {
    const Vector direction = (out.u - moved.pack(*before, problem.value(u_before))) / small;
    if (direction.allFinite() && moved.largest_change(direction) < 1e6) out.orientation = direction;
  }
  return out;
}

/// The start for continuing the branch in states where the coordinates of the events end: where an impact with zero restitution
/// turns into sticking, or where events of a contact that leads through other modes coincide. `problem` is moved to the section
/// of the branch's last point.
std::optional<BranchStart> continuation_in_states(OrbitProblem& problem, const SignatureProblem& signature,
                                                  const Followed& followed, const Branch& branch) {
  const Curve& curve = followed.curve;
  const auto& refused = followed.refused;
  const HybridSystem& system = problem.system();
  if (curve.stop != TraceStop::min_step || followed.grazing || branch.points.empty() || curve.points.empty()) return std::nullopt;
  const bool sticks = refused && refused->met && !begins_contact(system.events[refused->met->event].kind);
  if (!signature.through_modes() && !sticks && !is_plastic(system, signature.equations().parameters())) return std::nullopt;
  const BranchPoint& end = branch.points.back();
  OrbitProblem there = problem.with_section(end.section_phase);
  if (there.nodes() != static_cast<int>(end.nodes.size())) return std::nullopt;
  BranchStart from;
  from.u = there.pack(end.nodes, end.duration, end.value);
  const Vector& tangent = curve.points.back().tangent;
  const double way = tangent.size() > 0 ? std::copysign(1.0, signature.value(tangent)) : 1.0;
  from.orientation = way * there.parameter_direction();
  problem = std::move(there);
  problem.measure_by(from.u);
  problem.pin_as(signature, from.u);
  return from;
}

/// The grazing at which the branch broke off; `onwards`: direction of the parameter at its end. One that it has left behind is
/// not.
std::optional<GrazingEnd> grazing_at_failure(OrbitProblem& problem, double onwards, Branch& branch) {
  constexpr double slack = 1e-6;  // relative to the value's size: a fold may lie just ahead of the grazing
  const BranchPoint& end = branch.points.back();
  std::optional<LocatedGrazing> located = grazing_beside(problem, problem.pack(end.nodes, end.duration, end.value));
  if (!located) return std::nullopt;
  const double ahead = problem.value(located->u) - end.value;
  if (std::abs(ahead) > slack * problem.size_of_value(end.value) && ahead * onwards < 0.0) return std::nullopt;
  // A contact too weak for the free motion to reproduce is an impact that the branch has, not one that it misses.
  const bool lost = located->orbit.impacts < end.impacts;
  branch.special_points.push_back(grazing_point(problem.system(), *located, end.impacts, end.impacts + (lost ? -1 : 1), branch));
  return GrazingEnd{std::move(*located), lost};
}

/// Completes the branch with the reason of its end. Returns the grazing on which it ended.
std::optional<GrazingEnd> finish(BranchProblem& problem, Followed followed, BranchRecord& record) {
  const HybridSystem& system = problem.system();
  const Curve& curve = followed.curve;
  const auto& refused = followed.refused;
  std::optional<GrazingEnd>& grazing = followed.grazing;
  Branch& branch = record.branch();
  TraceStop why = curve.stop;
  branch.time_carried = problem.time_carried();
  // Orbits between two grazings are kept if the second grazing could not be resolved.
  if (branch.points.empty() && followed.on_grazing && why == TraceStop::min_step && followed.fastest)
    record.begin(problem, *followed.fastest);
  const bool nothing_beyond = branch.points.empty() && followed.on_grazing && !curve.points.empty();
  if (branch.points.empty() && !curve.points.empty() && !followed.on_grazing) record.begin(problem, curve.points.front().u);
  if (branch.points.empty()) {
    branch.stop = record.interrupted() ? BranchStop::interrupted : BranchStop::start_failed;
    branch.stop_value = branch.parameters[static_cast<Eigen::Index>(problem.parameter())];
    if (record.interrupted()) {
      branch.message = "it was interrupted";
    } else if (!nothing_beyond) {
      branch.message = "the first point did not converge: " + curve.failure;
    } else if (refused && !refused->lost) {
      branch.message = "the orbit with one impact more meets a barrier elsewhere at once";
    } else {
      branch.message = "no admissible orbit was found beyond the grazing: " + curve.failure;
    }
    return std::nullopt;
  }
  if (why == TraceStop::min_step && record.end_on_bound(problem)) why = TraceStop::monitor;
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
    const double onwards = curve.points.empty() ? 0.0 : problem.value(curve.points.back().tangent);
    grazing = grazing_at_failure(*states, onwards, branch);
  }
  if (grazing) {
    const SpecialPoint& point = branch.special_points.back();
    branch.stop_value = point.value;
    if (branch.points.size() == 1) branch.direction = point.value < end.value ? -1 : 1;
    stop(BranchStop::grazing, fmt::format("grazing at {} = {:.12g}: an impact is {} ({})", branch.parameter, point.value,
                                          grazing->lost ? "lost" : "gained", grazing_scenario_name(grazing->grazing.scenario)));
    return std::move(grazing);
  }
  if (record.interrupted()) {
    stop(BranchStop::interrupted, "it was interrupted");
  } else if (const std::optional<BranchEnding>& ending = record.ending()) {
    branch.stop_value = ending->value;
    stop(ending->reason, ending->message);
  } else if (why == TraceStop::monitor) {
    stop(BranchStop::reached_bound, fmt::format("the end of the range, {} = {:.12g}, was reached", branch.parameter, end.value));
  } else if (why == TraceStop::closed) {
    stop(BranchStop::returned,
         fmt::format("the branch is closed: at {} = {:.12g} it is back where it was before", branch.parameter, end.value));
  } else if (why == TraceStop::point_limit) {
    stop(BranchStop::point_limit, fmt::format("{} points were computed, the limit", branch.points.size()));
  } else {
    const bool meets_release = refused && refused->met && system.events[refused->met->event].kind == EventKind::release;
    // A little farther, where the release is surely resolved.
    const double ahead = curve.first_failed ? problem.value(*curve.first_failed) - end.value : 0.0;
    const double beyond = std::max(std::abs(ahead), 1e-6 * problem.size_of_value(end.value));
    const bool lifts_off = ahead != 0.0 && releases_beyond(system, branch, end.value + std::copysign(beyond, ahead));
    const std::string reason = released || meets_release || lifts_off
                                   ? "a mass that is held along all orbits before is released there"
                               : refused ? "several contacts graze there so close together that they cannot be told apart"
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
  record.mark(problem, record.last(), branch.stop == BranchStop::step_too_small ? PointType::MX : PointType::EP);
  return std::nullopt;
}

}  // namespace

std::optional<GrazingEnd> follow_branch(const FollowSettings& settings, OrbitProblem& problem, const BranchStart& start,
                                        Branch& branch) {
  BranchRecord record(settings, branch);
  std::optional<BranchStart> by_events;
  if (start.sequence) {
    by_events = start;
  } else if (settings.hard_contacts && !problem.equations().autonomous()) {
    by_events = to_signature(problem, start);
  }
  std::optional<SignatureEquations::Violation> refused;
  if (by_events) {
    SignatureProblem signature(settings.system, branch.parameters, problem.period(), *by_events->sequence, problem.free(),
                               problem.equations().options());
    signature.measure_by(by_events->u);
    signature.pin(signature.kept_states(by_events->u));
    SignatureFollower follower(settings, signature, record);
    Followed followed{follower.follow(*by_events), follower.refused(), follower.grazing(), start.on_grazing,
                      follower.fastest_point()};
    if (const auto states = continuation_in_states(problem, signature, followed, branch)) {
      record.set_last(states->u);
      Curve curve = StatesFollower(settings, problem, record).follow(*states);
      return finish(problem, {std::move(curve), followed.refused}, record);
    }
    if (!branch.points.empty() || start.sequence) return finish(signature, std::move(followed), record);
    refused = followed.refused;
  }
  problem.measure_by(start.u);
  problem.pin(problem.kept_states(start.u));
  Curve curve = StatesFollower(settings, problem, record).follow(start);
  return finish(problem, {std::move(curve), refused}, record);
}

}  // namespace graze
