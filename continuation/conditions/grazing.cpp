// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/grazing.hpp>
#include <graze/lib/numerics/decompositions.hpp>
#include <graze/lib/numerics/orbit_lu.hpp>
#include <graze/lib/system/guard_rounding.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

/// Effect of a weak contact that is more than one reset, from simulating it: the contact leads to another mode and back, or
/// another event coincides with the touch.
struct Passage {
  bool comes_back = false;          ///< the motion returns to the mode of the free motion
  std::vector<std::size_t> events;  ///< events of the contact, in order
  Vector kick;                      ///< change of state per unit of speed
};

/// Whether another event of the mode coincides with the touch. (Friction reverses when the speed vanishes.)
bool comes_with_event(OrbitProblem& problem, std::size_t contact, const Touch& touch) {
  constexpr double same = 1e-6;  // accuracy to which the touch is known
  const HybridSystem& system = problem.system();
  const Vector p = problem.equations().parameters();
  Vector f(touch.x.size());
  system.modes[touch.mode].field(touch.t, touch.x, p, f);
  return std::any_of(system.events.begin(), system.events.end(), [&](const Event& other) {
    if (other.from != touch.mode || &other == &system.events[contact]) return false;
    const double h = other.guard.value(touch.t, touch.x, p), rate = transversality(other.guard, touch.t, touch.x, f, p);
    return std::abs(h) < same * (1.0 + touch.x.lpNorm<Eigen::Infinity>()) && rate > std::sqrt(same);
  });
}

/// Whether `fired` is the event itself, or replaces it on a part of its guard (Event::otherwise).
bool is_or_replaces(const HybridSystem& system, std::size_t fired, std::size_t event) {
  while (event != fired && system.events[event].otherwise) event = system.events[event].otherwise->event;
  return event == fired;
}

/// Simulates two motions until they are in the same mode: the free motion from the touch, and a motion that hits the guard with
/// `speed`. The second starts on the guard, at the time before the touch at which the guard function of the free motion grows
/// at this speed.
Passage passage_with(OrbitProblem& problem, std::size_t contact, const Touch& touch, const GuardAndRate& at, double curvature,
                     double speed) {
  constexpr double longest = 1e3;          // in units of the time in which the free motion loses `speed`
  constexpr std::size_t most_events = 64;  // enough for a short chatter
  Propagator& propagator = problem.equations().propagator();
  const double ahead = speed / -curvature;
  Vector f(touch.x.size());
  propagator.field(touch.mode, touch.t, touch.x, f);
  const Guard& guard = problem.system()->events[contact].guard;
  // Moves x along the guard's gradient to the level h. The free motion starts just below the guard: far enough not to meet it,
  // and near enough not to change the difference of the two motions.
  const auto to_guard = [&](double t, const Vector& x, double h) {
    const double here = guard.value(t, x, problem.equations().parameters());
    return Vector(x + (h - here) / at.h_dx.squaredNorm() * at.h_dx);
  };
  const double width = guard_width(guard_scale(guard, touch.t, touch.x, problem.equations().parameters()), touch.t, touch.x);
  HybridState free{touch.t, to_guard(touch.t, touch.x, -10.0 * width), touch.mode};
  HybridState struck{touch.t - ahead, to_guard(touch.t - ahead, touch.x - ahead * f, 0.0), touch.mode};
  Passage out;
  // The events that coincide with the touch, and the product of their saltation matrices.
  std::vector<std::size_t> of_touch;
  Matrix with_touch = Matrix::Identity(f.size(), f.size());
  const auto carry_on = [&](HybridState& state, double t, bool is_struck) {
    for (StepEnd end = StepEnd::event; end == StepEnd::event;) {
      end = propagator.step(state, t, is_struck ? Sensitivity::none : Sensitivity::state);
      if (end == StepEnd::failed || out.events.size() > most_events) return false;
      if (end == StepEnd::event && is_struck) out.events.push_back(propagator.record().event);
      if (end != StepEnd::event || is_struck) continue;
      of_touch.push_back(propagator.record().event);
      with_touch = propagator.record().saltation.S * with_touch;
    }
    return true;
  };
  for (double later = ahead; later < longest * ahead && !out.comes_back; later *= 2.0) {
    if (!carry_on(struck, touch.t + later, true) || !carry_on(free, touch.t + later, false)) return out;
    out.comes_back =
        struck.mode == free.mode && !out.events.empty() && is_or_replaces(problem.system(), out.events.front(), contact);
  }
  for (auto event = of_touch.rbegin(); event != of_touch.rend() && !out.events.empty() && out.events.back() == *event; ++event)
    out.events.pop_back();
  if (out.comes_back) out.kick = shortest_solution(with_touch, struck.x - free.x) / speed;
  return out;
}

