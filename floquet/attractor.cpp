// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/approach.hpp>
#include <graze/floquet/rounds.hpp>
#include <graze/floquet/side_by_side.hpp>

namespace graze {

std::string_view attractor_type_name(AttractorType type) {
  switch (type) {
  case AttractorType::undecided:
    break;
  case AttractorType::periodic:
    return "periodic";
  case AttractorType::chaotic:
    return "chaotic";
  }
  return "undecided";
}

std::string_view conservative_motion_name(ConservativeMotion motion) {
  switch (motion) {
  case ConservativeMotion::unknown:
    break;
  case ConservativeMotion::neutral:
    return "neutral";
  case ConservativeMotion::island:
    return "island";
  case ConservativeMotion::chaotic_sea:
    return "chaotic sea";
  }
  return "undecided";
}

void describe_orbit(Attractor& attractor, const PeriodicOrbit& orbit) {
  attractor.type = AttractorType::periodic;
  attractor.termination = Termination::time;
  attractor.period = orbit.period;
  attractor.impacts = orbit.impacts;
  attractor.isolated_impacts = orbit.isolated_impacts;
  attractor.rests = orbit.rests;
  attractor.conservative = orbit.conservative;
  attractor.motion = orbit.neutral() ? ConservativeMotion::neutral : ConservativeMotion::unknown;
  attractor.state = orbit.state;
  attractor.multipliers = orbit.multipliers.values;
  attractor.exponents = orbit.multipliers.exponents;
  attractor.standard_errors.assign(attractor.exponents.size(), 0.0);
  attractor.orbit.reset();
}

void settle_on(Attractor& attractor, PeriodicOrbit orbit) {
  describe_orbit(attractor, orbit);
  attractor.orbit = std::make_shared<const PeriodicOrbit>(std::move(orbit));
}

Attractor approach_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  Approach approach(system, p, start, options);
  Propagator propagator(system, p, {}, options.lyapunov.flow);
  do {
    if (!carry_watched(propagator, approach, [&] { return cancelled(options); })) approach.stop(Termination::interrupted);
    if (approach.asks() > 0)
      approach.answer(look_for_orbit(propagator, approach.state(), approach.asks(), options, approach.passed_by()));
  } while (approach.open());
  return std::move(approach).result();
}

Attractor find_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  Attractor out = approach_attractor(system, p, start, options);
  average_on_attractor(system, p, out, options);
  return out;
}

}  // namespace graze
