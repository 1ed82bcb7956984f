// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/defining_equations.hpp>
#include <graze/continuation/conditions/grazing_by_events.hpp>
#include <graze/continuation/problems/clear_section.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

/// The equations of an orbit whose event k has speed zero, in the coordinates of the events. They are for solve() with the
/// problem that they are made for.
class ZeroSpeed : public DefiningEquations {
 public:
  ZeroSpeed(SignatureProblem& problem, int k) : problem_(problem), k_(k) {}

  bool evaluate(BranchProblem&, const Vector& u, Vector& F, Matrix* jacobian) override {
    Vector H;
    Matrix H_u;
    if (!problem_.zero_problem().evaluate(u, H, &H_u)) return false;
    F.resize(H.size() + 1);
    F << H, problem_.speed(u, k_);
    if (!jacobian) return true;
    jacobian->resize(F.size(), u.size());
    *jacobian << H_u, problem_.speed_gradient(u, k_).transpose();
    sizes_ = Vector::Constant(F.size(), 1.0 + problem_.largest_change(u));
    return true;
  }

  Vector sizes() const override { return sizes_; }
  NewtonRule rule() const override {
    NewtonRule rule = newton_to_rounding();
    rule.longest = 0.1;
    return rule;
  }

 private:
  SignatureProblem& problem_;
  int k_;
  Vector sizes_;
};

/// Moves u to the solution at which event k has speed zero. False if that fails.
bool to_zero_speed(SignatureProblem& problem, Vector& u, int k) {
  ZeroSpeed equations(problem, k);
  DefinedPoint at = solve(problem, equations, u);
  u = std::move(at.w);
  return at.newton.converged();
}

/// A touch of a guard.
struct TouchTime {
  std::size_t event;  ///< index in HybridSystem::events; its guard is touched
  double time;        ///< from phase 0 of the orbit
};

/// The events of u with speed zero, event k first.
std::vector<TouchTime> touching_with(SignatureProblem& problem, const Vector& u, int k) {
  constexpr double touching = 1e-9;  // rounding of a speed, amplified by the orbit's other impacts
  const std::vector<std::size_t>& sequence = problem.equations().sequence();
  std::vector<TouchTime> list{{sequence[static_cast<std::size_t>(k)], problem.event_time(u, k)}};
  for (int other = 0; other < problem.equations().events(); ++other)
    if (other != k && std::abs(problem.speed(u, other)) < touching)
      list.push_back({sequence[static_cast<std::size_t>(other)], problem.event_time(u, other)});
  return list;
}

/// Adds the other near touches of the motion u: free maxima close to a guard. Rounding may have turned some into weak contacts.
void add_others(SignatureProblem& problem, const Vector& u, std::vector<TouchTime>& list) {
  constexpr double touching = 1e-6;  // u is next to the grazing; to leave out a maximum that does not touch does no harm
  Vector v;
  OrbitProblem& states = problem.stroboscopic(u, v);
  const ShootingEquations& equations = states.equations();
  const Vector shortened = states.orbit_part(v);
  const double duration = equations.duration(shortened), same = 0.01 * duration / equations.period();
  std::vector<GrazingGuess> found = near_misses(states, v, touching);
  for (const GrazingGuess& contact : weakest_contacts(states, v, problem.equations().events() + 8))
    if (contact.speed * contact.speed < 1e-2 * touching) found.push_back(contact);
  for (const GrazingGuess& guess : found) {
    const double time = equations.orbit_time(shortened, guess.stretch) + guess.t - equations.node_time(shortened, guess.stretch);
    const auto known = [&](const TouchTime& touch) {
      return touch.event == guess.event && std::abs(std::remainder(touch.time - time, duration)) < same;
    };
    if (std::none_of(list.begin(), list.end(), known)) list.push_back({guess.event, time});
  }
}

/// The touch of u as a guess for the equations `states` in states at fixed phases, in which v is the same orbit.
GrazingGuess guess_of(SignatureProblem& problem, const Vector& u, const TouchTime& touch, OrbitProblem& states, const Vector& v) {
  const SignatureEquations& equations = problem.equations();
  const double duration = equations.duration(), length = duration / states.nodes();
  const double section = states.equations().section_phase() * duration / equations.period();
  const auto since_section = [&](double time) {
    const double t = std::fmod(time - section, duration);
    return t < 0.0 ? t + duration : t;
  };
  const double here = since_section(touch.time);
  GrazingGuess guess;
  guess.event = touch.event;
  guess.stretch = std::min(static_cast<int>(here / length), states.nodes() - 1);
  double next = (guess.stretch + 1) * length;
  for (int other = 0; other < equations.events(); ++other) {
    const double t = since_section(equations.time(u, other));
    if (t < here && t >= guess.stretch * length) ++guess.events_before;
    if (t > here) next = std::min(next, t);
  }
  const Vector shortened = states.orbit_part(v);
  guess.t = states.equations().node_time(shortened, guess.stretch) + here - guess.stretch * length;
  guess.t_resume = guess.t + std::min(0.5 * (next - here), 0.05 * length);
  return guess;
}

