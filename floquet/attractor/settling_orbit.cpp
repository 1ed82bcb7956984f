// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/distance_watch.hpp>
#include <graze/floquet/attractor/near_doubling.hpp>
#include <graze/floquet/attractor/refused_orbits.hpp>
#include <graze/floquet/attractor/settling_orbit.hpp>
#include <graze/lib/motion/rest.hpp>
#include <graze/lib/numerics/decompositions.hpp>
#include <graze/lib/numerics/parallel.hpp>
#include <graze/lib/tasks/observe.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>

namespace graze {

namespace {

/// A settled state returns this closely after one period of its orbit, relative to 1 + |x|. This only selects; Newton decides.
constexpr double worth_trying = 0.03;

/// Distance between the halves of a doubled orbit up to which the midpoints are tried. The tangent along them grows by little
/// more than the multiplier of the simple orbit.
constexpr double near_halves = 4.0 * worth_trying, growth_at_doubling = 2.0;

/// Fast search: returns whose tangent grows by more are skipped. A motion that approaches a stable orbit will be tested again
/// later, when its tangent no longer grows.
constexpr double max_growth_of_return = 30.0;

/// A return whose tangent grows by more than max_growth does not lead to a stable orbit: its distance cannot explain such
/// growth. The same holds for a motion whose tangent has grown this much after growth_test_periods periods (chaos with an
/// exponent of 0.054 a period).
constexpr double max_growth = 1e3;
constexpr int growth_test_periods = 128;

/// Near a stable orbit Newton's method takes full steps, or large fractions of them. (Of 30,000 attempts in a map of a damped
/// Hertz oscillator that converged, one had a step shorter than 1/64.) Ever shorter steps mean that it creeps towards a minimum
/// of the residual where there is no orbit, as before a fold. Twelve halvings of each step took most of the time of all
/// attempts.
constexpr int quick_halvings = 6;

constexpr double any_growth = std::numeric_limits<double>::infinity();

/// Number of returns that look_for_orbit tries.
constexpr std::size_t most_tries = 3;

/// A motion near an orbit with these states, carried until it is known whether it approaches the orbit.
class NearOrbit {
 public:
  NearOrbit(const std::vector<Vector>& orbit, const Vector& x, double slowest)
      : orbit_(orbit), at_(x), watch_(nearest_distance(orbit, x), slowest, static_cast<int>(orbit.size())) {}
  bool open() const { return watch_.open(); }
  const Vector& state() const { return at_; }
  void see(Termination end, const Vector& state) {
    if (end != Termination::time) return watch_.stop();
    at_ = state;
    if (++periods_ % watch_.periods() == 0) watch_.see(nearest_distance(orbit_, at_));
  }
  bool comes_closer() const { return watch_.comes_closer(); }

 private:
  const std::vector<Vector>& orbit_;
  Vector at_;
  DistanceWatch watch_;
  int periods_ = 0;
};

/// A motion of a conservative system approaches no orbit: it is on the orbit, up to rounding, or it is not.
bool is_on(const std::vector<Vector>& orbit, const Vector& x) {
  return nearest_distance(orbit, x) < DistanceWatch::rounding_distance * (1.0 + state_size(x));
}

/// Longer returns are mostly chance, unless the motion has settled: they must be closer by this factor.
constexpr double settled = 0.05;

/// The periods after which the states return to the first one, closest return first.
std::vector<int> returns_of(const std::vector<Vector>& states, double nearness, int max_period) {
  constexpr double alike = 1e-10;  // closer returns count as equal: the shortest comes first
  const double scale = 1.0 + state_size(states.front());
  std::vector<std::pair<double, int>> found;
  for (int n = 1; n <= max_period && n < static_cast<int>(states.size()); ++n) {
    const double distance = std::max(alike, state_distance(states[static_cast<std::size_t>(n)], states.front()) / scale);
    if (distance < (n > short_return ? settled * nearness : nearness)) found.emplace_back(distance, n);
  }
  std::sort(found.begin(), found.end());
  std::vector<int> periods;
  for (const auto& one : found) periods.push_back(one.second);
  return periods;
}

/// The returns to try: the closest ones, each after its divisors among the close returns. Newton's method then need not
/// discover that an orbit is shorter.
std::vector<int> returns_to_try(const std::vector<int>& periods) {
  std::vector<int> out;
  for (std::size_t i = 0; i < std::min(most_tries, periods.size()); ++i)
    for (int d = 1; d <= periods[i]; ++d)
      if (periods[i] % d == 0 && std::find(periods.begin(), periods.end(), d) != periods.end() &&
          std::find(out.begin(), out.end(), d) == out.end())
        out.push_back(d);
  return out;
}

}  // namespace

bool may_rest(const HybridSystem& system, const Vector& p, const Vector& state) {
  constexpr double near_stop = 0.1;  // relative to 1 + |x|; bounces many times a period are closer to the stop
  return std::any_of(system.events.begin(), system.events.end(), [&](const Event& event) {
    if (!event.accumulation) return false;
    Vector rest = state;
    event.accumulation->reset.map(0.0, state, p, rest);
    return state_distance(rest, state) < near_stop * (1.0 + state_size(rest)) &&
           mode_at(system, 0.0, rest, p) == event.accumulation->sticking_mode;
  });
}

std::optional<PeriodicOrbit> resting_orbit(Propagator& propagator, const Vector& state) {
  if (!may_rest(propagator.system(), propagator.parameters(), state)) return std::nullopt;
  const std::optional<Vector> rest = permanent_rest(propagator, state);
  if (!rest || !reaches_rest(propagator, state, *rest)) return std::nullopt;
  ShootingOptions shooting;
  shooting.flow = propagator.options();
  PeriodicOrbit orbit = shoot(propagator.system(), propagator.parameters(), *rest, 1, shooting);
  if (!orbit.converged() || !orbit.rests) return std::nullopt;
  return orbit;
}

namespace {

/// While it exists, a Propagator carries the slot's motions.
class OneByOne {
 public:
  explicit OneByOne(TaskSlot& slot) : slot_(slot), p_(slot.p()) { slot.set_parameters(p_, true); }
  OneByOne(const OneByOne&) = delete;
  OneByOne& operator=(const OneByOne&) = delete;
  ~OneByOne() { slot_.set_parameters(p_); }

