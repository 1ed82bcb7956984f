// SPDX-License-Identifier: GPL-3.0-or-later
// Orbits found side by side in lanes, against closed forms and against shoot().
#include <graze/floquet/attractor/settling_orbit.hpp>
#include <graze/floquet/orbit/lane_orbits.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include "support/checks.hpp"
#include "support/newton_oscillator.hpp"

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::support;

namespace {

struct Guess {
  Vector p;
  std::vector<Vector> states;
};

/// States on the closed-form orbit, displaced by `off`.
Guess guess_at(const OneImpactOrbit& orbit, double off) {
  Guess guess{parameters_of(orbit.parameters), {}};
  for (const Vector& x : orbit.states()) guess.states.push_back(x + vector({-off, 0.3 * off}));
  return guess;
}

/// The orbits to which Newton's method converges from these guesses, side by side.
std::vector<LaneOrbit> shoot_together(LaneCarrier& many, const std::vector<Guess>& guesses, NewtonPatience patience = {}) {
  std::vector<LaneOrbit> orbits(guesses.size());
  TaskPool(many).run(guesses.size(), [&](std::size_t i, TaskSlot& slot) -> MotionTask<> {
    slot.set_parameters(guesses[i].p);
    REQUIRE(slot.in_lanes());
    orbits[i] = co_await shoot_in_lanes(slot, guesses[i].states, patience);
  });
  return orbits;
}

struct Known {
  int n;
  double eta, x, v;
};
/// Orbits of the undamped Hertz oscillator, data/reference.toml.
constexpr Known hertz_orbits[] = {{1, 0.94, 2.0403618495903122, 1.4731190769020732},
                                  {2, 0.746, 1.7281647066530512, -1.3466409698271533},
                                  {4, 0.744, 1.8776844598713907, -1.0403064428256055},
                                  {16, 0.738, 1.9799649748980708, -0.75703864359156714}};

}  // namespace

TEST_CASE("lane orbits: closed forms with one impact are found all at once") {
  LaneCarrier many(newton_oscillator());
  std::vector<OneImpactOrbit> exact;
  std::vector<Guess> guesses;
  for (const double k_r : {1.0, 0.8, 0.45})
    for (const double r : {2.0, 0.7, 0.0, -0.4})
      for (const double eta : {0.63, 0.955, 1.2, 1.71, 2.06, 2.43, 2.75, 3.87})
        for (int n = 1; n <= 5; ++n)
          for (const OneImpactOrbit& orbit : one_impact_orbits({0.05, 1.0, eta, r, k_r}, n)) {
            const double T = orbit.parameters.period();
            // Orbits without a second impact nearby, and with room for the guess next to the barrier.
            if (!orbit.admissible() || orbit.highest > -1e-2 || orbit.time < 0.02 * T || orbit.time > 0.98 * T) continue;
            if (orbit.speed < 0.05) continue;
            guesses.push_back(guess_at(orbit, 1e-5));
            exact.push_back(orbit);
          }
  REQUIRE(exact.size() > 60);
  const std::vector<LaneOrbit> found = shoot_together(many, guesses);
  int stable = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const OneImpactOrbit& orbit = exact[i];
    INFO("eta " << orbit.parameters.eta << " r " << orbit.parameters.r << " k_r " << orbit.parameters.k_r << " n " << orbit.n
                << " speed " << orbit.speed << " multiplier " << orbit.multipliers[0]);
    REQUIRE(found[i].converged);
    CHECK_FALSE(found[i].delicate);
    CHECK(found[i].impacts == 1);
    REQUIRE(static_cast<int>(found[i].states.size()) == orbit.n);
    // Rounding of the residual times |(M - I)^-1|; M grows like 1/speed.
    const double along = std::abs(1.0 - orbit.multipliers[0]) * std::abs(1.0 - orbit.multipliers[1]);
    const double tolerance = 1e-13 * (1.0 + (1.0 + 1.0 / orbit.speed) / along);
    const std::vector<Vector> states = orbit.states();
    for (std::size_t k = 0; k < states.size(); ++k)
      CHECK((vector({found[i].states[k][0], found[i].states[k][1]}) - states[k]).norm() < 10.0 * tolerance);
    // The derivative of the trace in the state grows like 1/speed^3.
    for (std::size_t k = 0; k < 2; ++k)
      CHECK(std::abs(found[i].multipliers[k]) == Approx(std::abs(orbit.multipliers[k])).margin(1e-9).epsilon(1e-9));
    CHECK(found[i].stable() == orbit.stable());
    stable += orbit.stable();
  }
  CHECK(stable > 10);
  CHECK(stable < static_cast<int>(exact.size()) - 10);

  // With a limit on the growth of the tangent, orbits beyond it are given up and the others are unchanged.
  const std::vector<LaneOrbit> slow = shoot_together(many, guesses, {.most_growth = 3.0});
  int given_up = 0, same = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const double growth = std::abs(exact[i].multipliers[0]);
    if (std::abs(growth - 3.0) < 0.5) continue;  // the guess is slightly off the orbit
    CHECK(slow[i].converged == (growth < 3.0));
    given_up += !slow[i].converged;
    if (!slow[i].converged) continue;
    CHECK(slow[i].states == found[i].states);
    ++same;
  }
  CHECK(given_up >= 10);
  CHECK(same >= 10);
}