/// The passage in the limit of zero speed, by extrapolation from two speeds.
Passage passage(OrbitProblem& problem, std::size_t contact, const Touch& touch, const GuardAndRate& at, double curvature) {
  constexpr double speed = 1e-4, negligible = 1e-5;  // terms of second order in the speed remain after the extrapolation
  Passage fast = passage_with(problem, contact, touch, at, curvature, speed);
  const Passage slow = passage_with(problem, contact, touch, at, curvature, 0.5 * speed);
  fast.comes_back = fast.comes_back && slow.comes_back;
  if (!fast.comes_back) return fast;
  fast.kick = 2.0 * slow.kick - fast.kick;
  if (fast.kick.lpNorm<Eigen::Infinity>() < negligible) fast.kick.setZero();
  return fast;
}

/// Computes the linear response of the periodic orbit to the impulse of the weak impact, per unit of its speed. It gives the
/// side of the grazing on which the orbit with the impact exists. Sets `scenario`, all members after it, and
/// `contact_events`.
void analyse(OrbitProblem& problem, const GrazingGuess& guess, const GuardAndRate& at, const Matrix& jacobian,
             LocatedGrazing& located) {
  ShootingEquations& equations = problem.equations();
  const Event& event = problem.system()->events[guess.event];
  const int n = problem.states(), j = guess.stretch;
  const Touch& touch = equations.stretch(j).touch;
  const Eigen::Index size = jacobian.rows();
  // The Jacobian is singular if a state keeps its value along the orbit (a body at rest). The least-norm solution leaves that
  // state unchanged.
  const Matrix in_states = jacobian.leftCols(size);
  const OrbitLU<Matrix> lu(in_states);
  const bool neutral = !lu.is_invertible(in_states);
  const auto solve = [&](const Vector& right) -> Vector {
    return neutral ? shortest_solution(in_states, right) : lu.solve(right);
  };
  const Vector u_dp = solve(-jacobian.col(size));
  located.family_dp.resize(size + 1);
  located.family_dp << u_dp, 1.0;
  located.top_dp =
      at.h_dx.dot(touch.Phi * u_dp.segment(j * n, n) + equations.fixed_time_dp(j, touch.Phi, touch.Psi).col(0)) + at.h_dp;
  // The reset changes a state that arrives with unit normal speed by (D_x g - I) w, where w is the direction of that speed. A
  // soft contact is replaced by its limit of large stiffness: a hard contact that reverses the normal speed.
  Matrix reset_dx = Matrix::Identity(n, n);
  if (!event.continuous && event.reset.map) event.reset.dx(touch.t, touch.x, equations.parameters(), reset_dx);
  const Vector w = at.rate_dx / at.rate_dx.squaredNorm();
  Vector kick = event.continuous ? Vector(-2.0 * w) : Vector(reset_dx * w - w);
  if (!event.continuous && (event.to != event.from || comes_with_event(problem, guess.event, touch))) {
    const Passage weak = passage(problem, guess.event, touch, at, located.curvature);
    located.leads_away = !weak.comes_back;
    if (weak.comes_back) {
      kick = weak.kick;
      located.contact_events = weak.events;
    }
  }
  // Transition matrix from the touch to the end of the stretch, which carries the impulse there.
  const Matrix rest = touch.Phi.transpose().partialPivLu().solve(equations.stretch(j).Phi.transpose()).transpose();
  located.gradient = at.h_dx;
  located.kick = kick;
  located.round = {rest};
  for (int k = 1; k < problem.nodes(); ++k) located.round.push_back(equations.stretch((j + k) % problem.nodes()).Phi);
  located.round.push_back(touch.Phi);
  if (event.continuous) located.scenario = GrazingScenario::smooth;
  if (located.touches > 1) return;  // the rest describes the response to a single impact
  Vector right = Vector::Zero(size);
  right.segment(j * n, n) = -rest * kick;
  const Vector response = solve(right);
  located.impulse.resize(size + 1);
  located.impulse << response, 0.0;
  located.response = -at.h_dx.dot(touch.Phi * response.segment(j * n, n));
  // An impulse along the motion only shifts the motion in time (an autonomous oscillator at its turning point).
  constexpr double along = 1e-6;  // relative accuracy of the kick of a passage
  if (std::abs(located.response) < along * at.h_dx.norm() * kick.norm()) located.response = 0.0;
  if (event.continuous) return;
  if (std::isfinite(located.response) && located.response != 0.0)
    located.scenario = located.response > 0.0 ? GrazingScenario::persistence : GrazingScenario::nonsmooth_fold;
}

