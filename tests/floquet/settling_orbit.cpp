// SPDX-License-Identifier: GPL-3.0-or-later
// The orbit on which a motion settles: where chaos and a stable orbit lie close together, and near a period doubling.
#include <graze/floquet/attractor/near_doubling.hpp>
#include <graze/floquet/attractor/refused_orbits.hpp>
#include <graze/floquet/attractor/settle.hpp>
#include <graze/floquet/attractor/settling_orbit.hpp>
#include <graze/floquet/orbit/stroboscopic_states.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include "support/checks.hpp"
#include "support/damped_hertz.hpp"

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::support;

namespace {

/// At these parameters chaos (largest exponent 0.010) coexists with a stable orbit 12/12, close to it and with a small basin.
const HybridSystem& system_with_both() {
  static const HybridSystem system = make_oscillator("linear", "newton");
  return system;
}
Vector with_both() {
  return parameters(system_with_both(), {{"b", 0.05}, {"xi", 1.0}, {"eta", 0.7396}, {"r", 2.0}, {"k_r", 1.0}});
}
const Vector chaotic = vector({1.8100099058373453, -0.86296494178271788});
const Vector beside_orbit = vector({1.81898998, -0.8426422});

/// The state after a number of periods.
Vector later(const Vector& state, int periods) {
  SettleOptions options;
  options.periods = periods;
  options.max_period = 0;
  return settle(system_with_both(), with_both(), state, options).state;
}

/// The state of the damped Hertz oscillator after a number of periods.
Vector settled(const Vector& p, const Vector& start, int periods) {
  SettleOptions options;
  options.periods = periods;
  return settle(damped_hertz(), p, start, options).state;
}

/// The state some time after eta was changed, from the settled state before.
Vector after_change(double from, double to) {
  return settled(hertz_parameters(to), settled(hertz_parameters(from), vector({0.0, 0.0}), 20000), 300);
}

constexpr int max_period = 8;
constexpr double nearness = 2e-3;

/// The fast search from a state of the damped Hertz oscillator, in lanes or with the Propagator.
std::optional<StableOrbit> fast_search(const Vector& p, const Vector& start, bool in_lanes, RefusedOrbits* refused = nullptr) {
  OrbitSearchResult look;
  const auto task = [&](TaskSlot& lane) -> MotionTask<> {
    lane.set_parameters(p);
    CHECK(lane.in_lanes() == in_lanes);
    const OrbitSearch search{.max_period = max_period, .nearness = nearness, .refused = refused};
    look = co_await look_for_orbit(lane, start, search);
  };
  LaneCarrier many(damped_hertz(), {});
  if (in_lanes)
    TaskPool(many).run(1, [&](std::size_t, TaskSlot& lane) { return task(lane); });
  else
    run_alone(damped_hertz(), {}, task);
  return look.orbit;
}

/// Results of each method of looking for an orbit.
std::vector<StableOrbit> orbits_by_each_method(const Vector& p, const Vector& start) {
  const auto alone = fast_search(p, start, false), in_lanes = fast_search(p, start, true);
  const auto exhaustive = settling_orbit(damped_hertz(), p, start, max_period);
  REQUIRE(alone);
  REQUIRE(in_lanes);
  REQUIRE(exhaustive);
  CHECK(alone->whole);
  CHECK_FALSE(in_lanes->whole);
  CHECK(exhaustive->whole);
  return {*alone, *in_lanes, *exhaustive};
}

/// The closest return, and the states before it.
std::vector<Vector> states_of_return(const Vector& p, const Vector& start) {
  int closest = 0;
  run_alone(damped_hertz(), {}, [&](TaskSlot& lane) -> MotionTask<> {
    lane.set_parameters(p);
    closest = co_await closest_return(lane, start, max_period, nearness);
  });
  Propagator propagator(damped_hertz(), p);
  return stroboscopic_states(propagator, start, static_cast<std::size_t>(closest));
}

}  // namespace