/// The orbit at u in states at fixed phases, with at most one touch on each stretch between nodes. nullopt if 1, 2, 4 or 8
/// nodes per forcing period do not separate the touches.
std::optional<OrbitProblem> with_separate_touches(SignatureProblem& problem, const Vector& u,
                                                  const std::vector<TouchTime>& touches, Vector& out) {
  const SignatureEquations& equations = problem.equations();
  const double T = equations.duration() / equations.period();
  for (const int per_period : {1, 2, 4, 8}) {
    const double length = T / per_period;
    std::vector<double> places;
    const auto add = [&](double time) { places.push_back(time / length - std::floor(time / length)); };
    for (int k = 0; k < equations.events(); ++k) add(equations.time(u, k));
    for (const TouchTime& touch : touches) add(touch.time);
    std::sort(places.begin(), places.end());
    const double section = std::fmod(widest_gap(places).middle, 1.0) / per_period;
    std::vector<double> stretches;
    for (const TouchTime& touch : touches) {
      const double count = per_period * equations.period();
      const double stretch = std::floor((touch.time - section * T) / length);
      stretches.push_back(stretch - count * std::floor(stretch / count));
    }
    std::sort(stretches.begin(), stretches.end());
    if (std::adjacent_find(stretches.begin(), stretches.end()) == stretches.end())
      return problem.in_states(u, per_period, section, out);
  }
  return std::nullopt;
}

}  // namespace

std::optional<LocatedGrazing> grazing_near(OrbitProblem& problem, const Vector& u, const GrazingGuess& guess,
                                           const std::vector<GrazingGuess>& together, const std::vector<GrazingGuess>& missed) {
  constexpr double near = 0.02;
  LocatedGrazing located = locate_grazing(problem, u, guess, together, missed);
  if (!located.confirmed) return std::nullopt;
  if (weighted_norm(problem.zero_problem().weights, located.u - u) > near) return std::nullopt;
  return located;
}

std::optional<LocatedGrazing> grazing_beside(OrbitProblem& problem, const Vector& u) {
  // Of the contacts and of the free maxima each; the weakest contact need not be the nearest grazing.
  constexpr std::size_t considered = 4;
  constexpr double same_value = 1e-9;
  const bool hard_contacts = has_hard_contacts(problem.system());
  std::vector<GrazingGuess> guesses = near_misses(problem, u, std::numeric_limits<double>::infinity());
  guesses.resize(std::min(guesses.size(), considered));
  for (const GrazingGuess& guess : weakest_contacts(problem, u, static_cast<int>(considered))) guesses.push_back(guess);
  std::optional<LocatedGrazing> nearest;
  double distance = std::numeric_limits<double>::infinity();
  for (const GrazingGuess& guess : guesses) {
    std::optional<LocatedGrazing> located = grazing_near(problem, u, guess);
    if (!located || (!hard_contacts && located->scenario == GrazingScenario::smooth)) continue;
    const double away = weighted_norm(problem.zero_problem().weights, located->u - u);
    // The same touch may be found twice: with its contact left out, with a contact that the free motion still makes, or from
    // behind, as a stop that has let go and is nearly left. The result with fewer impacts is kept, and then the contact's own.
    const auto rank = [&](const LocatedGrazing& found) {
      return std::pair(found.orbit.impacts, !begins_contact(problem.system()->events[found.event].kind));
    };
    const bool same = nearest && std::abs(problem.value(located->u) - problem.value(nearest->u)) <
                                     same_value * problem.size_of_value(problem.value(located->u));
    if (same ? rank(*located) >= rank(*nearest) : !(away < distance)) continue;
    distance = away;
    nearest = std::move(located);
  }
  return nearest;
}