/// The events of a weak contact that begins and ends at one instant: {event} for an impact, {enter, leave} for a soft contact.
std::vector<std::size_t> instantaneous_contact(const HybridSystem& system, std::size_t event) {
  const Event& in = system.events[event];
  const auto is_soft = [](EventKind kind) { return kind == EventKind::enter || kind == EventKind::leave; };
  const auto back = std::find_if(system.events.begin(), system.events.end(), [&](const Event& other) {
    return is_soft(in.kind) && is_soft(other.kind) && other.from == in.to && other.to == in.from;
  });
  if (back == system.events.end()) return {event};
  return {event, static_cast<std::size_t>(back - system.events.begin())};
}

/// Appends the events of the contact to `events`, at time t and with speed zero.
void add_contact(const HybridSystem& system, const std::vector<std::size_t>& of_contact, const Touch& touch, double t,
                 std::vector<EventRecord>& events) {
  for (const std::size_t event : of_contact) {
    EventRecord record;
    record.event = event;
    record.kind = system.events[event].kind;
    record.t = t;
    record.x_minus = record.x_plus = touch.x;
    record.mode_plus = system.events[event].to;
    events.push_back(std::move(record));
  }
}

/// Whether a contact begins or ends with an event of this kind.
bool may_be_touched(EventKind kind) { return begins_contact(kind) || kind == EventKind::leave; }

/// The defining equations of a grazing: F = (H, h, dh/dt) in (u, t).
class GrazingEquations : public DefiningEquations {
 public:
  GrazingEquations(const GrazingGuess& guess, std::vector<GrazingGuess> others)
      : guess_(guess), others_(std::move(others)), resume_after_(guess_.t_resume - guess_.t) {}

  Vector own_start() const override { return Vector{{guess_.t}}; }
  Vector sizes() const override { return sizes_; }
  NewtonRule rule() const override {
    NewtonRule rule = newton_to_rounding();
    rule.max_iterations = 25;
    rule.longest = 1.0;
    return rule;
  }

  bool evaluate(BranchProblem& problem, const Vector& w, Vector& F, Matrix* jacobian) override {
    const Eigen::Index unknowns = problem.unknowns(), size = problem.orbit_unknowns();
    Vector u;
    OrbitProblem& states = problem.stroboscopic(w.head(unknowns), u);
    ShootingEquations& equations = states.equations();
    const double t = w[unknowns];
    leave_out(equations, t);
    Vector H;
    const bool reached = states.residual(u, H, jacobian ? &orbit_jacobian : nullptr);
    if (!jacobian) others_vague = !reached || !meets_same_events(equations);
    if (!reached || (!jacobian && others_vague)) return false;
    const HybridSystem& system = problem.system();
    const Touch& touch = equations.stretch(guess_.stretch).touch;
    const auto met_in = [&](const FreeParameter& free) {
      return guard_and_rate(system.events[guess_.event].guard, system.modes[touch.mode], touch.t, touch.x, equations.parameters(),
                            free.index);
    };
    const GuardAndRate here = met_in(problem.free().front());
    const double scale = states.state_scale(u);
    if (resume_after_ == 0.0 && miss == 0.0) miss = smallest_miss(scale);
    F.resize(size + 2);
    F << H, here.h + miss, here.rate;
    if (!jacobian) return true;
    at = here;
    time = t;
    sizes_ = Vector::Constant(F.size(), scale);
    sequences_.clear();
    for (int k = 0; k < states.nodes(); ++k) sequences_.push_back(equations.stretch(k).event_sequence);
    *jacobian = Matrix::Zero(F.size(), w.size());
    jacobian->topLeftCorner(size, unknowns) = orbit_jacobian;
    const Eigen::Index first = guess_.stretch * states.states();
    jacobian->row(size).segment(first, states.states()) = at.h_dx.transpose() * touch.Phi;
    jacobian->row(size + 1).segment(first, states.states()) = at.rate_dx.transpose() * touch.Phi;
    const Matrix x_dp = equations.fixed_time_dp(guess_.stretch, touch.Phi, touch.Psi);
    for (Eigen::Index k = 0; k < x_dp.cols(); ++k) {
      const GuardAndRate of = k == 0 ? at : met_in(problem.free()[static_cast<std::size_t>(k)]);
      (*jacobian)(size, size + k) = of.h_dx.dot(x_dp.col(k)) + of.h_dp;
      (*jacobian)(size + 1, size + k) = of.rate_dx.dot(x_dp.col(k)) + of.rate_dp;
    }
    Vector f(states.states());
    equations.propagator().field(touch.mode, touch.t, touch.x, f);
    curvature = at.rate_dx.dot(f) + at.rate_dt;
    (*jacobian)(size, unknowns) = at.rate;
    (*jacobian)(size + 1, unknowns) = curvature;
    return true;
  }

