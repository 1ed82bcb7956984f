// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/approach.hpp>
#include <graze/floquet/rounds.hpp>
#include <graze/floquet/side_by_side.hpp>
#include <graze/lib/in_parallel.hpp>

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

void settle_on(Attractor& attractor, PeriodicOrbit orbit) {
  attractor.type = AttractorType::periodic;
  attractor.termination = Termination::time;
  attractor.period = orbit.period;
  attractor.impacts = orbit.impacts;
  attractor.state = orbit.state;
  attractor.exponents = orbit.multipliers.exponents;
  attractor.standard_errors.assign(attractor.exponents.size(), 0.0);
  attractor.orbit = std::move(orbit);
}

Attractor approach_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  Approach approach(system, p, start, options);
  Propagator propagator(system, p, {}, options.lyapunov.flow);
  do {
    if (!carry_watched(propagator, approach, [&] { return cancelled(options); })) approach.stop(Termination::interrupted);
    if (approach.asks() > 0) approach.answer(look_for_orbit(propagator, approach.state(), approach.asks(), options));
  } while (approach.open());
  return std::move(approach).result();
}

std::vector<Attractor> approach_each_attractor(const HybridSystem& system, const std::vector<AverageStart>& starts,
                                               const AttractorOptions& options) {
  std::vector<Attractor> out;
  if (!lanes_know_each(system, starts, options.lyapunov.flow)) {
    for (const AverageStart& start : starts) out.push_back(approach_attractor(system, start.p, start.state, options));
    return out;
  }
  ManyMotions many(system, options.lyapunov.flow);
  std::vector<std::size_t> sets;
  std::vector<Approach> approaches;
  for (const AverageStart& start : starts) {
    sets.push_back(many.add_parameters(start.p));
    approaches.emplace_back(system, start.p, start.state, options);
  }
  const auto stop = [&] { return cancelled(options); };
  for (std::vector<std::size_t> asking;; asking.clear()) {
    if (!carry_side_by_side(many, sets, approaches, stop))
      for (Approach& approach : approaches)
        if (approach.open()) approach.stop(Termination::interrupted);
    for (std::size_t k = 0; k < approaches.size(); ++k)
      if (approaches[k].asks() > 0) asking.push_back(k);
    if (asking.empty()) break;
    for_each_index(options.lyapunov.all_threads, asking.size(), [&](std::size_t i) {
      Approach& approach = approaches[asking[i]];
      Propagator propagator(system, starts[asking[i]].p, {}, options.lyapunov.flow);
      approach.answer(look_for_orbit(propagator, approach.state(), approach.asks(), options));
    });
  }
  for (Approach& approach : approaches) out.push_back(std::move(approach).result());
  return out;
}

Attractor find_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  Attractor out = approach_attractor(system, p, start, options);
  average_on_attractor(system, p, out, options);
  return out;
}

}  // namespace graze
