// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/shooting.hpp>

#include <graze/floquet/orbit/least_period.hpp>
#include <graze/floquet/orbit/shooting_nodes.hpp>
#include <graze/lib/motion/rest.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <string_view>

namespace graze {

namespace {

/// The guess as nodes: used directly if their number fits, otherwise carried on from the first state.
Vector nodes_from(ShootingEquations& equations, const std::vector<Vector>& guess, double duration) {
  const int n = equations.states(), count = equations.nodes();
  Vector u(equations.unknowns());
  if (equations.autonomous()) u[n * count] = duration;
  if (static_cast<int>(guess.size()) == count) {
    for (int j = 0; j < count; ++j) u.segment(j * n, n) = guess[static_cast<std::size_t>(j)];
    return u;
  }
  Vector x = guess.front();
  Transition transition;
  for (int j = 0; j < count; ++j) {
    u.segment(j * n, n) = x;
    const double start = equations.node_time(u, j), length = equations.duration(u) / count;
    carry(equations.propagator(), start, start + length, x, {.sensitivity = Sensitivity::none}, transition);
    if (transition.termination == Termination::time) x = transition.x1;
  }
  return u;
}

/// Free re-simulation over the whole orbit from the first node: the same events in the same order.
Admissibility resimulate(ShootingEquations& equations, const Vector& u, const std::vector<std::size_t>& sequence, double growth) {
  Transition whole;
  const double start = equations.node_time(u, 0);
  carry(equations.propagator(), start, start + equations.duration(u), equations.node(u, 0), {.sensitivity = Sensitivity::none},
        whole);
  if (whole.termination == Termination::time && whole.event_sequence == sequence) return Admissibility::admissible;
  // If an orbit is so unstable that rounding grows to the size of the motion, it cannot be simulated in one piece. Its
  // stretches, each a free run, have already shown the same.
  const bool beyond_reach = growth * 1e-15 > 1e-6;
  return beyond_reach ? Admissibility::admissible : Admissibility::inadmissible;
}

/// True if stops hold all coordinates in this mode: each constrains a coordinate and its velocity.
bool holds_all(const HybridSystem& system, std::size_t mode) {
  return holding_event(system, mode) && (system.states == 2 || system.modes[mode].constraints.size() >= system.states);
}

/// Impacts and entries at stops that no complete chatter brings to rest within the orbit. The impacts of such a chatter are
/// infinitely many; events elsewhere may come between them, in an order that changes along a branch. Sticking by friction
/// involves no accumulation of impacts.
int isolated_impacts(const HybridSystem& system, const std::vector<EventRecord>& events) {
  std::set<std::string_view> resting;  // the events of a stop share its name
  for (const EventRecord& event : events)
    if (event.kind == EventKind::stick && system.events[event.event].accumulation)
      resting.insert(system.events[event.event].name);
  return static_cast<int>(std::count_if(events.begin(), events.end(), [&](const EventRecord& event) {
    return begins_contact(event.kind) && !resting.contains(system.events[event.event].name);
  }));
}

/// States at forcing phase 0 of the periods 0 ... n - 1, each carried from the node before it; also the mode at the first.
void add_stroboscopic_states(ShootingEquations& equations, const Vector& u, PeriodicOrbit& orbit) {
  const int n = orbit.period, count = equations.nodes();
  const double T = orbit.duration / n;
  Transition transition;
  for (int k = 0; k < n; ++k) {
    // Nodes lie at (s + j n / N) T; the one before the first is the last, a whole orbit earlier.
    const double place = (k - equations.section_phase()) * count / n + 1e-12;
    const bool before_first = place < 0.0;
    const int j = static_cast<int>(std::floor(before_first ? place + count : place));
    const double ahead = (before_first ? k + n : k) * T - equations.orbit_time(u, j), start = equations.node_time(u, j);
    Vector state = equations.node(u, j);
    std::size_t mode = equations.stretch(j).mode0;
    if (ahead > 1e-12 * T) {
      // A contact that is left out would change the speed by the square root of rounding.
      const TransitionOptions options = equations.options_of_stretch(j, {.sensitivity = Sensitivity::none});
      carry(equations.propagator(), start, start + ahead, state, options, transition);
      if (transition.termination == Termination::time) state = transition.x1;
      mode = transition.mode1;
    }
    if (k == 0) orbit.signature.mode = mode;
    orbit.states.push_back(std::move(state));
  }
}

}  // namespace

NewtonRule newton_rule(const ShootingOptions& options) {
  return {.max_iterations = options.max_iterations,
          .acceptance = options.acceptance,
          .tolerance = options.tolerance,
          .max_halvings = options.max_halvings,
          .max_step = options.max_step};
}

PeriodicOrbit describe_orbit(ShootingEquations& equations, const Vector& u, NewtonReport report) {
  PeriodicOrbit orbit;
  orbit.parameters = equations.parameters();
  orbit.period = equations.period();
  orbit.duration = equations.duration(u);
  orbit.section_phase = equations.section_phase();
  orbit.newton = std::move(report);
  for (int j = 0; j < equations.nodes(); ++j) orbit.nodes.push_back(equations.node(u, j));
  orbit.state = orbit.nodes.front();
  const bool evaluated = equations.evaluate(u, {.sensitivity = Sensitivity::state, .keep_factors = true, .keep_events = true});
  if (!evaluated) {
    if (orbit.newton.converged()) orbit.newton.status = NewtonStatus::evaluation_failed;
    return orbit;
  }
  Vector residual;
  equations.residual(u, residual);
  orbit.checks.residual = residual.lpNorm<Eigen::Infinity>() / (1.0 + u.lpNorm<Eigen::Infinity>());
  double log_det = 0.0, liouville = 0.0;
  std::vector<std::size_t> sequence;
  for (int j = 0; j < equations.nodes(); ++j) {
    const Transition& stretch = equations.stretch(j);
    const double offset = equations.orbit_time(u, j) - equations.node_time(u, j);
    for (EventRecord event : stretch.events) {
      event.t += offset;
      orbit.events.push_back(std::move(event));
    }
    sequence.insert(sequence.end(), stretch.event_sequence.begin(), stretch.event_sequence.end());
    orbit.monodromy.factors.insert(orbit.monodromy.factors.end(), stretch.factors.begin(), stretch.factors.end());
    orbit.monodromy.log_dets.insert(orbit.monodromy.log_dets.end(), stretch.factor_log_dets.begin(),
                                    stretch.factor_log_dets.end());
    orbit.monodromy.lost = std::max(orbit.monodromy.lost, stretch.lost);
    log_det += stretch.log_det;
    liouville += stretch.liouville;
  }
  if (equations.autonomous()) {
    orbit.monodromy.section = Section::autonomous;
    orbit.monodromy.trivial_direction.resize(equations.states());
    equations.propagator().field(equations.stretch(0).mode0, 0.0, orbit.state, orbit.monodromy.trivial_direction);
  }
  orbit.conservative = liouville == 0.0;
  orbit.rests = sequence.empty() && holds_all(equations.system(), equations.stretch(0).mode0);
  orbit.multipliers = multipliers(orbit.monodromy, orbit.duration);
  if (std::isfinite(log_det) && std::isfinite(liouville)) orbit.checks.liouville = std::abs(log_det - liouville);
  orbit.admissible = resimulate(equations, u, sequence, orbit.monodromy.product().cwiseAbs().maxCoeff());
  // Events and signature begin at phase 0, wherever the nodes lie.
  const auto wrapped =
      std::find_if(orbit.events.begin(), orbit.events.end(), [&](const EventRecord& event) { return event.t > orbit.duration; });
  for (auto event = wrapped; event != orbit.events.end(); ++event) event->t -= orbit.duration;
  std::rotate(orbit.events.begin(), wrapped, orbit.events.end());
  for (const EventRecord& event : orbit.events) orbit.signature.events.push_back(event.event);
  orbit.impacts = impacts(equations.system(), orbit.signature);
  orbit.isolated_impacts = isolated_impacts(equations.system(), orbit.events);
  add_stroboscopic_states(equations, u, orbit);
  orbit.state = orbit.states.front();
  return orbit;
}

double residual_allowed(const std::vector<EventRecord>& events) {
  constexpr double weak = 0.1;
  double weakest = 1.0, all_weak = 1.0;
  for (const EventRecord& event : events) {
    if (event.kind != EventKind::impact) continue;
    weakest = std::min(weakest, event.normal_speed);
    if (event.normal_speed < weak) all_weak *= event.normal_speed;
  }
  return 1e-11 + 1e-12 / std::min(weakest, all_weak);
}

PeriodicOrbit describe_orbit(ShootingEquations& equations, const Vector& u) {
  PeriodicOrbit orbit = describe_orbit(equations, u, NewtonReport{});
  const double residual = orbit.checks.residual;  // negative: the equations could not be evaluated
  orbit.newton.status = residual < 0.0                              ? NewtonStatus::evaluation_failed
                        : residual < residual_allowed(orbit.events) ? NewtonStatus::converged
                                                                    : NewtonStatus::stalled;
  return orbit;
}

PeriodicOrbit shoot(const HybridSystem& system, const Vector& p, const std::vector<Vector>& guess, int period,
                    const ShootingOptions& options, double duration_guess) {
  if (guess.empty()) throw std::invalid_argument("shooting needs a state to start from");
  ShootingEquations equations(system, p, period, options.nodes, {}, options.flow);
  if (equations.autonomous() && period != 1)
    throw std::invalid_argument("an autonomous orbit has period 1: its duration is an unknown");
  if (equations.autonomous() && !(duration_guess > 0.0))
    throw std::invalid_argument(fmt::format("the duration guess is {}; an autonomous orbit needs one > 0", duration_guess));
  for (const Vector& x : guess) initial_mode(system, 0.0, x, p);
  Vector u = nodes_from(equations, guess, duration_guess);
  if (equations.autonomous()) equations.set_phase_reference(guess.front());
  ShootingNodes on_nodes(equations);
  NewtonReport report = result_at_once(newton_loop(on_nodes, newton_rule(options), u));
  PeriodicOrbit orbit = describe_orbit(equations, u, std::move(report));
  if (orbit.converged() && options.reduce_period && period > 1) {
    for (const std::size_t shorter : shorter_periods(orbit.states)) {
      const int divisor = static_cast<int>(shorter);
      ShootingOptions with_fewer_nodes = options;
      if (options.nodes % divisor != 0) with_fewer_nodes.nodes = 0;
      // One state, as the nodes may be other ones.
      PeriodicOrbit found = shoot(system, p, guess_of_shorter(orbit.states, shorter).front(), divisor, with_fewer_nodes);
      if (!found.converged()) continue;
      const auto times = static_cast<std::size_t>(period / found.period);
      if (is_repeated(found.multipliers.values, times, state_distance(found.state, orbit.state), state_size(orbit.state)))
        return found;
    }
  }
  if (orbit.converged() && options.finite_differences)
    orbit.checks.finite_difference = finite_difference_check(system, orbit, options.flow);
  return orbit;
}

namespace {

/// Best Romberg extrapolation of central differences for one column of a stretch's transition matrix.
struct Column {
  Vector value;
  double error = std::numeric_limits<double>::infinity();
};

}  // namespace

FiniteDifferenceCheck finite_difference_check(const HybridSystem& system, const PeriodicOrbit& orbit,
                                              const FlowOptions& options) {
  FiniteDifferenceCheck check;
  if (orbit.nodes.empty()) return check;
  ShootingEquations equations(system, orbit.parameters, orbit.period, static_cast<int>(orbit.nodes.size()), {}, options,
                              orbit.section_phase);
  const int n = equations.states(), count = equations.nodes();
  Vector u(equations.unknowns());
  for (int j = 0; j < count; ++j) u.segment(j * n, n) = orbit.nodes[static_cast<std::size_t>(j)];
  if (equations.autonomous()) {
    u[n * count] = orbit.duration;
    equations.set_phase_reference(orbit.state);
  }
  if (!equations.evaluate(u, {.sensitivity = Sensitivity::state})) return check;
  Transition moved;
  check.applicable = true;
  for (int j = 0; j < count && check.applicable; ++j) {
    const Transition& base = equations.stretch(j);
    const double start = equations.node_time(u, j), length = orbit.duration / count;
    const double scale = 1.0 + base.Phi.cwiseAbs().maxCoeff();
    Matrix factor = Matrix::Zero(n, n);
    for (int k = 0; k < n; ++k) {
      const double unit = 1.0 + std::abs(u[j * n + k]);
      const auto difference = [&](double h) -> std::optional<Vector> {
        Vector ends[2];
        double places[2];
        for (int side = 0; side < 2; ++side) {
          Vector x = equations.node(u, j);
          x[k] += side == 0 ? h : -h;
          places[side] = x[k];
          carry(equations.propagator(), start, start + length, x, {.sensitivity = Sensitivity::none}, moved);
          if (moved.termination != Termination::time || moved.event_sequence != base.event_sequence || moved.mode0 != base.mode0)
            return std::nullopt;
          ends[side] = moved.x1;
        }
        return (ends[0] - ends[1]) / (places[0] - places[1]);
      };
      // The step is halved from large to small, three levels are extrapolated, and the value with the smallest error estimate
      // is kept.
      Column best;
      std::optional<Vector> coarse, middle;
      for (double h = 0.02 * unit; h > 1e-7 * unit; h *= 0.5) {
        const std::optional<Vector> fine = difference(h);
        if (coarse && middle && fine) {
          const Vector first = (4.0 * *middle - *coarse) / 3.0, second = (4.0 * *fine - *middle) / 3.0;
          const Vector value = (16.0 * second - first) / 15.0;
          const double rounding = 1e-15 * scale * unit / h;
          const double error = (value - second).lpNorm<Eigen::Infinity>() + rounding;
          if (error < best.error) best = {value, error};
        }
        coarse = middle;
        middle = fine;
      }
      if (!std::isfinite(best.error)) {
        check.applicable = false;
        break;
      }
      factor.col(k) = best.value;
      check.disagreement = std::max(check.disagreement, (best.value - base.Phi.col(k)).lpNorm<Eigen::Infinity>() / scale);
      check.error_estimate = std::max(check.error_estimate, best.error / scale);
    }
    check.monodromy.factors.push_back(std::move(factor));
  }
  check.monodromy.section = orbit.monodromy.section;
  check.monodromy.trivial_direction = orbit.monodromy.trivial_direction;
  if (!check.applicable) check.monodromy.factors.clear();
  return check;
}

}  // namespace graze
