// SPDX-License-Identifier: GPL-3.0-or-later
// Orbits found side by side by the tasks of a pool, against closed forms and against shoot().
#include <graze/floquet/attractor/settling_orbit.hpp>
#include <graze/floquet/orbit/shot.hpp>
#include <graze/floquet/orbit/state_distance.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include "support/checks.hpp"
#include "support/driven_self_excited.hpp"
#include "support/newton_oscillator.hpp"
#include "support/two_mass_oscillator.hpp"

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
std::vector<Shot> shoot_together(LaneCarrier& many, const std::vector<Guess>& guesses, NewtonPatience patience = {}) {
  std::vector<Shot> orbits(guesses.size());
  TaskPool(many).run(guesses.size(), [&](std::size_t i, TaskSlot& slot) -> MotionTask<> {
    slot.set_parameters(guesses[i].p);
    REQUIRE(slot.in_lanes() == (guesses[i].states.front().size() == 2));
    orbits[i] = co_await shoot_from(slot, guesses[i].states, patience);
  });
  return orbits;
}

struct HertzOrbit {
  int n;
  double eta, x, v;
};
/// Orbits of the undamped Hertz oscillator, data/reference.toml.
constexpr HertzOrbit hertz_orbits[] = {{1, 0.94, 2.0403618495903122, 1.4731190769020732},
                                       {2, 0.746, 1.7281647066530512, -1.3466409698271533},
                                       {4, 0.744, 1.8776844598713907, -1.0403064428256055},
                                       {16, 0.738, 1.9799649748980708, -0.75703864359156714}};

/// The orbit of this period, or a divisor of it, near the motion from rest after 600 periods.
PeriodicOrbit settled(const HybridSystem& system, const Vector& p, int period) {
  Propagator propagator(system, p);
  Transition transition;
  transition.x1 = Vector::Zero(static_cast<Eigen::Index>(system.states));
  for (int k = 0; k < 600; ++k) carry_period(propagator, Vector(transition.x1), {.sensitivity = Sensitivity::none}, transition);
  PeriodicOrbit orbit = shoot(system, p, transition.x1, period);
  REQUIRE(orbit.converged());
  return orbit;
}

}  // namespace

TEST_CASE("shots: closed forms with one impact are found all at once") {
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
  const std::vector<Shot> found = shoot_together(many, guesses);
  int stable = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const OneImpactOrbit& orbit = exact[i];
    INFO("eta " << orbit.parameters.eta << " r " << orbit.parameters.r << " k_r " << orbit.parameters.k_r << " n " << orbit.n
                << " speed " << orbit.speed << " multiplier " << orbit.multipliers[0]);
    REQUIRE(found[i].converged);
    CHECK_FALSE(found[i].orbit.whole);
    CHECK(found[i].orbit.impacts == 1);
    REQUIRE(static_cast<int>(found[i].orbit.states.size()) == orbit.n);
    // Rounding of the residual times |(M - I)^-1|; M grows like 1/speed.
    const double along = std::abs(1.0 - orbit.multipliers[0]) * std::abs(1.0 - orbit.multipliers[1]);
    const double tolerance = 1e-13 * (1.0 + (1.0 + 1.0 / orbit.speed) / along);
    const std::vector<Vector> states = orbit.states();
    for (std::size_t k = 0; k < states.size(); ++k) CHECK((found[i].orbit.states[k] - states[k]).norm() < 10.0 * tolerance);
    // The derivative of the trace in the state grows like 1/speed^3.
    for (std::size_t k = 0; k < 2; ++k)
      CHECK(std::abs(found[i].orbit.multipliers.values[k]) == Approx(std::abs(orbit.multipliers[k])).margin(1e-9).epsilon(1e-9));
    CHECK(found[i].holds == orbit.stable());
    stable += orbit.stable();
  }
  CHECK(stable > 10);
  CHECK(stable < static_cast<int>(exact.size()) - 10);

  // With a limit on the growth of the tangent, orbits beyond it are given up and the others are unchanged.
  const std::vector<Shot> slow = shoot_together(many, guesses, {.most_growth = 3.0});
  int given_up = 0, same = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const double growth = std::abs(exact[i].multipliers[0]);
    if (std::abs(growth - 3.0) < 0.5) continue;  // the guess is slightly off the orbit
    CHECK(slow[i].converged == (growth < 3.0));
    given_up += !slow[i].converged;
    if (!slow[i].converged) continue;
    CHECK(slow[i].orbit.states == found[i].orbit.states);
    ++same;
  }
  CHECK(given_up >= 10);
  CHECK(same >= 10);
}

