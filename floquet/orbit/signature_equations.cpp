// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/signature.hpp>
#include <graze/floquet/orbit/signature_equations.hpp>
#include <graze/lib/motion/rest.hpp>
#include <graze/lib/system/guard_rounding.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace graze {

namespace {

/// The constraints of each event's target mode that are those of all of them.
std::vector<std::vector<const Constraint*>> held_all_along(const HybridSystem& system, const std::vector<std::size_t>& sequence) {
  const auto constraints = [&](std::size_t event) -> const std::vector<Constraint>& {
    return system.modes[system.events[event].to].constraints;
  };
  const auto holds_everywhere = [&](const Constraint& one) {
    return std::all_of(sequence.begin(), sequence.end(), [&](std::size_t event) {
      const std::vector<Constraint>& there = constraints(event);
      return std::any_of(there.begin(), there.end(), [&](const Constraint& other) { return other.number == one.number; });
    });
  };
  std::vector<std::vector<const Constraint*>> held(sequence.size());
  for (std::size_t k = 0; k < sequence.size(); ++k)
    for (const Constraint& one : constraints(sequence[k]))
      if (holds_everywhere(one)) held[k].push_back(&one);
  return held;
}

}  // namespace

SignatureEquations::SignatureEquations(const SharedSystem& system, const Vector& p, int period, std::vector<std::size_t> events,
                                       const std::vector<std::size_t>& free, const FlowOptions& options)
    : propagator_(system, p, free, options), n_(static_cast<int>(system->states)), period_(period), sequence_(std::move(events)),
      free_(free) {
  if (!is_forced(system))
    throw std::invalid_argument("a signature with fixed period needs a forced system; this one is autonomous");
  if (free_.empty()) throw std::invalid_argument("no free parameter was given; give at least one");
  if (sequence_.empty()) throw std::invalid_argument("a signature without events has no nodes; use ShootingEquations");
  if (const auto k = first_break(system, sequence_))
    throw std::invalid_argument(fmt::format("event {} does not lead to the mode in which event {} can follow",
                                            system->events[sequence_[*k]].name,
                                            system->events[sequence_[(*k + 1) % sequence_.size()]].name));
  held_ = held_all_along(system, sequence_);
}

double SignatureEquations::end_time(const Vector& u, int k) const {
  return k + 1 < events() ? time(u, k + 1) : time(u, 0) + duration();
}

HybridState SignatureEquations::after(const Vector& u, int k) {
  const Event& here = event(k);
  HybridState state{time(u, k), this->state(u, k), here.to};
  if (here.reset.map) here.reset.map(state.t, this->state(u, k), parameters(), state.x);
  return state;
}

bool SignatureEquations::fixes_states(const HybridState& start, int k) const {
  const Vector& p = parameters();
  Vector gradient(n_), field(n_), dp(p.size());
  propagator_.field(start.mode, start.t, start.x, field);
  return !held(k).empty() && std::all_of(held(k).begin(), held(k).end(), [&](const Constraint* one) {
    one->dx(start.t, start.x, p, gradient);
    dp.setZero();
    if (one->dp) one->dp(start.t, start.x, p, dp);
    Eigen::Index place = 0;
    gradient.cwiseAbs().maxCoeff(&place);
    return (gradient.array() != 0.0).count() == 1 && field[place] == 0.0 &&
           std::all_of(free_.begin(), free_.end(), [&](std::size_t free) { return dp[static_cast<Eigen::Index>(free)] == 0.0; });
  });
}

bool SignatureEquations::holds_states(const Vector& u) {
  for (int k = 0; k < events(); ++k) {
    if (held(k).empty()) return false;
    const HybridState start = after(u, k);
    if (!fixes_states(start, k) || !constraint_map(system(), held(k), start, parameters(), {})) return false;
  }
  return true;
}