TEST_CASE("a motion that passes by a stable orbit does not count as settling on it") {
  // For twelve periods the motion approaches the orbit. Its multiplier would halve distances twelve times faster.
  const auto orbit = settling_orbit(system_with_both(), with_both(), beside_orbit, 64);
  REQUIRE(orbit);
  CHECK(orbit->period == 12);
  CHECK(std::abs(orbit->multipliers.values.front()) < 0.1);
  const auto distance = [&](const Vector& x) {
    double least = 1e9;
    for (const Vector& state : orbit->states) least = std::min(least, (state - x).lpNorm<Eigen::Infinity>());
    return least;
  };
  CHECK(distance(later(beside_orbit, 240)) < 1e-9);
  const double before = distance(chaotic);
  CHECK(before < 0.1);
  CHECK(distance(later(chaotic, 12)) < 0.75 * before);
  CHECK(distance(later(chaotic, 1200)) > 1e-3);  // it is still in chaos
  CHECK_FALSE(settling_orbit(system_with_both(), with_both(), chaotic, 64));
  CHECK_FALSE(settling_orbit(system_with_both(), with_both(), chaotic, 12));
}

TEST_CASE("motions that end or have a fast growing tangent are not searched for an orbit") {
  const Vector inside_barrier = vector({2.5, 0.0});
  const std::vector<Vector> states = {chaotic, beside_orbit, later(chaotic, 100), later(beside_orbit, 5), inside_barrier};
  const std::vector<Vector> left = settling_candidates(system_with_both(), with_both(), states);
  REQUIRE(left.size() == 2);
  CHECK(left[0] == states[1]);
  CHECK(left[1] == states[3]);
}

TEST_CASE("near a period doubling a motion is known from far off to settle on the orbit before the doubling") {
  // The doubled orbit of eta = 0.9195 begins to shrink at 0.91955, just past the doubling at 0.919542643. There the multiplier
  // of the 1/1 orbit is -0.99993, so that settling takes tens of thousands of periods.
  const Vector p = hertz_parameters(0.91955), start = after_change(0.9195, 0.91955);
  CHECK(states_of_return(p, start).size() == 2);

  const auto orbits = orbits_by_each_method(p, start);
  const Vector late = settled(p, start, 60000);
  for (const StableOrbit& orbit : orbits) {
    const Vector& state = orbit.states.front();
    CHECK(orbit.period == 1);
    CHECK(std::abs(orbit.multipliers.values.front()) == Approx(1.0 - 7.5e-5).margin(1e-6));
    CHECK((state - orbits.front().states.front()).norm() < 1e-10);
    // The plain motion gives the same result, in a longer time.
    CHECK((start - state).norm() > 0.01);
    CHECK((late - state).norm() < 1e-3);
  }
}

TEST_CASE("between the halves of a doubled orbit no settling is found if its parent is unstable") {
  const Vector p = hertz_parameters(0.9190);
  const Vector start = settled(p, vector({0.0, 0.0}), 3000);
  const auto orbit = fast_search(p, start, false);
  REQUIRE(orbit);
  CHECK(orbit->period == 2);
}

TEST_CASE("beyond a period doubling a motion is known from far off to settle on the doubled orbit") {
  // The doubled orbit of eta = 0.9194 shrinks to that of 0.9195. There the 1/1 orbit (multiplier -1.0004) is unstable, since
  // 0.919542643, but Newton's method converges to it.
  const Vector p = hertz_parameters(0.9195), start = after_change(0.9194, 0.9195);
  const std::vector<Vector> states = states_of_return(p, start);
  REQUIRE(states.size() == 2);
  const PeriodicOrbit by_newton = shoot(damped_hertz(), p, states, 2);
  CHECK((!by_newton.converged() || by_newton.period == 1));

  const Vector late = settled(p, start, 20000);
  for (const StableOrbit& orbit : orbits_by_each_method(p, start)) {
    CHECK(orbit.period == 2);
    CHECK(orbit.multipliers.stable());
    // The plain motion gives the same result, in a longer time.
    CHECK((start - orbit.states.front()).norm() > 0.003);
    CHECK(std::min((late - orbit.states[0]).norm(), (late - orbit.states[1]).norm()) < 1e-6);
  }
}