  bool may_end(BranchProblem& problem, const Vector& w, double length) override {
    constexpr double near_touch = 1e-6;  // step length below which Newton's method has nearly converged
    Vector u;
    OrbitProblem& states = problem.stroboscopic(w.head(problem.unknowns()), u);
    const Touch& touch = states.equations().stretch(guess_.stretch).touch;
    if (!(resume_after_ > 0.0 && length < near_touch && comes_with_event(states, guess_.event, touch))) return true;
    miss = smallest_miss(states.state_scale(u));
    if (std::abs(at.h + miss) < 0.5 * miss) resume_after_ = 0.0;
    return false;
  }

  /// Leaves the touching contacts out of these equations, with the touch at the time t.
  void leave_out(ShootingEquations& equations, double t) const {
    equations.leave_out(guess_.stretch, {guess_.events_before, t, t + resume_after_});
    for (const GrazingGuess& other : others_) equations.leave_out(other.stretch, {other.events_before, other.t, other.t_resume});
  }

  // Of the last evaluation with Jacobian.
  Matrix orbit_jacobian;   ///< of H
  GuardAndRate at;         ///< at the touch
  double time = 0.0;       ///< of the touch
  double curvature = 0.0;  ///< d2h/dt2 at the touch
  /// If another event coincides with the touch, the mode changes there, and other guards apply afterwards. The equations then
  /// define the orbit that stays below the guard by `miss`, just enough not to meet it. A linear step leads from there to the
  /// grazing.
  double miss = 0.0;
  bool others_vague = false;  ///< see LocatedGrazing

 private:
  static double smallest_miss(double scale) { return 4.0 * guard_tolerance * scale; }

  /// Whether the motions of these equations meet the same events as in the last evaluation with Jacobian.
  bool meets_same_events(const ShootingEquations& equations) const {
    for (int k = 0; k < equations.nodes(); ++k)
      if (equations.stretch(k).event_sequence != sequences_[static_cast<std::size_t>(k)]) return false;
    return true;
  }

  GrazingGuess guess_;
  std::vector<GrazingGuess> others_;  ///< left out too
  double resume_after_;
  Vector sizes_;
  std::vector<std::vector<std::size_t>> sequences_;  ///< of each stretch
};

}  // namespace

std::optional<GrazingGuess> weakest_contact(OrbitProblem& problem, const Vector& u) {
  const std::vector<GrazingGuess> weakest = weakest_contacts(problem, u, 1);
  return weakest.empty() ? std::nullopt : std::optional(weakest.front());
}