TEST_CASE("lane orbits: near a fold a guess is given up sooner if fewer step halvings are allowed") {
  for (const double k_r : {1.0, 0.7})
    for (const double eta : {1.3, 1.7}) {
      INFO("k_r " << k_r << " eta " << eta);
      OneImpactParameters at{0.05, 1.0, eta, 1.0, k_r};
      const OneImpactFamily family = one_impact_family(at, 1);
      REQUIRE(family.fold_speed() > 0.05);
      at.xi = family.xi_fold();
      const OneImpactOrbit fold = one_impact_orbit(at, 1, family.fold_speed());
      at.xi *= 0.98;
      REQUIRE(one_impact_orbits(at, 1).empty());
      const auto periods = [&](NewtonPatience patience) {
        LaneCarrier many(newton_oscillator());
        Guess guess = guess_at(fold, 0.0);
        guess.p = parameters_of(at);
        CHECK_FALSE(shoot_together(many, {guess}, patience).front().converged);
        return many.carried();
      };
      CHECK(periods({.max_halvings = 6}) < periods({}));
    }
}

TEST_CASE("lane orbits: orbits with a Hertz stop agree with shoot() alone and among others") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  LaneCarrier many(system);
  std::vector<Guess> guesses;
  std::vector<PeriodicOrbit> exact;
  for (const Known& known : hertz_orbits) {
    const Vector p = parameters(system, {{"b", 0.05}, {"eta", known.eta}, {"r", 2.0}, {"k_H", 100.0}, {"b_H", 0.0}});
    exact.push_back(shoot(system, p, vector({known.x, known.v}), known.n));
    REQUIRE(exact.back().converged());
    Guess guess{p, {}};
    for (const Vector& state : exact.back().states) guess.states.push_back(state + vector({1e-6, -1e-6}));
    guesses.push_back(guess);
    // Two traversals: the result is the orbit of the least period.
    const std::vector<Vector> once = guess.states;
    guess.states.insert(guess.states.end(), once.begin(), once.end());
    guesses.push_back(guess);
    exact.push_back(exact.back());
  }
  const std::vector<LaneOrbit> together = shoot_together(many, guesses);
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    INFO(i << ": period " << exact[i].period);
    const LaneOrbit& orbit = together[i];
    REQUIRE(orbit.converged);
    REQUIRE(static_cast<int>(orbit.states.size()) == exact[i].period);
    CHECK(orbit.impacts == exact[i].impacts);
    CHECK(std::hypot(orbit.states[0][0] - exact[i].state[0], orbit.states[0][1] - exact[i].state[1]) < 1e-11);
    for (std::size_t k = 0; k < 2; ++k) CHECK(std::abs(orbit.multipliers[k] - exact[i].multipliers.values[k]) < 1e-8);
    const LaneOrbit alone = shoot_together(many, {guesses[i]}).front();
    CHECK(alone.states == orbit.states);  // to the last bit
    CHECK(alone.multipliers == orbit.multipliers);
  }
}