namespace {

/// A solution with a touch, which is an event of speed zero.
struct Touching {
  std::optional<SignatureProblem> longer;  ///< equations with the touch as an added event, if the branch does not have it
  Vector at;                               ///< the solution in the coordinates of `longer`, or else of the branch
  Vector u;                                ///< the solution in the coordinates of the branch
  int event = 0;                           ///< number of the touch among the events of `at`
};

/// The solution near u at which event k of the branch has speed zero. Empty if it is farther away than `reach`.
std::optional<Touching> without_speed(SignatureProblem& problem, const Vector& u, int k, double reach) {
  Touching out{{}, u, {}, k};
  if (!to_zero_speed(problem, out.at, k)) return std::nullopt;
  if (weighted_norm(problem.zero_problem().weights, out.at - u) > reach) return std::nullopt;
  out.u = out.at;
  return out;
}

/// The solution near u with an added event of speed zero, for the free maximum that has met a guard (`met`). Empty if it is
/// farther away than `reach`.
std::optional<Touching> with_touch(SignatureProblem& problem, const Vector& u, const EventRecord& met, double reach) {
  const SignatureEquations& equations = problem.equations();
  EventNodes nodes = problem.unpack(u);
  const auto place = static_cast<Eigen::Index>(nodes.insert(met.event, met.t, met.x_minus));
  Touching out{SignatureProblem(problem.system(), equations.parameters(), equations.period(), nodes.sequence, problem.free(),
                                problem.flow_options()),
               {},
               {},
               static_cast<int>(place)};
  out.at = out.longer->pack(nodes, problem.value(u));
  out.longer->pin_as(problem, out.at);
  if (!to_zero_speed(*out.longer, out.at, out.event)) return std::nullopt;
  const Eigen::Index size = equations.states() + 1, rest = out.at.size() - (place + 1) * size;
  out.u.resize(u.size());
  out.u << out.at.head(place * size), out.at.tail(rest);
  if (weighted_norm(problem.zero_problem().weights, out.u - u) > reach) return std::nullopt;
  return out;
}

/// Whether the defining equations have this grazing, and not a neighbouring one: the parameter values agree.
bool agrees(const OrbitProblem& states, const LocatedGrazing& located, const Touching& touching) {
  constexpr double same = 1e-9;
  const double value = states.value(touching.at);
  return std::abs(states.value(located.u) - value) < same * states.size_of_value(value) + 10.0 * located.precision;
}

/// The grazing at `touching`, located by its defining equations. Empty if they do not confirm it.
std::optional<LocatedGrazing> located_at(SignatureProblem& problem, const Vector& u, Touching& touching) {
  SignatureProblem& with = touching.longer ? *touching.longer : problem;
  std::vector<TouchTime> touches = touching_with(with, touching.at, touching.event);
  const auto struck = static_cast<std::ptrdiff_t>(touches.size());
  Vector v;
  std::optional<LocatedGrazing> alone;
  if (struck == 1) {
    OrbitProblem& states = with.stroboscopic(touching.at, v);
    alone = grazing_near(states, v, guess_of(with, touching.at, touches.front(), states, v));
    if (alone && !agrees(states, *alone, touching)) alone.reset();
    // If the orbit closes after a divisor of its period, another turn has the same touch, which may be met as an impact.
    const int others = impacts(with.equations().system(), {0, with.equations().sequence()}) - 1;
    if (alone && !alone->others_vague && alone->orbit.impacts == others) return alone;
  }
  add_others(problem, u, touches);
  std::optional<OrbitProblem> states = with_separate_touches(with, touching.at, touches, v);
  if (!states) return alone;
  std::vector<GrazingGuess> guesses;
  for (const TouchTime& touch : touches) guesses.push_back(guess_of(with, touching.at, touch, *states, v));
  std::optional<LocatedGrazing> located = grazing_near(
      *states, v, guesses.front(), {guesses.begin() + 1, guesses.begin() + struck}, {guesses.begin() + struck, guesses.end()});
  return located && agrees(*states, *located, touching) ? located : alone;
}

}  // namespace

std::optional<GrazingAhead> grazing_ahead(SignatureProblem& problem, const Vector& u, const SignatureEquations::Violation& beyond,
                                          double reach) {
  const SignatureEquations& equations = problem.equations();
  const auto found = [&](std::optional<Touching> touching, bool lost) -> std::optional<GrazingAhead> {
    if (!touching) return std::nullopt;
    std::optional<LocatedGrazing> located = located_at(problem, u, *touching);
    if (!located) return std::nullopt;
    return GrazingAhead{std::move(*located), lost, std::move(touching->u)};
  };
  // A lost impact can look like a gained one, because its arc beyond the barrier is met before the event. Weak impacts are
  // therefore tried first, beginning with the weakest.
  constexpr double weak = 1e-3;
  std::vector<std::pair<double, int>> slow;
  for (int k = 0; k < equations.events(); ++k) {
    const double speed = problem.speed(u, k);
    if (speed < weak || (beyond.lost && k == beyond.event)) slow.emplace_back(speed, k);
  }
  std::sort(slow.begin(), slow.end());
  for (const auto& [speed, k] : slow) {
    const Event& contact = equations.system().events[equations.sequence()[static_cast<std::size_t>(k)]];
    if (contact.to != contact.from) continue;
    if (auto ahead = found(without_speed(problem, u, k, reach), true)) return ahead;
  }
  if (beyond.lost || !beyond.met) return std::nullopt;
  const Event& contact = equations.system().events[beyond.met->event];
  if (contact.to == contact.from) return found(with_touch(problem, u, *beyond.met, reach), false);
  // A contact that leads to another mode cannot be added as an event of this signature.
  Vector v;
  OrbitProblem& states = problem.stroboscopic(u, v);
  std::optional<LocatedGrazing> located = grazing_beside(states, v);
  const bool right_there = located && weighted_norm(states.zero_problem().weights, located->u - v) <= reach;
  if (!right_there) return std::nullopt;
  // If the events of a weak contact of the branch coincide, the contact is met early and looks gained. It is lost.
  const bool lost = located->orbit.impacts < impacts(equations.system(), {0, equations.sequence()});
  return GrazingAhead{std::move(*located), lost, u};
}

}  // namespace graze