std::vector<GrazingGuess> weakest_contacts(OrbitProblem& problem, const Vector& u, int count) {
  std::vector<GrazingGuess> list;
  if (!problem.evaluate(u, {.sensitivity = Sensitivity::none, .keep_events = true})) return list;
  const HybridSystem& system = problem.system();
  const ShootingEquations& equations = problem.equations();
  for (int j = 0; j < problem.nodes(); ++j) {
    const std::vector<EventRecord>& events = equations.stretch(j).events;
    for (std::size_t k = 0; k < events.size(); ++k) {
      // A short flight between two soft contacts is a single contact that nearly stays closed: it grazes from inside.
      const bool parted = events[k].kind == EventKind::leave && k + 1 < events.size() && events[k + 1].kind == EventKind::enter &&
                          system.events[events[k + 1].event].to == system.events[events[k].event].from;
      if (!begins_contact(events[k].kind) && !parted) continue;
      GrazingGuess guess;
      guess.event = events[k].event;
      guess.stretch = j;
      guess.events_before = k;
      guess.speed = events[k].normal_speed;
      // A soft contact has an event at each end, and its middle is the touch. The event after the contact bounds t_resume.
      const bool soft = parted || system.events[guess.event].kind == EventKind::enter;
      const std::size_t after = k + (soft ? 2 : 1);
      const double left = soft && k + 1 < events.size() ? events[k + 1].t : events[k].t;
      const double length = equations.duration(problem.orbit_part(u)) / problem.nodes();
      const double next = after < events.size() ? events[after].t : equations.node_time(problem.orbit_part(u), j) + length;
      guess.t = 0.5 * (events[k].t + left);
      guess.t_resume = left + std::min(0.5 * (next - left), 0.05 * length);
      list.push_back(guess);
    }
  }
  std::stable_sort(list.begin(), list.end(), [](const GrazingGuess& a, const GrazingGuess& b) { return a.speed < b.speed; });
  list.resize(std::min(list.size(), static_cast<std::size_t>(count)));
  return list;
}

std::optional<GrazingGuess> nearest_miss(OrbitProblem& problem, const Vector& u) {
  const std::vector<GrazingGuess> misses = near_misses(problem, u, std::numeric_limits<double>::infinity());
  return misses.empty() ? std::nullopt : std::optional(misses.front());
}

std::vector<GrazingGuess> near_misses(OrbitProblem& problem, const Vector& u, double within) {
  constexpr int samples = 400;
  // A slower contact is shallower than the accuracy of events, and cannot be distinguished from a miss.
  constexpr double no_miss = 1e-5;
  std::vector<GrazingGuess> list;
  if (!problem.evaluate(u, {.sensitivity = Sensitivity::none, .keep_events = true})) return list;
  const HybridSystem& system = problem.system();
  ShootingEquations& equations = problem.equations();
  Propagator& propagator = equations.propagator();
  const Vector shortened = problem.orbit_part(u);
  const double length = equations.duration(shortened) / problem.nodes();
  const auto sorted = [&] {
    std::stable_sort(list.begin(), list.end(), [](const GrazingGuess& a, const GrazingGuess& b) { return a.gap < b.gap; });
    return list;
  };
  // The gap to the guard of event e if its maximum coincides with the event `met`.
  const auto gap_at_event = [&](std::size_t e, const EventRecord& met) -> std::optional<double> {
    constexpr double slow = 1e-6;  // the speed there, relative to 1 + |f|
    const Event &event = system.events[e], &other = system.events[met.event];
    if (e == met.event || !may_be_touched(event.kind) || event.from != other.from) return std::nullopt;
    Vector f(problem.states());
    propagator.field(event.from, met.t, met.x_minus, f);
    const double gap = -event.guard.value(met.t, met.x_minus, propagator.parameters());
    const double speed = transversality(event.guard, met.t, met.x_minus, f, propagator.parameters());
    const bool touches = gap > 0.0 && gap < within && std::abs(speed) < slow * (1.0 + f.lpNorm<Eigen::Infinity>());
    return touches ? std::optional(gap) : std::nullopt;
  };
  for (int j = 0; j < problem.nodes(); ++j) {
    const double start = equations.node_time(shortened, j);
    HybridState state = propagator.start(start, equations.node(shortened, j));
    std::vector<double> before(system.events.size(), -std::numeric_limits<double>::infinity()), last = before;
    std::size_t events = 0;
    for (int i = 1; i <= samples; ++i) {
      const double t = start + length * i / samples;
      for (StepEnd end = StepEnd::event; end == StepEnd::event;) {
        end = propagator.step(state, t);
        if (end == StepEnd::failed || events > TransitionOptions().max_events) return sorted();
        if (end == StepEnd::event) {
          const EventRecord& met = propagator.record();
          for (std::size_t e = 0; e < system.events.size(); ++e)
            if (const auto gap = gap_at_event(e, met)) list.push_back({e, j, events, met.t, met.t, 0.0, *gap});
          if (may_be_touched(met.kind) && met.normal_speed < no_miss)
            list.push_back({met.event, j, events, met.t, met.t + 0.02 * length, met.normal_speed, 0.0});
          ++events;
          std::fill(before.begin(), before.end(), -std::numeric_limits<double>::infinity());
          last = before;
        }
      }
      for (std::size_t e = 0; e < system.events.size(); ++e) {
        const Event& event = system.events[e];
        if (!may_be_touched(event.kind) || event.from != state.mode) continue;
        const double h = event.guard.value(state.t, state.x, propagator.parameters());
        if (std::isfinite(before[e]) && last[e] >= before[e] && last[e] >= h) {
          // The parabola through the three samples.
          const double bend = before[e] - 2.0 * last[e] + h, slope = 0.5 * (h - before[e]);
          const double aside = bend < 0.0 ? -slope / bend : 0.0, gap = -(last[e] + 0.5 * slope * aside);
          const double top = t - length / samples;
          if (gap < within) list.push_back({e, j, events, top, top + 0.02 * length, 0.0, gap});
        }
        before[e] = last[e];
        last[e] = h;
      }
    }
  }
  return sorted();
}