TEST_CASE("the states of a doubled orbit are estimated from the motion across its parent") {
  // x -> -(1 + e) x + x^3: the orbit that doubles is 0, its doubled one +-sqrt(e).
  const auto next = [](double x, double e) { return -(1.0 + e) * x + x * x * x; };
  for (const double e : {1e-5, 1e-3})
    for (const double times : {0.3, 1.0, 3.0}) {
      std::vector<Vector> motion = {vector({times * std::sqrt(e)})};
      for (int k = 0; k < 3; ++k) motion.push_back(vector({next(motion.back()[0], e)}));
      const std::vector<Vector> guess = doubled_states({vector({0.0})}, -(1.0 + e), motion);
      REQUIRE(guess.size() == 2);
      CHECK(guess[0][0] == Approx(std::sqrt(e)).epsilon(20.0 * e));
      CHECK(guess[1][0] == Approx(-std::sqrt(e)).epsilon(20.0 * e));
    }
  // A motion that grows faster than the multiplier is not on its way to a doubled orbit.
  CHECK(doubled_states({vector({0.0})}, -1.001, {vector({0.1}), vector({-0.11}), vector({0.12}), vector({-0.13})}).empty());
  CHECK(has_doubled(3, -1.001, 6));
  CHECK_FALSE(has_doubled(3, -0.999, 6));
  CHECK_FALSE(has_doubled(3, {-1.0, 0.1}, 6));
  CHECK_FALSE(has_doubled(3, 1.001, 6));
  CHECK_FALSE(has_doubled(3, -1.001, 3));
}

TEST_CASE("an orbit refused once is tested again when the motion is much closer") {
  const std::vector<Vector> orbit = {vector({1.0, 0.0}), vector({-1.0, 0.5})};
  const std::vector<Vector> other = {vector({1.0, 1e-6}), vector({-1.0, 0.5001})};
  RefusedOrbits refused;
  CHECK_FALSE(refused.knows(orbit, vector({1.1, 0.0})));
  refused.add(orbit, vector({1.1, 0.0}));
  CHECK(refused.knows(orbit, vector({1.1, 0.0})));
  const std::vector<Vector> turned = {orbit[1], orbit[0]};
  CHECK(refused.knows(turned, vector({-0.94, 0.5})));
  CHECK_FALSE(refused.knows(orbit, vector({-0.96, 0.5})));
  CHECK_FALSE(refused.knows(other, vector({1.1, 0.0})));

  // (At 0.91955 the doubled orbit of eta = 0.9195 shrinks slowly.)
  const Vector p = hertz_parameters(0.91955), start = after_change(0.9195, 0.91955);
  const auto look = [&](RefusedOrbits* known, std::size_t& carried) {
    LaneCarrier many(damped_hertz(), {});
    OrbitSearchResult out;
    TaskPool(many).run(1, [&](std::size_t, TaskSlot& lane) -> MotionTask<> {
      lane.set_parameters(p);
      const OrbitSearch search{.max_period = max_period, .nearness = nearness, .refused = known};
      out = co_await look_for_orbit(lane, start, search);
    });
    carried = many.carried();
    return out.orbit;
  };
  std::size_t all = 0, some = 0;
  const auto found = look(nullptr, all);
  REQUIRE(found);
  RefusedOrbits from_here, from_far;
  from_here.add(found->states, start);
  from_far.add(found->states, vector({start[0] - 1.0, start[1]}));
  CHECK_FALSE(look(&from_here, some));
  CHECK(some < all / 2);  // most of the time is spent on checking that the motion approaches
  CHECK(look(&from_far, some));
  CHECK(some == all);
  CHECK_FALSE(fast_search(p, start, false, &from_here));
  CHECK(fast_search(p, start, false, &from_far));
}

TEST_CASE("a look for an orbit records the orbits that the motion passes by") {
  const auto orbit = settling_orbit(system_with_both(), with_both(), beside_orbit, 64);
  REQUIRE(orbit);
  RefusedOrbits refused;
  LaneCarrier many(system_with_both(), {});
  for (const bool again : {false, true}) {
    TaskPool(many).run(1, [&](std::size_t, TaskSlot& lane) -> MotionTask<> {
      lane.set_parameters(with_both());
      const OrbitSearch search{.max_period = 12, .nearness = 0.1, .refused = &refused};
      const OrbitSearchResult look = co_await look_for_orbit(lane, chaotic, search);
      CHECK_FALSE(look.orbit);
    });
    INFO((again ? "again" : "at first"));
    CHECK(refused.knows(orbit->states, chaotic));
  }
}