 private:
  TaskSlot& slot_;
  Vector p_;
};

/// Whether the orbit to which Newton's method converged may be the one on which the motion at `state` is settling.
bool may_settle(const Shot& shot, const Vector& state) {
  return shot.converged && shot.holds &&
         nearest_distance(shot.orbit.states, state) < 2.0 * worth_trying * (1.0 + state_size(state));
}

/// The states of a motion after 0, 1, ... `periods` periods; fewer if it ends.
MotionTask<std::vector<Vector>> next_states(TaskSlot& slot, const Vector& state, int periods) {
  std::vector<Vector> states{state};
  const CarriedPeriods carried = co_await slot.carry(state, static_cast<std::size_t>(std::max(0, periods)));
  append_states(carried, 0, states);
  co_return states;
}

/// The orbit to which Newton's method converges from the states around a return, or from a guess next to a period doubling.
/// `first`: that from the states around the return; null if it is not known.
MotionTask<Shot> shoot_next_to_doubling(TaskSlot& slot, const std::vector<Vector>& around, double most_growth,
                                        const Shot* first) {
  const NewtonPatience patience{most_growth, quick_halvings}, at_doubling{growth_at_doubling, quick_halvings};
  Shot shot;
  if (first)
    shot = *first;
  else
    shot = co_await shoot_from(slot, around, patience);
  if (!shot.converged && !shot.given_up)
    if (const std::vector<Vector> half = between_halves(around, near_halves); !half.empty())
      shot = co_await shoot_from(slot, half, at_doubling);
  if (!shot.converged) co_return shot;
  const std::vector<Vector> single = shot.orbit.states;
  if (has_doubled(single.size(), shot.multiplier(), around.size())) {
    const std::size_t three_times = 3 * single.size();
    const std::vector<Vector> motion = co_await next_states(slot, around.front(), static_cast<int>(three_times));
    if (motion.size() <= three_times) co_return shot;
    const std::vector<Vector> doubled = doubled_states(single, shot.multiplier().real(), motion);
    if (!doubled.empty()) shot = co_await shoot_from(slot, doubled, patience);
  }
  co_return shot;
}

/// Whether the motion at `state` is settling on the orbit.
MotionTask<bool> approaches(TaskSlot& slot, const Shot& shot, const Vector& state) {
  if (shot.orbit.conservative) co_return is_on(shot.orbit.states, state);
  NearOrbit motion(shot.orbit.states, state, std::abs(shot.multiplier()));
  const auto never = [] { return false; };
  co_await carry_watched(slot, motion, never);
  co_return motion.comes_closer();
}

/// The stable orbit near the states around a return, if the motion through them approaches it and was not seen to pass it.
MotionTask<std::optional<StableOrbit>> orbit_around(TaskSlot& slot, const std::vector<Vector>& around, double most_growth,
                                                    RefusedOrbits& refused, const Shot* first = nullptr) {
  std::optional<StableOrbit> found;  // (g++ 12 miscompiles early returns here)
  Shot shot = co_await shoot_next_to_doubling(slot, around, most_growth, first);
  if (may_settle(shot, around.front()) && !refused.knows(shot.orbit.states, around.front())) {
    const bool comes_closer = co_await approaches(slot, shot, around.front());
    if (comes_closer)
      found = std::move(shot.orbit);
    else
      refused.add(shot.orbit.states, around.front());
  }
  co_return found;
}

/// The same for the returns of an exhaustive search, the first that leads to an orbit: Newton's method runs from many guesses at
/// once. Chaos has many returns, most of them to unstable orbits, which are not looked at any closer.
MotionTask<std::optional<StableOrbit>> orbit_around_any(TaskSlot& slot, const std::vector<std::vector<Vector>>& guesses,
                                                        bool all_threads, RefusedOrbits& refused) {
  const SharedSystem& system = slot.system();
  const std::size_t together =
      motions_at_once(system, slot.p(), slot.flow()) * (all_threads ? available_threads() : std::size_t{1});
  const auto can_be_skipped = [&](const Shot& shot, const std::vector<Vector>& around) {
    if (!shot.converged) return between_halves(around, near_halves).empty();
    if (has_doubled(shot.orbit.states.size(), shot.multiplier(), around.size())) return false;
    return !may_settle(shot, around.front()) || refused.knows(shot.orbit.states, around.front());
  };
  for (std::size_t begin = 0; begin < guesses.size(); begin += together) {
    std::vector<Shot> shots(std::min(together, guesses.size() - begin));
    run_tasks(system, slot.flow(), all_threads, shots.size(), [&](std::size_t i, TaskSlot& one) -> MotionTask<> {
      one.set_parameters(slot.p());
      const NewtonPatience patience{any_growth, quick_halvings};
      shots[i] = co_await shoot_from(one, guesses[begin + i], patience);
    });
    for (std::size_t i = 0; i < shots.size(); ++i) {
      const std::vector<Vector>& around = guesses[begin + i];
      if (can_be_skipped(shots[i], around)) continue;
      const Shot* const first = shots[i].orbit.whole ? &shots[i] : nullptr;
      if (auto orbit = co_await orbit_around(slot, around, any_growth, refused, first)) co_return orbit;
    }
  }
  co_return std::nullopt;
}

/// The search among the closest returns.
MotionTask<OrbitSearchResult> look(TaskSlot& slot, const Vector& state, int max_period, double nearness,
                                   RefusedOrbits& passed_by) {
  OrbitSearchResult out;
  const std::vector<Vector> states = co_await next_states(slot, state, max_period);
  const std::vector<int> returns = returns_of(states, nearness, max_period);
  if (!returns.empty()) out.closest = returns.front();
  for (const int n : returns_to_try(returns)) {
    const std::vector<Vector> around(states.begin(), states.begin() + n);
    out.orbit = co_await orbit_around(slot, around, max_growth_of_return, passed_by);
    if (out.orbit) break;
  }
  co_return out;
}

/// Whether the last of these returns, after 1, 2, ... n periods, is closer than those after the divisors of n. Otherwise it
/// would lead to the same orbits as they do.
bool closer_than_divisors(const std::vector<double>& distances) {
  const std::size_t n = distances.size();
  for (std::size_t d = 1; d <= n / 2; ++d)
    if (n % d == 0 && distances[n - 1] > 0.5 * distances[d - 1]) return false;
  return true;
}

/// The exhaustive search: all returns that may have settled. The slot's motions are carried by a Propagator.
MotionTask<std::optional<StableOrbit>> look_at_all(TaskSlot& slot, const Vector& state, int max_period, bool all_threads) {
  const double scale = 1.0 + state_size(state);
  std::vector<Vector> states{state};
  std::vector<std::vector<Vector>> guesses;  // the states around returns that have not been tried
  RefusedOrbits refused;                     // several returns may lead to the same one
  Matrix growth = Matrix::Identity(state.size(), state.size());
  std::vector<double> distances;  // of the returns
  std::size_t enough = 1;
  // Whether the tangent has shrunk over one of the returns. Until then the other returns wait for the test of long-term growth.
  bool shrinks = false;
  for (int n = 1; n <= max_period || (!guesses.empty() && n <= growth_test_periods); ++n) {
    const CarriedPeriods period = co_await slot.carry_with_tangent(states.back(), 1);
    if (period.termination(0) != Termination::time) break;
    growth = period.map(0) * growth;
    Vector next(state.size());
    period.state(0, next);
    distances.push_back(state_distance(next, state) / scale);
    if (n <= max_period && distances.back() < worth_trying && closer_than_divisors(distances)) {
      const double grown = spectral_radius(growth);
      if (!(grown > max_growth)) guesses.push_back(states);
      shrinks = shrinks || grown < 1.0;
    }
    if (shrinks && guesses.size() >= enough) {
      if (auto orbit = co_await orbit_around_any(slot, guesses, all_threads, refused)) co_return orbit;
      guesses.clear();
      enough *= 2;
    }
    states.push_back(std::move(next));
  }
  if (spectral_radius(growth) > max_growth) co_return std::nullopt;
  co_return co_await orbit_around_any(slot, guesses, all_threads, refused);
}

}  // namespace

MotionTask<std::optional<StableOrbit>> orbit_approached(TaskSlot& slot, const Shot& shot, const Vector& state) {
  std::optional<StableOrbit> approached;  // (g++ 12 miscompiles this function with early returns)
  if (may_settle(shot, state)) {
    const bool comes_closer = co_await approaches(slot, shot, state);
    if (comes_closer) approached = shot.orbit;
  }
  co_return approached;
}

MotionTask<int> closest_return(TaskSlot& slot, const Vector& state, int max_period, double nearness) {
  const std::vector<Vector> states = co_await next_states(slot, state, max_period);
  const std::vector<int> returns = returns_of(states, nearness, max_period);
  co_return returns.empty() ? 0 : returns.front();
}

namespace {

/// Puts the orbit of shoot() in place of this one: its Newton's method makes a further step, which may change last digits.
void refine(StableOrbit& orbit, const TaskSlot& slot) {
  ShootingOptions shooting;
  shooting.flow = slot.flow();
  PeriodicOrbit found = shoot(slot.system(), slot.p(), orbit.states, orbit.period, shooting);
  if (found.converged()) orbit = StableOrbit(std::move(found));
}

}  // namespace

MotionTask<OrbitSearchResult> look_for_orbit(TaskSlot& slot, const Vector& state, OrbitSearch search) {
  OrbitSearchResult out;
  if (may_rest(slot.system(), slot.p(), state)) {
    const OneByOne alone(slot);
    if (std::optional<PeriodicOrbit> rest = resting_orbit(slot.propagator(), state)) {
      out.orbit = StableOrbit(std::move(*rest));
      co_return out;
    }
  }
  if (!(search.nearness > 0.0)) {
    const OneByOne alone(slot);
    out.orbit = co_await look_at_all(slot, state, search.max_period, search.all_threads);
    if (out.orbit && is_forced(slot.system())) refine(*out.orbit, slot);
    co_return out;
  }
  RefusedOrbits here;
  out = co_await look(slot, state, search.max_period, search.nearness, search.refused ? *search.refused : here);
  co_return out;
}

std::optional<StableOrbit> settling_orbit(const HybridSystem& system, const Vector& p, const Vector& state, int max_period,
                                          const FlowOptions& flow) {
  OrbitSearchResult found;
  run_alone(system, flow, [&](TaskSlot& slot) -> MotionTask<> {
    slot.set_parameters(p);
    const OrbitSearch search{.max_period = max_period};
    found = co_await look_for_orbit(slot, state, search);
  });
  return found.orbit;
}

namespace {

/// Whether the motion carries on for growth_test_periods and its tangent has not grown by more than max_growth by then.
MotionTask<> keeps_small_tangent(TaskSlot& slot, const Vector& p, const Vector& state, char& answer) {
  constexpr int stretch = growth_test_periods / 4;
  slot.set_parameters(p);
  answer = false;
  Vector at = state;
  Matrix growth = Matrix::Identity(at.size(), at.size());
  for (int carried = stretch; carried <= growth_test_periods; carried += stretch) {
    const CarriedPeriods periods = co_await slot.carry_with_tangent(at, stretch);
    if (periods.termination(stretch - 1) != Termination::time) co_return;
    for (std::size_t k = 0; k < stretch; ++k) growth = periods.map(k) * growth;
    periods.state(stretch - 1, at);
    // A tangent that has grown by the square of max_growth by now will not have shrunk enough at the end.
    const double most = carried == growth_test_periods ? max_growth : max_growth * max_growth;
    if (spectral_radius(growth) > most) co_return;
  }
  answer = true;
}

}  // namespace

std::vector<Vector> settling_candidates(const HybridSystem& system, const Vector& p, const std::vector<Vector>& states,
                                        const FlowOptions& flow, bool all_threads) {
  std::vector<char> kept(states.size());
  run_tasks(system, flow, all_threads, states.size(),
            [&](std::size_t i, TaskSlot& slot) { return keeps_small_tangent(slot, p, states[i], kept[i]); });
  std::vector<Vector> out;
  for (std::size_t i = 0; i < states.size(); ++i)
    if (kept[i]) out.push_back(states[i]);
  return out;
}

}  // namespace graze
