// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/distance_watch.hpp>
#include <graze/floquet/attractor/near_doubling.hpp>
#include <graze/floquet/attractor/refused_orbits.hpp>
#include <graze/floquet/attractor/settling_orbit.hpp>
#include <graze/floquet/orbit/lane_orbits.hpp>
#include <graze/floquet/orbit/returns.hpp>
#include <graze/floquet/orbit/stroboscopic_states.hpp>
#include <graze/lib/motion/rest.hpp>
#include <graze/lib/numerics/decompositions.hpp>
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

/// The largest modulus of the eigenvalues of A; NaN if A is not finite.
double spectral_radius(const Matrix& A) {
  if (!A.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  return eigenvalues(A).cwiseAbs().maxCoeff();
}

/// Growth of the tangent along one period from each of these states, multiplied.
double growth_along(Propagator& propagator, const std::vector<Vector>& states) {
  Matrix growth = Matrix::Identity(states.front().size(), states.front().size());
  Transition transition;
  for (const Vector& state : states) {
    carry_period(propagator, state, {.sensitivity = Sensitivity::state}, transition);
    growth = period_map(transition) * growth;
  }
  return spectral_radius(growth);
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

/// The problem in which an orbit is sought, at the parameters p of a slot.
struct Search {
  const HybridSystem& system;
  const Vector& p;
};

/// While it exists, a Propagator carries the slot's motions.
class OneByOne {
 public:
  OneByOne(TaskSlot& slot, const Vector& p) : slot_(slot), set_(slot.parameters()), from_lanes_(slot.in_lanes()) {
    if (from_lanes_) slot.set_parameters(p, true);
  }
  OneByOne(const OneByOne&) = delete;
  OneByOne& operator=(const OneByOne&) = delete;
  ~OneByOne() {
    if (from_lanes_) slot_.set_parameters(set_);
  }

 private:
  TaskSlot& slot_;
  std::size_t set_;
  bool from_lanes_;
};

/// Result of Newton's method from a guess: in lanes, or by shoot().
struct Shot {
  bool converged = false;
  bool given_up = false;  ///< at once, because the tangent along the guess grows too much
  bool delicate = false;  ///< the lanes leave it to the Propagator
  bool holds = false;     ///< it is stable or neutral, and a motion
  std::complex<double> multiplier = std::numeric_limits<double>::quiet_NaN();  ///< the first; NaN: unknown
  StableOrbit orbit = {};                                                      ///< if it converged
};

Shot shot_of(const Search& search, const LaneOrbit& found) {
  Shot shot;
  shot.converged = found.converged;
  shot.given_up = found.given_up;
  if (!shot.converged) return shot;
  shot.delicate = found.delicate;
  shot.holds = found.stable();
  shot.multiplier = found.multipliers[0];
  StableOrbit& orbit = shot.orbit;
  orbit.period = static_cast<int>(found.states.size());
  orbit.duration = orbit.period * forcing_period(search.system, search.p);
  std::transform(found.states.begin(), found.states.end(), std::back_inserter(orbit.states), vector_of);
  orbit.impacts = orbit.isolated_impacts = found.impacts;  // the lanes leave sticking orbits to shoot()
  orbit.multipliers = multipliers_of_values({found.multipliers.begin(), found.multipliers.end()}, orbit.duration);
  return shot;
}
Shot shot_of(PeriodicOrbit found) {
  Shot shot;
  shot.converged = found.converged();
  if (!shot.converged) return shot;
  shot.holds = (found.stable() || found.neutral()) && found.admissible == Admissibility::admissible;
  if (found.multipliers.valid) shot.multiplier = found.multipliers.values.front();
  shot.orbit = StableOrbit(std::move(found));
  return shot;
}

/// Newton's method from a guess, as the slot carries its motions. It is not tried if the tangent along the guess grows by more
/// than most_growth.
MotionTask<Shot> shoot_from(TaskSlot& slot, const Search& search, const std::vector<Vector>& guess, double most_growth) {
  if (slot.in_lanes()) {
    LaneGuess from = guess_of(slot.parameters(), guess);
    const LanePatience patience{most_growth, quick_halvings};
    const LaneOrbit found = co_await shoot_in_lanes(slot, std::move(from.states), patience);
    co_return shot_of(search, found);
  }
  Shot shot;
  shot.given_up = std::isfinite(most_growth) && growth_along(slot.propagator(), guess) > most_growth;
  if (shot.given_up) co_return shot;
  ShootingOptions shooting;
  shooting.flow = slot.propagator().options();
  shooting.max_halvings = quick_halvings;
  if (is_forced(search.system)) {
    shot = shot_of(shoot(search.system, search.p, guess, static_cast<int>(guess.size()), shooting));
  } else {
    shot = shot_of(at_returns(search.system, shoot_returns(slot.propagator(), guess, shooting), guess.front()));
  }
  co_return shot;
}

/// Whether the orbit to which Newton's method converged may be the one on which the motion at `state` is settling. `delicate`:
/// the lanes leave it to the Propagator.
enum class Verdict { no, delicate, yes };

Verdict verdict(const Shot& shot, const Vector& state) {
  if (!shot.converged || !(nearest_distance(shot.orbit.states, state) < 2.0 * worth_trying * (1.0 + state_size(state))))
    return Verdict::no;
  if (shot.delicate) return Verdict::delicate;
  return shot.holds ? Verdict::yes : Verdict::no;
}

/// The states of a motion after 0, 1, ... `periods` periods; fewer if it ends.
MotionTask<std::vector<Vector>> next_states(TaskSlot& lane, const Vector& state, int periods) {
  std::vector<Vector> states{state};
  const CarriedPeriods carried = co_await lane.carry(state, static_cast<std::size_t>(std::max(0, periods)));
  Vector end(state.size());
  for (std::size_t k = 0; k < carried.size() && carried.termination(k) == Termination::time; ++k) {
    carried.state(k, end);
    states.push_back(end);
  }
  co_return states;
}

/// The orbit to which Newton's method converges from the states around a return, or from a guess next to a period doubling.
MotionTask<Shot> shoot_next_to_doubling(TaskSlot& slot, const Search& search, const std::vector<Vector>& around,
                                        double most_growth) {
  const auto in_front_of_barriers = [&](const std::vector<Vector>& guess) {
    return std::all_of(guess.begin(), guess.end(),
                       [&](const Vector& x) { return mode_at(search.system, 0.0, x, search.p).has_value(); });
  };
  Shot shot = co_await shoot_from(slot, search, around, most_growth);
  if (!shot.converged && !shot.given_up)
    if (const std::vector<Vector> half = between_halves(around, near_halves); !half.empty() && in_front_of_barriers(half))
      shot = co_await shoot_from(slot, search, half, growth_at_doubling);
  if (!shot.converged) co_return shot;
  const std::vector<Vector> single = shot.orbit.states;
  if (has_doubled(single.size(), shot.multiplier, around.size())) {
    const std::size_t three_times = 3 * single.size();
    const std::vector<Vector> motion = co_await next_states(slot, around.front(), static_cast<int>(three_times));
    if (motion.size() <= three_times) co_return shot;
    const std::vector<Vector> doubled = doubled_states(single, shot.multiplier.real(), motion);
    if (!doubled.empty() && in_front_of_barriers(doubled)) shot = co_await shoot_from(slot, search, doubled, most_growth);
  }
  co_return shot;
}

/// Whether the motion at `state` is settling on the orbit.
MotionTask<bool> approaches(TaskSlot& slot, const Shot& shot, const Vector& state) {
  if (shot.orbit.conservative) co_return is_on(shot.orbit.states, state);
  NearOrbit motion(shot.orbit.states, state, std::abs(shot.multiplier));
  const auto never = [] { return false; };
  co_await carry_watched(slot, motion, never);
  co_return motion.comes_closer();
}

/// The orbit near the states around a return. The verdict is yes if it is stable, and the motion through the states approaches it
/// and was not seen to pass it.
struct Recognised {
  Verdict verdict = Verdict::no;
  StableOrbit orbit = {};
};
MotionTask<Recognised> recognise(TaskSlot& slot, const Search& search, const std::vector<Vector>& around, double most_growth,
                                 RefusedOrbits& refused) {
  Shot shot = co_await shoot_next_to_doubling(slot, search, around, most_growth);
  Recognised found;
  found.verdict = verdict(shot, around.front());
  if (found.verdict != Verdict::yes) co_return found;
  if (refused.knows(shot.orbit.states, around.front())) {
    found.verdict = Verdict::no;
  } else if (!co_await approaches(slot, shot, around.front())) {
    refused.add(shot.orbit.states, around.front());
    found.verdict = Verdict::no;
  }
  found.orbit = std::move(shot.orbit);
  co_return found;
}

constexpr double any_growth = std::numeric_limits<double>::infinity();

/// The stable orbit near the states around a return, if the motion approaches it: as the slot carries its motions, in delicate
/// cases by a Propagator.
MotionTask<std::optional<StableOrbit>> orbit_around(TaskSlot& slot, const Search& search, const std::vector<Vector>& around,
                                                    RefusedOrbits& passed_by) {
  Recognised found = co_await recognise(slot, search, around, max_growth_of_return, passed_by);
  if (found.verdict == Verdict::delicate) {
    const OneByOne alone(slot, search.p);
    found = co_await recognise(slot, search, around, any_growth, passed_by);
  }
  if (found.verdict != Verdict::yes) co_return std::nullopt;
  co_return std::move(found.orbit);
}

MotionTask<OrbitSearchResult> look(TaskSlot& lane, const Search& search, const Vector& state, int max_period, double nearness,
                                   RefusedOrbits& passed_by) {
  OrbitSearchResult out;
  const std::vector<Vector> states = co_await next_states(lane, state, max_period);
  const std::vector<int> returns = returns_of(states, nearness, max_period);
  if (!returns.empty()) out.closest = returns.front();
  for (const int n : returns_to_try(returns)) {
    const std::vector<Vector> around(states.begin(), states.begin() + n);
    out.orbit = co_await orbit_around(lane, search, around, passed_by);
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

/// The stable orbit on which the motion at `state` is settling, by trying all its returns that may have settled. The slot's
/// motions are carried by a Propagator.
MotionTask<std::optional<StableOrbit>> orbit_of_any_return(TaskSlot& slot, const Search& search, const Vector& state,
                                                           int max_period, bool all_threads) {
  Propagator& propagator = slot.propagator();
  const double scale = 1.0 + state.lpNorm<Eigen::Infinity>();
  std::vector<Vector> states{state};
  std::vector<int> worth;  // periods of returns that have not been tried
  RefusedOrbits refused;   // several returns may lead to the same one
  std::size_t together = 1;
  // Chaos has many returns, most of them to unstable orbits. A return that Newton's method has rejected in lanes is not tried
  // again.
  const auto look = [&]() -> MotionTask<std::optional<StableOrbit>> {
    std::vector<std::vector<Vector>> guesses;
    for (const int n : worth) guesses.emplace_back(states.begin(), states.begin() + n);
    const std::vector<LaneOrbit> orbits =
        shoot_together(search.system, search.p, guesses, {.max_halvings = quick_halvings}, propagator.options(), all_threads);
    const auto can_be_skipped = [&](const Shot& shot, const std::vector<Vector>& around) {
      if (!shot.converged) return between_halves(around, near_halves).empty();
      if (has_doubled(shot.orbit.states.size(), shot.multiplier, around.size())) return false;
      return verdict(shot, state) == Verdict::no || refused.knows(shot.orbit.states, state);
    };
    for (std::size_t i = 0; i < guesses.size(); ++i) {
      if (!orbits.empty() && can_be_skipped(shot_of(search, orbits[i]), guesses[i])) continue;
      Recognised found = co_await recognise(slot, search, guesses[i], any_growth, refused);
      if (found.verdict == Verdict::yes) co_return std::move(found.orbit);
    }
    worth.clear();
    together *= 2;
    co_return std::nullopt;
  };
  Transition transition;
  Matrix growth = Matrix::Identity(state.size(), state.size());
  std::vector<double> distances;  // of the returns
  // Whether the tangent has shrunk over one of the returns. Until then the other returns wait for the test of long-term growth.
  bool shrinks = false;
  for (int n = 1; n <= max_period || (!worth.empty() && n <= growth_test_periods); ++n) {
    carry_period(propagator, states.back(), {.sensitivity = Sensitivity::state}, transition);
    if (transition.termination != Termination::time) break;
    const Vector next = transition.x1;
    growth = period_map(transition) * growth;
    distances.push_back(state_distance(next, state) / scale);
    if (n <= max_period && distances.back() < worth_trying && closer_than_divisors(distances)) {
      const double grown = spectral_radius(growth);
      if (!(grown > max_growth)) worth.push_back(n);
      shrinks = shrinks || grown < 1.0;
    }
    if (shrinks && worth.size() >= together)
      if (auto orbit = co_await look()) co_return orbit;
    states.push_back(next);
  }
  if (spectral_radius(growth) > max_growth) co_return std::nullopt;
  co_return co_await look();
}

}  // namespace

MotionTask<std::optional<StableOrbit>> orbit_approached_in_lanes(TaskSlot& lane, const HybridSystem& system, const Vector& p,
                                                                 const LaneOrbit& orbit, const Vector& state) {
  const Search search{system, p};
  Shot shot = shot_of(search, orbit);
  if (verdict(shot, state) != Verdict::yes) co_return std::nullopt;
  if (!co_await approaches(lane, shot, state)) co_return std::nullopt;
  co_return std::move(shot.orbit);
}

MotionTask<int> closest_return(TaskSlot& lane, const Vector& state, int max_period, double nearness) {
  const std::vector<Vector> states = co_await next_states(lane, state, max_period);
  const std::vector<int> returns = returns_of(states, nearness, max_period);
  co_return returns.empty() ? 0 : returns.front();
}

MotionTask<OrbitSearchResult> look_for_orbit(TaskSlot& lane, const HybridSystem& system, const Vector& p, const Vector& state,
                                             OrbitSearch search) {
  OrbitSearchResult out;
  const Search problem{system, p};
  if (may_rest(system, p, state)) {
    const OneByOne alone(lane, p);
    if (std::optional<PeriodicOrbit> rest = resting_orbit(lane.propagator(), state)) {
      out.orbit = StableOrbit(std::move(*rest));
      co_return out;
    }
  }
  if (!(search.nearness > 0.0)) {
    const OneByOne alone(lane, p);
    out.orbit = co_await orbit_of_any_return(lane, problem, state, search.max_period, search.all_threads);
    co_return out;
  }
  RefusedOrbits here;
  out = co_await look(lane, problem, state, search.max_period, search.nearness, search.refused ? *search.refused : here);
  co_return out;
}

std::optional<StableOrbit> settling_orbit(const HybridSystem& system, const Vector& p, const Vector& state, int max_period,
                                          const FlowOptions& flow) {
  OrbitSearchResult found;
  run_alone(system, flow, [&](TaskSlot& lane) -> MotionTask<> {
    lane.set_parameters(p);
    const OrbitSearch search{.max_period = max_period};
    found = co_await look_for_orbit(lane, system, p, state, search);
  });
  return found.orbit;
}

namespace {

/// Whether the motion carries on for growth_test_periods and its tangent has not grown by more than max_growth by then.
MotionTask<> keeps_small_tangent(TaskSlot& lane, const Vector& p, const Vector& state, char& answer) {
  constexpr int stretch = growth_test_periods / 4;
  lane.set_parameters(p);
  answer = false;
  Vector at = state;
  Matrix growth = Matrix::Identity(at.size(), at.size());
  for (int carried = stretch; carried <= growth_test_periods; carried += stretch) {
    const CarriedPeriods periods = co_await lane.carry_with_tangent(at, stretch);
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
            [&](std::size_t i, TaskSlot& lane) { return keeps_small_tangent(lane, p, states[i], kept[i]); });
  std::vector<Vector> out;
  for (std::size_t i = 0; i < states.size(); ++i)
    if (kept[i]) out.push_back(states[i]);
  return out;
}

}  // namespace graze