std::unique_ptr<DefiningEquations> grazing_equations(const GrazingGuess& guess, const std::vector<GrazingGuess>& others) {
  return std::make_unique<GrazingEquations>(guess, others);
}

LocatedGrazing locate_grazing(OrbitProblem& problem, const Vector& start, const GrazingGuess& guess,
                              const std::vector<GrazingGuess>& together, const std::vector<GrazingGuess>& missed) {
  std::vector<GrazingGuess> others = together;
  others.insert(others.end(), missed.begin(), missed.end());
  GrazingEquations defining(guess, std::move(others));
  const LocatedPoint point = locate(problem, defining, start);
  LocatedGrazing located;
  located.newton = point.newton;
  located.u = point.u;
  located.precision = point.precision;
  located.event = guess.event;
  located.touches = 1 + static_cast<int>(together.size());
  located.curvature = defining.curvature;
  located.others_vague = defining.others_vague;
  located.confirmed = located.newton.converged() && located.curvature < 0.0;
  const HybridSystem& system = problem.system();
  ShootingEquations& equations = problem.equations();
  if (located.confirmed) analyse(problem, guess, defining.at, defining.orbit_jacobian, located);
  const Vector shortened = problem.orbit_part(located.u);
  if (located.confirmed) {
    defining.leave_out(equations, defining.time);
    located.orbit = problem.orbit(located.u, located.newton);
    located.confirmed = !located.orbit.states.empty();  // else another contact touches too
  }
  if (located.confirmed) {
    if (defining.miss > 0.0) {
      located.u += defining.miss / located.top_dp * located.family_dp;
      located.orbit.parameters[static_cast<Eigen::Index>(problem.parameter())] = problem.value(located.u);
    }
    located.touch = equations.stretch(guess.stretch).touch.x;
    const auto orbit_time = [&](int stretch, double time) {
      const double duration = equations.duration(shortened);
      const double since_phase_0 = equations.orbit_time(shortened, stretch) + time - equations.node_time(shortened, stretch);
      const double within = std::fmod(since_phase_0, duration);
      return within < 0.0 ? within + duration : within;
    };
    located.t = orbit_time(guess.stretch, defining.time);
    const auto events_of = [&](std::size_t event) {
      return event == guess.event && !located.contact_events.empty() ? located.contact_events
                                                                     : instantaneous_contact(system, event);
    };
    add_contact(system, events_of(guess.event), equations.stretch(guess.stretch).touch, located.t, located.contacts);
    for (const GrazingGuess& other : together) {
      const Touch& touch = equations.stretch(other.stretch).touch;
      add_contact(system, events_of(other.event), touch, orbit_time(other.stretch, touch.t), located.contacts);
    }
  }
  equations.leave_out(-1);
  return located;
}

}  // namespace graze
