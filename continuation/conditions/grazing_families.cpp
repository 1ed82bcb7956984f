// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/grazing_families.hpp>

#include <graze/continuation/conditions/test_function.hpp>
#include <graze/continuation/problems/signature_problem.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

namespace graze {

namespace {

/// Steps beyond a grazing begin small: folds and period doublings may follow within a speed of 1e-3.
constexpr double first_step = 1e-5;

/// A grazing in the coordinates of the events of the orbits that begin there; the events `added` have speed zero.
struct SignatureStart {
  SignatureProblem problem;
  BranchStart start;
  std::vector<std::size_t> added;
};

SignatureStart start_with(OrbitProblem& problem, const PeriodicOrbit& orbit, const EventNodes& nodes, double value,
                          std::vector<std::size_t> added) {
  SignatureStart out{
      {problem.system(), orbit.parameters, problem.period(), nodes.sequence, problem.free(), problem.equations().options()},
      {},
      std::move(added)};
  BranchStart& start = out.start;
  start.u = out.problem.pack(nodes, value);
  out.problem.pin_as(problem, start.u);
  start.orientation = Vector::Zero(start.u.size());
  for (const std::size_t place : out.added) start.orientation += out.problem.speed_gradient(start.u, static_cast<int>(place));
  // The vector whose product with a tangent, in the norm of the arclength, is the change of the speed along it.
  start.orientation = start.orientation.cwiseQuotient(out.problem.zero_problem().weights).eval();
  start.sequence = nodes.sequence;
  start.step = first_step;
  start.on_grazing = true;
  return out;
}

/// Why the solutions right beyond the grazing are no motions; empty if they are motions.
std::optional<SignatureEquations::Violation> violation_beyond(SignatureStart& from, const TraceOptions& options) {
  const ZeroProblem zero = from.problem.zero_problem();
  const Vector tangent = tangent_at(zero, from.start.u, from.start.orientation);
  // The step must move an arc that crosses a barrier deeper than the accuracy of an impact (1e-11).
  Vector u = tangent.size() > 0 ? Vector(from.start.u + 1e-6 * tangent) : from.start.u;
  if (tangent.size() == 0 || !correct(zero, tangent, u, options).converged()) return SignatureEquations::Violation{};
  return from.problem.violation(u);
}

std::optional<BranchStart> partner_start(OrbitProblem& problem, const LocatedGrazing& grazing, bool lost,
                                         const TraceOptions& options) {
  if (grazing.top_dp == 0.0 || !std::isfinite(grazing.top_dp)) return std::nullopt;
  const ZeroProblem zero = problem.zero_problem();
  const double side = grazing.top_dp > 0.0 ? -1.0 : 1.0;  // side on which the free maximum stays below the barrier
  EventNodes nodes = event_nodes(grazing.orbit).value_or(EventNodes{});
  const Event& contact = problem.system()->events[grazing.event];
  // Several events coincide at the grazing, where the coordinates of the events are singular.
  const bool through_modes = !lost && (contact.to != contact.from || !grazing.contact_events.empty());
  const bool sticks = nodes.sequence.size() != grazing.orbit.events.size();
  if (!sticks && !through_modes && !problem.equations().autonomous() && (!lost || !nodes.sequence.empty())) {
    // The grazing orbit is the orbit without the impact, and also the one with the impact at speed zero; the speed grows from
    // there.
    nodes.shorten(grazing.orbit.period / problem.period());
    std::vector<std::size_t> added;
    if (!lost) added.push_back(nodes.insert(grazing.event, grazing.t, grazing.touch));
    const double value = problem.value(grazing.u);
    SignatureStart single = start_with(problem, grazing.orbit, nodes, value, added);
    if (lost) single.start.orientation = side * single.problem.parameter_direction();
    auto violation = lost ? std::nullopt : violation_beyond(single, options);
    while (violation && !violation->lost && violation->met && static_cast<int>(added.size()) < max_simultaneous_contacts) {
      const EventRecord& met = *violation->met;
      double t = std::fmod(met.t, problem.equations().duration(problem.orbit_part(grazing.u)));
      const std::size_t place = nodes.insert(met.event, t, met.x_minus);
      for (std::size_t& other : added) other += other >= place ? 1 : 0;
      added.push_back(place);
      SignatureStart several = start_with(problem, grazing.orbit, nodes, value, added);
      if (!correct(several.problem.zero_problem(), several.start.orientation, several.start.u, options).converged()) break;
      violation = violation_beyond(several, options);
      if (!violation) return several.start;
    }
    return single.start;
  }
  if (lost) {
    for (double distance = 1e-7; distance < 1e-3; distance *= 10.0) {
      BranchStart start{
          grazing.u + side * distance * problem.unit() * grazing.family_dp, side * grazing.family_dp, {}, {}, false, first_step};
      if (correct(zero, problem.parameter_direction(), start.u, options).converged()) return start;
    }
    return std::nullopt;
  }
  const auto with_impact = [&](const Vector& guess) -> std::optional<BranchStart> {
    BranchStart start{guess, {}, {}, {}, false, first_step};
    if (!guess.allFinite() || !correct(zero, problem.parameter_direction(), start.u, options).converged()) return std::nullopt;
    start.orientation = start.u - grazing.u;
    const PeriodicOrbit orbit = problem.orbit(start.u);
    if (orbit.impacts != grazing.orbit.impacts + 1) return std::nullopt;
    if (grazing.leads_away && first_break(problem.system(), orbit.signature.events)) return std::nullopt;
    return start;
  };
  // First order in the impact's speed (LocatedGrazing::response). A free motion amplifies errors by one over that speed; an
  // autonomous orbit is followed by nothing else.
  const bool responds = !grazing.leads_away && grazing.impulse.size() > 0 && grazing.response != 0.0;
  const bool free = problem.equations().autonomous();
  if (responds && grazing.scenario != GrazingScenario::smooth)
    for (const double speed : free ? std::array{3e-3, 1e-2, 1e-3, 3e-2, 3e-4} : std::array{1e-3, 3e-3, 3e-4, 1e-2, 3e-2}) {
      const double change = grazing.response * speed / grazing.top_dp;
      if (auto start = with_impact(grazing.u + change * grazing.family_dp + speed * grazing.impulse)) return start;
    }
  // Contacts without an impulse to first order (a spring with a damper, an impact after which friction holds the mass), and
  // those in which friction holds it: the branch has at most a corner, and Newton's method finds the orbits on either side of it.
  for (double distance = 1e-7; distance < 1e-3; distance *= 10.0)
    for (const double way : {-side, side})
      if (auto start = with_impact(grazing.u + way * distance * problem.unit() * grazing.family_dp)) return start;
  return std::nullopt;
}

std::optional<BranchStart> symmetric_start(OrbitProblem& problem, const LocatedGrazing& grazing, const TraceOptions& options) {
  const HybridSystem& system = problem.system();
  const Event& contact = system.events[grazing.event];
  EventNodes nodes = event_nodes(grazing.orbit).value_or(EventNodes{});
  if (grazing.leads_away || contact.to != contact.from || !grazing.contact_events.empty() || problem.equations().autonomous() ||
      nodes.sequence.size() != grazing.orbit.events.size())
    return std::nullopt;
  const Vector& p = grazing.orbit.parameters;
  const double T = forcing_period(system, p), duration = T * problem.period();
  nodes.shorten(grazing.orbit.period / problem.period());
  std::vector<std::size_t> added{nodes.insert(grazing.event, grazing.t, grazing.touch)};
  for (const Symmetry& symmetry : symmetries(system, p)) {
    const Vector image = symmetry.matrix * grazing.touch;
    for (int k = 0; k < problem.period(); ++k) {
      const double t = std::fmod(grazing.t + (symmetry.shift + k) * T, duration);
      constexpr double same = 1e-5;  // a grazing impact of a speed within rounding may move the motion
      const Trajectory motion = simulate(system, p, 0.0, grazing.orbit.state, {.t_end = t});
      if (!((motion.x - image).lpNorm<Eigen::Infinity>() < same * (1.0 + image.lpNorm<Eigen::Infinity>()))) continue;
      for (std::size_t e = 0; e < system.events.size(); ++e) {
        const Event& other = system.events[e];
        if (other.kind != contact.kind || other.from != motion.mode || e == grazing.event) continue;
        if (!(std::abs(other.guard.value(t, image, p)) < same)) continue;
        const std::size_t place = nodes.insert(e, t, image);
        for (std::size_t& one : added) one += one >= place ? 1 : 0;
        added.push_back(place);
      }
      break;
    }
  }
  if (added.size() < 2 || added.size() > max_simultaneous_contacts) return std::nullopt;
  SignatureStart several = start_with(problem, grazing.orbit, nodes, problem.value(grazing.u), added);
  if (!correct(several.problem.zero_problem(), several.start.orientation, several.start.u, options).converged())
    return std::nullopt;
  if (violation_beyond(several, options)) return std::nullopt;
  return several.start;
}

std::optional<BranchStart> multiple_start(OrbitProblem& problem, const LocatedGrazing& grazing, TurnPattern pattern,
                                          const TraceOptions& options) {
  EventNodes nodes = event_nodes(grazing.orbit).value_or(EventNodes{});
  const Event& contact = problem.system()->events[grazing.event];
  const bool sticks = nodes.sequence.size() != grazing.orbit.events.size();
  if (sticks || contact.to != contact.from || problem.equations().autonomous()) return std::nullopt;
  const double turn = grazing.orbit.duration / grazing.orbit.period * problem.period() / pattern.turns;
  nodes.shorten(grazing.orbit.period * pattern.turns / problem.period());
  nodes.repeat(pattern.turns, turn);
  std::vector<std::size_t> added;
  for (int k = 0; k < pattern.struck; ++k)
    added.push_back(nodes.insert(grazing.event, std::fmod(grazing.t, turn) + k * turn, grazing.touch));
  SignatureStart start = start_with(problem, grazing.orbit, nodes, problem.value(grazing.u), std::move(added));
  if (violation_beyond(start, options)) return std::nullopt;
  return start.start;
}

}  // namespace

std::optional<GrazingBirth> birth_at_grazing(const GrazingFamily& family, const SpecialPoint& point, const GrazingEnd& end) {
  using Kind = GrazingFamily::Kind;
  if (family.kind == Kind::symmetric && end.lost) return std::nullopt;
  GrazingBirth birth;
  LocatedGrazing grazing = end.grazing;  // in the least period of the family's touching orbit
  if (family.kind == Kind::multiple) {
    birth.edge = pattern_edge(touching_edge(point, grazing, end.lost, &birth.orbit), family.pattern);
    birth.turns = family.pattern.turns;
    birth.start = [grazing, pattern = family.pattern](OrbitProblem& problem, const TraceOptions& options) {
      return multiple_start(problem, grazing, pattern, options);
    };
    return birth;
  }
  birth.edge = partner_edge(point, grazing, end.lost, &birth.orbit);
  birth.identified = family.kind == Kind::partner;
  if (family.kind == Kind::partner) {
    birth.missing = "no orbit was found beyond the grazing";
    birth.start = [grazing, lost = end.lost](OrbitProblem& problem, const TraceOptions& options) {
      return partner_start(problem, grazing, lost, options);
    };
  } else {
    birth.start = [grazing](OrbitProblem& problem, const TraceOptions& options) {
      return symmetric_start(problem, grazing, options);
    };
  }
  return birth;
}

void confirm_scenario(SpecialPoint& grazing, const Branch& ended, const Branch& beyond, bool begins) {
  if (is_smooth(grazing)) return;
  const auto beyond_one = [](const BranchPoint& point) {
    const std::vector<std::complex<double>> all = nontrivial(point.multipliers);
    return std::count_if(all.begin(), all.end(), [](std::complex<double> mu) { return mu.imag() == 0.0 && mu.real() > 1.0; });
  };
  // The nearest orbit that lies clearly on one side of the grazing.
  const auto nearest = [&](auto first, auto last) -> const BranchPoint* {
    const auto is_distinct = [&](const BranchPoint& point) {
      return std::abs(point.value - grazing.value) > 4.0 * grazing.precision;
    };
    const auto found = std::find_if(first, last, is_distinct);
    return found == last ? nullptr : &*found;
  };
  const BranchPoint* before = nearest(ended.points.rbegin(), ended.points.rend());
  const BranchPoint* after =
      begins ? nearest(beyond.points.begin(), beyond.points.end()) : nearest(beyond.points.rbegin(), beyond.points.rend());
  if (!before || !after) {
    grazing.details.insert_or_assign("scenario_from", std::string("linear response"));
    return;
  }
  const auto name = [](bool persistence) {
    return std::string(grazing_scenario_name(persistence ? GrazingScenario::persistence : GrazingScenario::nonsmooth_fold));
  };
  const std::string sides = name((before->value < grazing.value) != (after->value < grazing.value));
  const std::string parity = name((beyond_one(*before) + beyond_one(*after)) % 2 == 0);
  const std::string response = std::get<std::string>(grazing.details.at("scenario"));
  auto& impacts = std::get<std::vector<double>>(grazing.details.at("impacts"));
  const bool gained = std::get<std::string>(grazing.details.at("kind")) == "gained";
  const bool several = gained ? after->impacts != impacts.back() : impacts.front() - impacts.back() > 1.0;
  std::string from = "directions, multipliers and linear response";
  if (several) {  // the linear response describes a single impact
    if (gained) impacts.back() = after->impacts;
    grazing.details.insert_or_assign("scenario", sides);
    from = "directions; several contacts touch together";
  } else if (response != name(true) && response != name(false)) {
    grazing.details.insert_or_assign("scenario", sides);
    from = sides == parity ? "directions and multipliers" : "directions";
  } else if (response != sides) {
    from = "linear response; the orbits kept lie as at a " + sides;
  } else if (parity != sides) {
    from = "directions and linear response; the multipliers kept are those of a " + parity;
  }
  grazing.details.insert_or_assign("scenario_from", std::move(from));
}

}  // namespace graze
