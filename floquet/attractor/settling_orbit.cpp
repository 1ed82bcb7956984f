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
template <class State> class NearOrbit {
 public:
  NearOrbit(const std::vector<State>& orbit, const Vector& x, double slowest)
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
  const std::vector<State>& orbit_;
  Vector at_;
  DistanceWatch watch_;
  int periods_ = 0;
};

/// A motion of a conservative system approaches no orbit: it is on the orbit, up to rounding, or it is not.
bool is_on(const PeriodicOrbit& orbit, const Vector& x) {
  return nearest_distance(orbit.states, x) < DistanceWatch::rounding_distance * (1.0 + state_size(x));
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

/// Whether the orbit to which Newton's method converged may be the one on which the motion at `state` is settling. `delicate`:
/// the lanes leave it to the Propagator.
enum class Verdict { no, delicate, yes };

template <class Orbit> bool is_near(const Orbit& orbit, const Vector& state) {
  return nearest_distance(orbit.states, state) < 2.0 * worth_trying * (1.0 + state_size(state));
}
Verdict verdict(const LaneOrbit& orbit, const Vector& state) {
  if (!orbit.converged || !is_near(orbit, state)) return Verdict::no;
  if (orbit.delicate) return Verdict::delicate;
  return orbit.stable() ? Verdict::yes : Verdict::no;
}
Verdict verdict(const PeriodicOrbit& orbit, const Vector& state) {
  const bool holds = orbit.converged() && (orbit.stable() || orbit.neutral()) && orbit.admissible == Admissibility::admissible;
  return holds && is_near(orbit, state) ? Verdict::yes : Verdict::no;
}

std::vector<Vector> vectors_of(const std::vector<StatePair>& pairs) {
  std::vector<Vector> states;
  std::transform(pairs.begin(), pairs.end(), std::back_inserter(states), vector_of);
  return states;
}

StableOrbit stable_orbit(const HybridSystem& system, const Vector& p, const LaneOrbit& found) {
  StableOrbit orbit;
  orbit.period = static_cast<int>(found.states.size());
  orbit.duration = orbit.period * forcing_period(system, p);
  orbit.states = vectors_of(found.states);
  orbit.impacts = orbit.isolated_impacts = found.impacts;  // the lanes leave sticking orbits to shoot()
  orbit.multipliers = multipliers_of_values({found.multipliers.begin(), found.multipliers.end()}, orbit.duration);
  return orbit;
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

const auto never = [] { return false; };

/// Newton's method and motions by a Propagator, for recognition. Its tasks never wait.
class ByPropagator {
 public:
  using Orbit = PeriodicOrbit;

  explicit ByPropagator(Propagator& propagator) : propagator_(propagator) {
    shooting_.flow = propagator.options();
    shooting_.max_halvings = quick_halvings;
  }
  const HybridSystem& system() const { return propagator_.system(); }
  const Vector& parameters() const { return propagator_.parameters(); }

  /// Result of Newton's method from a guess. It is not tried if the tangent along the guess grows by more than most_growth.
  struct Attempt {
    Orbit orbit;
    bool given_up = false;
    bool converged() const { return orbit.converged(); }
    std::vector<Vector> states() const { return orbit.states; }
    /// Of the first multiplier; NaN if it is unknown.
    std::complex<double> multiplier() const {
      return orbit.multipliers.valid ? orbit.multipliers.values.front() : std::numeric_limits<double>::quiet_NaN();
    }
  };
  MotionTask<Attempt> shoot_from(const std::vector<Vector>& guess, double most_growth) {
    Attempt attempt;
    attempt.given_up = std::isfinite(most_growth) && growth_along(propagator_, guess) > most_growth;
    if (attempt.given_up) co_return attempt;
    if (is_forced(system()))
      attempt.orbit = shoot(system(), parameters(), guess, static_cast<int>(guess.size()), shooting_);
    else
      attempt.orbit = at_returns(system(), shoot_returns(propagator_, guess, shooting_), guess.front());
    co_return attempt;
  }
  MotionTask<std::vector<Vector>> motion(const Vector& state, int periods) {
    co_return stroboscopic_states(propagator_, state, static_cast<std::size_t>(periods) + 1);
  }
  template <class Watch> MotionTask<bool> carry(Watch& watch) { co_return carry_watched(propagator_, watch, never); }

 private:
  Propagator& propagator_;
  ShootingOptions shooting_;
};

/// The same in lanes, at the parameters p of the slot.
class InLanes {
 public:
  using Orbit = LaneOrbit;

  InLanes(TaskSlot& lane, const HybridSystem& system, const Vector& p) : lane_(lane), system_(system), p_(p) {}
  const HybridSystem& system() const { return system_; }
  const Vector& parameters() const { return p_; }

  struct Attempt {
    Orbit orbit;
    bool given_up = false;
    bool converged() const { return orbit.converged; }
    std::vector<Vector> states() const { return vectors_of(orbit.states); }
    std::complex<double> multiplier() const { return orbit.multipliers[0]; }
  };
  MotionTask<Attempt> shoot_from(const std::vector<Vector>& guess, double most_growth) {
    LaneGuess from = guess_of(lane_.parameters(), guess);
    const LanePatience patience{most_growth, quick_halvings};
    Attempt attempt;
    attempt.orbit = co_await shoot_in_lanes(lane_, std::move(from.states), patience);
    attempt.given_up = attempt.orbit.given_up;
    co_return attempt;
  }
  MotionTask<std::vector<Vector>> motion(const Vector& state, int periods) { return next_states(lane_, state, periods); }
  template <class Watch> MotionTask<bool> carry(Watch& watch) { return carry_watched(lane_, watch, never); }

 private:
  TaskSlot& lane_;
  const HybridSystem& system_;
  const Vector& p_;
};

/// The orbit to which Newton's method converges from the states around a return, or from a guess next to a period doubling.
template <class Carrier>
MotionTask<typename Carrier::Orbit> shoot_next_to_doubling(Carrier& carrier, const std::vector<Vector>& around,
                                                           double most_growth) {
  const auto in_front_of_barriers = [&](const std::vector<Vector>& guess) {
    return std::all_of(guess.begin(), guess.end(),
                       [&](const Vector& x) { return mode_at(carrier.system(), 0.0, x, carrier.parameters()).has_value(); });
  };
  typename Carrier::Attempt attempt = co_await carrier.shoot_from(around, most_growth);
  if (!attempt.converged() && !attempt.given_up)
    if (const std::vector<Vector> half = between_halves(around, near_halves); !half.empty() && in_front_of_barriers(half))
      attempt = co_await carrier.shoot_from(half, growth_at_doubling);
  if (!attempt.converged()) co_return std::move(attempt.orbit);
  const std::complex<double> mu = attempt.multiplier();
  if (has_doubled(attempt.orbit.states.size(), mu, around.size())) {
    const std::vector<Vector> single = attempt.states();
    const std::size_t three_times = 3 * single.size();
    const std::vector<Vector> motion = co_await carrier.motion(around.front(), static_cast<int>(three_times));
    if (motion.size() <= three_times) co_return std::move(attempt.orbit);
    const std::vector<Vector> doubled = doubled_states(single, mu.real(), motion);
    if (!doubled.empty() && in_front_of_barriers(doubled)) attempt = co_await carrier.shoot_from(doubled, most_growth);
  }
  co_return std::move(attempt.orbit);
}

/// Whether the motion at `state` is settling on a stable orbit with these states, whose slowest multiplier has this modulus.
template <class Carrier, class State>
MotionTask<bool> approaches(Carrier& carrier, const std::vector<State>& orbit, double slowest, const Vector& state) {
  NearOrbit motion(orbit, state, slowest);
  co_await carrier.carry(motion);
  co_return motion.comes_closer();
}
MotionTask<bool> approaches(InLanes& carrier, const LaneOrbit& orbit, const Vector& state) {
  return approaches(carrier, orbit.states, std::abs(orbit.multipliers.front()), state);
}
MotionTask<bool> approaches(ByPropagator& carrier, const PeriodicOrbit& orbit, const Vector& state) {
  if (orbit.conservative) co_return is_on(orbit, state);
  co_return co_await approaches(carrier, orbit.states, std::abs(orbit.multipliers.values.front()), state);
}

/// The orbit near the states around a return. The verdict is yes if it is stable, and the motion through the states approaches it
/// and was not seen to pass it.
template <class Orbit> struct Recognised {
  Verdict verdict = Verdict::no;
  Orbit orbit;
};
template <class Carrier>
MotionTask<Recognised<typename Carrier::Orbit>> recognise(Carrier& carrier, const std::vector<Vector>& around, double most_growth,
                                                          RefusedOrbits& refused) {
  Recognised<typename Carrier::Orbit> found;
  found.orbit = co_await shoot_next_to_doubling(carrier, around, most_growth);
  found.verdict = verdict(found.orbit, around.front());
  if (found.verdict != Verdict::yes) co_return found;
  if (refused.knows(found.orbit.states, around.front())) {
    found.verdict = Verdict::no;
  } else if (!co_await approaches(carrier, found.orbit, around.front())) {
    refused.add(found.orbit.states, around.front());
    found.verdict = Verdict::no;
  }
  co_return found;
}
/// The same by a Propagator; empty unless the verdict is yes.
MotionTask<std::optional<StableOrbit>> recognise_by(Propagator& propagator, const std::vector<Vector>& around, double most_growth,
                                                    RefusedOrbits& refused) {
  ByPropagator carrier(propagator);
  Recognised<PeriodicOrbit> found = co_await recognise(carrier, around, most_growth, refused);
  if (found.verdict != Verdict::yes) co_return std::nullopt;
  co_return StableOrbit(std::move(found.orbit));
}

constexpr double any_growth = std::numeric_limits<double>::infinity();

/// The problem in which an orbit is sought among the closest returns, and the orbits that the motion was seen to pass.
struct Search {
  const HybridSystem& system;
  const Vector& p;
  const Vector& state;
  RefusedOrbits& passed_by;
};

/// The stable orbit near the states around a return, if the motion approaches it: by Newton's method in lanes, which leaves
/// delicate cases to the Propagator, or by the slot's Propagator.
MotionTask<std::optional<StableOrbit>> orbit_around(TaskSlot& lane, const Search& search, const std::vector<Vector>& around) {
  if (!lane.in_lanes()) co_return co_await recognise_by(lane.propagator(), around, max_growth_of_return, search.passed_by);
  InLanes carrier(lane, search.system, search.p);
  Recognised<LaneOrbit> found = co_await recognise(carrier, around, max_growth_of_return, search.passed_by);
  if (found.verdict == Verdict::yes) co_return stable_orbit(search.system, search.p, found.orbit);
  if (found.verdict == Verdict::no) co_return std::nullopt;
  Propagator propagator(search.system, search.p, {}, lane.motions().options());
  co_return co_await recognise_by(propagator, around, any_growth, search.passed_by);
}

MotionTask<OrbitSearchResult> look(TaskSlot& lane, const Search& search, int max_period, double nearness) {
  OrbitSearchResult out;
  const std::vector<Vector> states = co_await next_states(lane, search.state, max_period);
  const std::vector<int> returns = returns_of(states, nearness, max_period);
  if (!returns.empty()) out.closest = returns.front();
  for (const int n : returns_to_try(returns)) {
    const std::vector<Vector> around(states.begin(), states.begin() + n);
    out.orbit = co_await orbit_around(lane, search, around);
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

/// The stable orbit on which the motion at `state` is settling, by trying all its returns that may have settled.
MotionTask<std::optional<StableOrbit>> orbit_of_any_return(Propagator& propagator, const Vector& state, int max_period,
                                                           bool all_threads) {
  const HybridSystem& system = propagator.system();
  const Vector& p = propagator.parameters();
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
        shoot_together(system, p, guesses, {.max_halvings = quick_halvings}, propagator.options(), all_threads);
    const auto can_be_skipped = [&](const LaneOrbit& orbit, const std::vector<Vector>& around) {
      if (!orbit.converged) return between_halves(around, near_halves).empty();
      if (has_doubled(orbit.states.size(), orbit.multipliers[0], around.size())) return false;
      return verdict(orbit, state) == Verdict::no || refused.knows(orbit.states, state);
    };
    for (std::size_t i = 0; i < guesses.size(); ++i) {
      if (!orbits.empty() && can_be_skipped(orbits[i], guesses[i])) continue;
      if (auto orbit = co_await recognise_by(propagator, guesses[i], any_growth, refused)) co_return orbit;
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
  if (verdict(orbit, state) != Verdict::yes) co_return std::nullopt;
  InLanes carrier(lane, system, p);
  if (!co_await approaches(carrier, orbit, state)) co_return std::nullopt;
  co_return stable_orbit(system, p, orbit);
}

MotionTask<int> closest_return(TaskSlot& lane, const Vector& state, int max_period, double nearness) {
  const std::vector<Vector> states = co_await next_states(lane, state, max_period);
  const std::vector<int> returns = returns_of(states, nearness, max_period);
  co_return returns.empty() ? 0 : returns.front();
}

MotionTask<OrbitSearchResult> look_for_orbit(TaskSlot& lane, const HybridSystem& system, const Vector& p, const Vector& state,
                                             OrbitSearch search) {
  OrbitSearchResult out;
  std::unique_ptr<Propagator> own;
  const auto propagator = [&]() -> Propagator& {
    if (!lane.in_lanes()) return lane.propagator();
    if (!own) own = std::make_unique<Propagator>(system, p, std::vector<std::size_t>{}, lane.motions().options());
    return *own;
  };
  if (may_rest(system, p, state)) {
    if (std::optional<PeriodicOrbit> rest = resting_orbit(propagator(), state)) {
      out.orbit = StableOrbit(std::move(*rest));
      co_return out;
    }
  }
  if (!(search.nearness > 0.0)) {
    out.orbit = co_await orbit_of_any_return(propagator(), state, search.max_period, search.all_threads);
    co_return out;
  }
  RefusedOrbits here;
  const Search among{system, p, state, search.refused ? *search.refused : here};
  out = co_await look(lane, among, search.max_period, search.nearness);
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