TEST_CASE("lane orbits: delicate orbits and failed convergence are reported") {
  LaneCarrier many(newton_oscillator());
  // k_r = 0: the tangent loses a direction.
  const Vector plastic = parameters(newton_oscillator(), {{"b", 0.05}, {"eta", 0.95}, {"k_r", 0.0}});
  // The impactless orbit without a nearby impact, and a guess without an orbit: beyond the barrier.
  const OneImpactParameters far{0.05, 1.0, 2.0, 3.0, 0.8};
  const Vector free = parameters_of(far);
  const Vector steady = detail::impactless(far, 0.0);
  const PeriodicOrbit sticking = shoot(newton_oscillator(), plastic, vector({1.0, 1.0}), 1);
  REQUIRE(sticking.converged());
  const std::vector<LaneOrbit> orbits =
      shoot_together(many, {{plastic, {sticking.state}}, {free, {steady + vector({0.1, 0.0})}}, {free, {vector({3.5, 0.0})}}});
  CHECK(orbits[0].converged);
  CHECK(orbits[0].delicate);
  REQUIRE(orbits[1].converged);
  CHECK_FALSE(orbits[1].delicate);
  CHECK(orbits[1].states[0][0] == Approx(steady[0]).epsilon(1e-13));
  CHECK(std::abs(orbits[1].multipliers[0]) == Approx(std::exp(-0.05 * far.period())).epsilon(1e-13));
  CHECK_FALSE(orbits[2].converged);
}

TEST_CASE("the orbit of a settling motion agrees with Newton's method from each return") {
  // Cases: in chaos, near a period doubling, and on a long orbit. The reference calls shoot() from every return, which the
  // lanes avoid.
  const HybridSystem system = make_oscillator("linear", "hertz");
  for (const auto& [eta, settled] : {std::pair{0.711, 300}, {0.745, 40}, {0.738, 200}, {0.9196, 30}, {0.95, 20}}) {
    const Vector p = parameters(system, {{"b", 0.05}, {"eta", eta}, {"r", 2.0}, {"k_H", 100.0}, {"b_H", 0.0}});
    Propagator propagator(system, p);
    const double T = forcing_period(system, p);
    Transition transition;
    std::vector<Vector> states = {vector({0.0, 0.0})};
    for (int k = 0; k < settled; ++k) {
      carry(propagator, 0.0, T, states.front(), {.sensitivity = Sensitivity::none}, transition);
      states.front() = transition.x1;
    }
    const Vector state = states.front();
    const double scale = 1.0 + state.lpNorm<Eigen::Infinity>();
    std::optional<PeriodicOrbit> expected;
    constexpr int longest = 24;
    for (int n = 1; n <= longest && !expected; ++n) {
      carry(propagator, 0.0, T, states.back(), {.sensitivity = Sensitivity::state}, transition);  // as settling_orbit does
      const Vector next = transition.x1;
      if ((next - state).lpNorm<Eigen::Infinity>() < 0.03 * scale) {
        const PeriodicOrbit orbit = shoot(system, p, states, n);
        double distance = 1e9, later = 1e9;
        for (const Vector& one : orbit.states) distance = std::min(distance, (one - state).lpNorm<Eigen::Infinity>());
        Vector x = state;  // much later: on it, or not
        for (int k = 0; k < 2000; ++k) {
          carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::none}, transition);
          x = transition.x1;
        }
        for (const Vector& one : orbit.states) later = std::min(later, (one - x).lpNorm<Eigen::Infinity>());
        if (orbit.converged() && orbit.stable() && distance < 0.06 * scale && later < std::max(distance, 1e-9)) expected = orbit;
      }
      states.push_back(next);
    }
    INFO("eta " << eta);
    const auto found = settling_orbit(system, p, state, longest);
    REQUIRE(found.has_value() == expected.has_value());
    if (!found) continue;
    CHECK(found->period == expected->period);
    CHECK(found->states.front() == expected->state);  // the final computation is the same: identical bits
  }
}