bool SignatureEquations::evaluate(const Vector& u, int k, bool derivatives, Block& block) {
  const Vector& p = parameters();
  const Event& here = event(k);
  const double t = time(u, k), end = end_time(u, k);
  if (!(end > t)) return false;  // events out of order
  const Vector x = state(u, k);
  HybridState moving = after(u, k);
  Vector start_field(n_), end_field(n_);
  if (derivatives) propagator_.field(here.to, t, moving.x, start_field);
  std::optional<ConstraintMap> lost;
  if (derivatives && fixes_states(moving, k)) lost = constraint_map(system(), held(k), moving, p, {});
  if (!propagator_.coast(moving, end, derivatives ? Sensitivity::state_and_parameters : Sensitivity::none)) return false;
  block.mismatch = moving.x - state(u, (k + 1) % events());
  block.gap = here.guard.value(t, x, p);
  if (!derivatives) return true;
  const Segment& flight = propagator_.segment();
  propagator_.field(here.to, end, moving.x, end_field);
  const Matrix Phi = lost ? Matrix(flight.Phi * lost->dx) : flight.Phi;
  Matrix reset_dx = Matrix::Identity(n_, n_), reset_dp = Matrix::Zero(n_, p.size());
  Vector reset_dt = Vector::Zero(n_), gradient(n_), guard_dp = Vector::Zero(p.size());
  if (here.reset.map) here.reset.dx(t, x, p, reset_dx);
  if (here.reset.dp) here.reset.dp(t, x, p, reset_dp);
  if (here.reset.dt) here.reset.dt(t, x, p, reset_dt);
  block.own.resize(n_, n_ + 1);
  block.own << Phi * (reset_dt - start_field), Phi * reset_dx;
  block.next.resize(n_, n_ + 1);
  block.next << end_field, -Matrix::Identity(n_, n_);
  const auto free = static_cast<Eigen::Index>(free_.size());
  const bool last = k + 1 == events();
  const Vector period_dp = last ? forcing_period_dp(system(), p) : Vector();
  block.mismatch_dp.resize(n_, free);
  for (Eigen::Index j = 0; j < free; ++j) {
    const auto parameter = static_cast<Eigen::Index>(free_[static_cast<std::size_t>(j)]);
    block.mismatch_dp.col(j) = flight.Psi.col(j) + Phi * reset_dp.col(parameter);
    if (last) block.mismatch_dp.col(j) += end_field * (period_ * period_dp[parameter]);
  }
  here.guard.dx(t, x, p, gradient);
  if (here.guard.dp) here.guard.dp(t, x, p, guard_dp);
  block.own_gap.resize(n_ + 1);
  block.own_gap << (here.guard.dt ? here.guard.dt(t, x, p) : 0.0), gradient;
  block.gap_dp = guard_dp(free_);
  return true;
}

bool SignatureEquations::evaluate(const Vector& u, Vector& residual, Matrix* jacobian) {
  const int size = n_ + 1;
  residual.resize(unknowns());
  if (jacobian) jacobian->setZero(unknowns(), unknowns() + static_cast<Eigen::Index>(free_.size()));
  Block block;
  for (int k = 0; k < events(); ++k) {
    if (!evaluate(u, k, jacobian != nullptr, block)) return false;
    residual.segment(k * size, n_) = block.mismatch;
    residual[k * size + n_] = block.gap;
    if (!jacobian) continue;
    auto rows = jacobian->middleRows(k * size, n_);
    rows.middleCols(k * size, size) += block.own;
    rows.middleCols((k + 1) % events() * size, size) += block.next;
    rows.rightCols(block.mismatch_dp.cols()) = block.mismatch_dp;
    auto row = jacobian->row(k * size + n_);
    row.segment(k * size, size) = block.own_gap.transpose();
    row.tail(block.gap_dp.size()) = block.gap_dp.transpose();
  }
  return residual.allFinite() && (!jacobian || jacobian->allFinite());
}

double SignatureEquations::speed(const Vector& u, int k) {
  const Vector x = state(u, k);
  Vector f(n_);
  propagator_.field(event(k).from, time(u, k), x, f);
  return transversality(event(k).guard, time(u, k), x, f, parameters());
}

double SignatureEquations::scaled_speed(const Vector& u, int k) {
  const double size = guard_scale(event(k).guard, time(u, k), state(u, k), parameters()).dx;
  return size > 0.0 ? speed(u, k) / size : speed(u, k);
}

Vector SignatureEquations::speed_gradient(const Vector& u, int k) {
  Vector out = Vector::Zero(unknowns() + static_cast<Eigen::Index>(free_.size()));
  for (std::size_t j = 0; j < free_.size(); ++j) {
    const GuardAndRate at =
        guard_and_rate(event(k).guard, system().modes[event(k).from], time(u, k), state(u, k), parameters(), free_[j]);
    out[k * (n_ + 1)] = at.rate_dt;
    out.segment(k * (n_ + 1) + 1, n_) = at.rate_dx;
    out[unknowns() + static_cast<Eigen::Index>(j)] = at.rate_dp;
  }
  return out;
}

