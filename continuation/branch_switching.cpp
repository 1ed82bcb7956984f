// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch_switching.hpp>

#include <graze/continuation/multiplier_condition.hpp>
#include <graze/continuation/signature_problem.hpp>

#include <cmath>
#include <numbers>

namespace graze {

namespace {

/// From a grazing on steps begin small: folds and period doublings may follow within a speed of a thousandth.
constexpr double first_step = 1e-5;

}  // namespace

std::optional<BranchStart> doubled_start(const SpecialPoint& pd, OrbitProblem& parent, OrbitProblem& doubled,
                                         const TraceOptions& options) {
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
  direction /= weighted_norm(zero.weights, direction);
  // Small, and small steps after it: in a cascade the next bifurcation may follow closely. The parameter follows with the square
  // of the push, and fast beside a grazing: down to where rounding begins.
  for (const double push : {2e-4, 5e-5, 1e-5, 2e-6, 2e-7, 2e-8, 1e-3}) {
    BranchStart start{at_birth + push * direction, {}, {}, false, push};
    if (!correct(zero, direction, start.u, options).converged()) continue;
    start.orientation = start.u - at_birth;
    if (weighted_norm(zero.weights, start.orientation) < 1.5 * push)
      return start;  // a correction as long as the push has found something else
  }
  return std::nullopt;
}

std::optional<BranchStart> partner_start(OrbitProblem& problem, const LocatedGrazing& grazing, bool lost,
                                         const TraceOptions& options) {
  if (grazing.top_dp == 0.0 || !std::isfinite(grazing.top_dp)) return std::nullopt;
  const ZeroProblem zero = problem.zero_problem();
  const double side = grazing.top_dp > 0.0 ? -1.0 : 1.0;  // on which the free maximum stays short of the barrier
  EventNodes nodes = event_nodes(grazing.orbit).value_or(EventNodes{});
  const bool sticks = nodes.sequence.size() != grazing.orbit.events.size();
  if (!sticks && !problem.equations().autonomous() && (!lost || !nodes.sequence.empty())) {
    // The grazing itself is the orbit without that impact, and the one with it at speed zero; the speed grows from there.
    nodes.shorten(grazing.orbit.duration * problem.period() / grazing.orbit.period);
    const std::size_t place = lost ? 0 : nodes.insert(grazing.event, grazing.t, grazing.touch);
    SignatureProblem signature(problem.system(), grazing.orbit.parameters, problem.period(), nodes.sequence, problem.parameter(),
                               problem.scale(), problem.equations().options());
    BranchStart start;
    start.u = signature.pack(nodes, problem.value(grazing.u));
    start.orientation =
        lost ? Vector(side * signature.parameter_direction()) : signature.speed_gradient(start.u, static_cast<int>(place));
    start.sequence = nodes.sequence;
    start.step = first_step;
    start.on_grazing = true;
    return start;
  }
  if (lost) {
    for (double distance = 1e-7; distance < 1e-3; distance *= 10.0) {
      BranchStart start{grazing.u + side * distance * grazing.family_dp, side * grazing.family_dp, {}, false, first_step};
      if (correct(zero, problem.parameter_direction(), start.u, options).converged()) return start;
    }
    return std::nullopt;
  }
  // An orbit that sticks elsewhere: first order in the impact's speed (LocatedGrazing::response).
  for (const double speed : {1e-3, 3e-3, 3e-4, 1e-2, 3e-2}) {
    const double change = grazing.response * speed / grazing.top_dp;
    BranchStart start{grazing.u + change * grazing.family_dp + speed * grazing.impulse, {}, {}, false, first_step};
    if (!correct(zero, problem.parameter_direction(), start.u, options).converged()) continue;
    start.orientation = start.u - grazing.u;
    if (problem.orbit(start.u, {}).impacts == grazing.orbit.impacts + 1) return start;
  }
  return std::nullopt;
}

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
    pd.details.insert_or_assign("criticality", seen);
    pd.details.insert_or_assign("criticality_from", std::string("branch"));
    return;
  }
  const bool agrees = std::get<std::string>(predicted->second) == seen;
  const char* from = agrees ? "normal form, confirmed by the branch" : "normal form; the branch starts on the other side";
  pd.details.insert_or_assign("criticality_from", std::string(from));
}

}  // namespace graze