TEST_CASE("shots: near a fold a guess is given up sooner if fewer step halvings are allowed") {
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

TEST_CASE("shots: orbits with a Hertz stop agree with shoot() alone and among others") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  LaneCarrier many(system);
  std::vector<Guess> guesses;
  std::vector<PeriodicOrbit> exact;
  for (const HertzOrbit& known : hertz_orbits) {
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
  const std::vector<Shot> together = shoot_together(many, guesses);
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    INFO(i << ": period " << exact[i].period);
    REQUIRE(together[i].converged);
    const StableOrbit& orbit = together[i].orbit;
    REQUIRE(orbit.period == exact[i].period);
    CHECK(orbit.impacts == exact[i].impacts);
    CHECK((orbit.states.front() - exact[i].state).norm() < 1e-11);
    for (std::size_t k = 0; k < 2; ++k) CHECK(std::abs(orbit.multipliers.values[k] - exact[i].multipliers.values[k]) < 1e-8);
    const StableOrbit alone = shoot_together(many, {guesses[i]}).front().orbit;
    CHECK(alone.states == orbit.states);  // to the last bit
    CHECK(alone.multipliers.values == orbit.multipliers.values);
  }
}

TEST_CASE("shots: orbits that lose a direction are proved, and failed convergence is reported") {
  LaneCarrier many(newton_oscillator());
  // k_r = 0: the tangent loses a direction.
  const Vector plastic = parameters(newton_oscillator(), {{"b", 0.05}, {"eta", 0.95}, {"k_r", 0.0}});
  // The impactless orbit without a nearby impact, and a guess without an orbit: beyond the barrier.
  const OneImpactParameters far{0.05, 1.0, 2.0, 3.0, 0.8};
  const Vector free = parameters_of(far);
  const Vector steady = detail::impactless(far, 0.0);
  const PeriodicOrbit sticking = shoot(newton_oscillator(), plastic, vector({1.0, 1.0}), 1);
  REQUIRE(sticking.converged());
  const std::vector<Shot> orbits =
      shoot_together(many, {{plastic, {sticking.state}}, {free, {steady + vector({0.1, 0.0})}}, {free, {vector({3.5, 0.0})}}});
  CHECK(orbits[0].converged);
  CHECK(orbits[0].orbit.whole);
  REQUIRE(orbits[1].converged);
  CHECK_FALSE(orbits[1].orbit.whole);
  CHECK(orbits[1].orbit.states[0][0] == Approx(steady[0]).epsilon(1e-13));
  CHECK(std::abs(orbits[1].multiplier()) == Approx(std::exp(-0.05 * far.period())).epsilon(1e-13));
  CHECK_FALSE(orbits[2].converged);
}

TEST_CASE("shots: orbits with four states agree with shoot(), and stable ones are proved") {
  // The second oscillator at rest is an orbit, stable for mu < 0, with multipliers in closed form (other_systems.cpp).
  const HybridSystem excited = driven_self_excited();
  LaneCarrier many(excited);
  for (const double mu : {-0.4, -0.1, 0.05}) {
    INFO("mu " << mu);
    const Vector p = parameters(excited, {{"mu", mu}});
    const PeriodicOrbit exact = settled(excited, p, 1);
    for (const int times : {1, 2}) {  // two traversals: the result is the orbit of the least period
      const std::vector<Vector> states(static_cast<std::size_t>(times), exact.state + vector({1e-5, -1e-5, 1e-5, -1e-5}));
      const Shot shot = shoot_together(many, {{p, states}}).front();
      REQUIRE(shot.converged);
      CHECK(shot.orbit.period == 1);
      CHECK(shot.holds == (mu < 0.0));
      CHECK((shot.orbit.whole != nullptr) == (mu < 0.0));
      CHECK(shot.orbit.impacts == exact.impacts);
      CHECK((shot.orbit.states.front() - exact.state).norm() < 1e-11);
      for (std::size_t k = 0; k < 4; ++k) CHECK(std::abs(shot.orbit.multipliers.values[k] - exact.multipliers.values[k]) < 1e-9);
      if (mu > 0.0) CHECK(std::abs(shot.multiplier()) == Approx(std::exp(0.5 * mu * exact.duration)).epsilon(1e-10));
    }
  }
}

TEST_CASE("shots: of two masses, from several nodes") {
  const HybridSystem system = two_mass_oscillator();
  LaneCarrier many(system);
  for (const auto& [xi, eta] : {std::pair{1.0, 0.9}, {2.0, 0.7}, {1.5, 1.3}}) {
    INFO("xi " << xi << " eta " << eta);
    const Vector p = parameters(system, {{"xi", xi}, {"eta", eta}});
    const PeriodicOrbit exact = settled(system, p, 12);
    std::vector<Vector> states;
    for (int k = 0; k < 3; ++k)
      for (const Vector& state : exact.states) states.push_back(state + vector({-1e-6, 1e-6, -1e-6, 1e-6}));
    const Shot shot = shoot_together(many, {{p, states}}).front();
    REQUIRE(shot.converged);
    REQUIRE(shot.orbit.period == exact.period);
    CHECK(shot.holds);
    for (std::size_t k = 0; k < exact.states.size(); ++k) CHECK((shot.orbit.states[k] - exact.states[k]).norm() < 1e-11);
  }
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
    CHECK(state_distance(found->states.front(), expected->state) < 1e-13);  // the linear equations are solved in another way
  }
}