/// Whether the event met on the flight after event k is the next event itself, approached from inside. A weak impact is met
/// early, because the motion is within the guard's tolerance long before. It then rises all the way to the event, since the
/// remaining time is too short for a fall and another rise.
bool SignatureEquations::is_next_event(const Vector& u, int k, const EventRecord& met) {
  constexpr double too_short_to_fall = 1e-3;  // of a forcing period
  const int next = (k + 1) % events();
  const double ahead = end_time(u, k) - met.t;
  if (met.event != sequence_[static_cast<std::size_t>(next)] || ahead > too_short_to_fall * duration() / period_) return false;
  Vector f(n_);
  propagator_.field(event(next).from, met.t, met.x_minus, f);
  return transversality(event(next).guard, met.t, met.x_minus, f, parameters()) > 0.0;
}

std::optional<SignatureEquations::Violation> SignatureEquations::violation(const Vector& u) {
  for (int k = 0; k < events(); ++k)
    if (!(speed(u, k) > 0.0)) return Violation{k, true};
  for (int k = 0; k < events(); ++k) {
    // The last moment before the next event is left out: the motion is already on the guard there, up to guard_tolerance, and
    // an arc beyond it is no deeper than 1e-11.
    const double end = end_time(u, k), length = end - time(u, k), watched = end - std::min(1e-5, 0.01 * length);
    HybridState moving = after(u, k);
    const StepEnd met = propagator_.step(moving, watched);
    if (met == StepEnd::event && !is_next_event(u, k, propagator_.record())) return Violation{k, false, propagator_.record()};
    if (met == StepEnd::failed) return Violation{k, false, {}};
  }
  return std::nullopt;
}

MonodromyMatrix SignatureEquations::monodromy(const Vector& u, double* liouville_error) {
  MonodromyMatrix monodromy;
  double log_det = 0.0, liouville = 0.0;
  Vector f_minus(n_), f_plus(n_);
  for (int k = 0; k < events(); ++k) {
    const Event& here = event(k);
    const Vector x = state(u, k);
    HybridState moving = after(u, k);
    const Vector x_plus = moving.x;
    propagator_.field(here.from, moving.t, x, f_minus);
    propagator_.field(here.to, moving.t, x_plus, f_plus);
    if (!here.continuous) {
      const SaltationMatrix jump = saltation(here, {moving.t, x, x_plus, f_minus, f_plus}, parameters(), {});
      monodromy.factors.push_back(jump.S);
      monodromy.log_dets.push_back(std::numeric_limits<double>::quiet_NaN());
      const double volume = jump.regular ? std::log(std::abs(jump.S.determinant())) : std::numeric_limits<double>::quiet_NaN();
      log_det += volume;
      liouville += here.log_volume_change ? here.log_volume_change(parameters()) : volume;
    }
    if (!held(k).empty()) {
      if (std::optional<ConstraintMap> lost = constraint_map(system(), held(k), moving, parameters(), {})) {
        monodromy.factors.push_back(std::move(lost->dx));
        monodromy.log_dets.push_back(std::numeric_limits<double>::quiet_NaN());
        log_det = liouville = -std::numeric_limits<double>::infinity();
      }
    }
    if (!propagator_.coast(moving, end_time(u, k), Sensitivity::state)) return {};
    const Segment& flight = propagator_.segment();
    monodromy.factors.push_back(flight.Phi);
    monodromy.log_dets.push_back(flight.divergence);
    log_det += std::log(std::abs(flight.Phi.determinant()));
    liouville += flight.divergence;
  }
  if (liouville_error) {
    const double error = std::abs(log_det - liouville);
    *liouville_error = std::isfinite(error) ? error : -1.0;
  }
  return monodromy;
}

int SignatureEquations::flight_at(const Vector& u, double t, double& shift) const {
  // The flight before the first event is the last one, a whole orbit earlier.
  shift = 0.0;
  while (t + shift < time(u, 0)) shift += duration();
  while (t + shift >= time(u, 0) + duration()) shift -= duration();
  int k = 0;
  while (k + 1 < events() && time(u, k + 1) <= t + shift) ++k;
  return k;
}

std::vector<Vector> SignatureEquations::states_at(const Vector& u, const std::vector<double>& times) {
  std::vector<Vector> list;
  for (const double t : times) {
    double shift = 0.0;
    const int k = flight_at(u, t, shift);
    HybridState moving = after(u, k);
    if (t + shift > moving.t && !propagator_.coast(moving, t + shift)) return {};
    list.push_back(moving.x);
  }
  return list;
}

std::size_t SignatureEquations::mode_at(const Vector& u, double t) const {
  double shift = 0.0;
  return event(flight_at(u, t, shift)).to;
}

}  // namespace graze
