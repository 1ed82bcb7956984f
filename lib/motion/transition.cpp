// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lanes/lane_width.hpp>
#include <graze/lib/lanes/oscillator.hpp>
#include <graze/lib/motion/rest.hpp>
#include <graze/lib/motion/transition.hpp>
#include <graze/lib/numerics/rank.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace graze {

namespace {

/// B = A B. Two states are by far the most frequent case: their product needs no allocation.
void multiply_from_left(const Matrix& A, Matrix& B) {
  if (A.rows() == 2 && B.cols() == 2) {
    const Eigen::Matrix2d product = A.topLeftCorner<2, 2>() * B.topLeftCorner<2, 2>();
    B = product;
  } else {
    B = A * B;
  }
}

double determinant(const Matrix& A) { return A.rows() == 2 ? A(0, 0) * A(1, 1) - A(0, 1) * A(1, 0) : A.determinant(); }

/// ln|det| from the entries of a segment's matrix. NaN if it is lost to cancellation, beyond which the entries' own error
/// (1e-13) would show.
double log_abs_det(const Matrix& matrix) {
  const bool small = matrix.rows() == 2;
  const double det = determinant(matrix);
  const double size =
      small ? std::abs(matrix(0, 0) * matrix(1, 1)) + std::abs(matrix(0, 1) * matrix(1, 0)) : matrix.rowwise().norm().prod();
  constexpr double cancelled = 1e-3;
  return std::abs(det) < cancelled * size ? std::numeric_limits<double>::quiet_NaN() : std::log(std::abs(det));
}

/// A disturbance off a constraint is lost if at most this part of it remains: rounding of the map's entries.
constexpr double lost_part = 1e-10;

/// One run of carry(): the present state, and the map composed so far.
class Composer {
 public:
  Composer(Propagator& propagator, const TransitionOptions& options, Transition& out)
      : propagator_(propagator), options_(options), out_(out), tangent_(options.sensitivity != Sensitivity::none),
        parameters_(options.sensitivity == Sensitivity::state_and_parameters
                        ? static_cast<Eigen::Index>(propagator.active().size())
                        : 0) {
    const auto n = static_cast<Eigen::Index>(propagator.system().states);
    out.termination = Termination::failed;
    out.factors.clear();
    out.factor_log_dets.clear();
    out.events.clear();
    out.event_sequence.clear();
    out.log_det = out.liouville = 0.0;
    out.lost = 0;
    out.return_map.resize(0, 0);
    if (!tangent_) return;
    out.Phi.setIdentity(n, n);
    out.Psi.setZero(n, parameters_);
  }

  bool start(double t0, const Vector& x0) {
    if (static_cast<std::size_t>(x0.size()) != propagator_.system().states)
      throw std::invalid_argument(fmt::format("the state has {} entries; system {} has {}", x0.size(), propagator_.system().name,
                                              propagator_.system().states));
    state_.t = t0;
    state_.x = x0;
    state_.mode = 0;
    const HybridSystem& system = propagator_.system();
    const Vector& p = propagator_.parameters();
    std::optional<std::size_t> mode = mode_at(system, t0, x0, p);
    if (!mode && options_.held_mode && settle_on_constraints(system, *options_.held_mode, t0, p, state_.x))
      mode = mode_at(system, t0, state_.x, p);
    if (!mode) return fail(Termination::inadmissible_start);
    out_.mode0 = state_.mode = *mode;
    if (!system.modes[*mode].constraints.empty()) settle_on_constraints(system, *mode, t0, p, state_.x);
    keep_constraints();
    return true;
  }

  /// Starts right after a return.
  bool start_period(const Vector& x0) {
    std::optional<HybridState> start = propagator_.start_period(x0);
    if (!start) return fail(Termination::inadmissible_start);
    state_ = std::move(*start);
    out_.mode0 = state_.mode;
    keep_constraints();
    return true;
  }

  /// Runs to right after the next return.
  bool run_to_return() {
    const auto& cancelled = propagator_.options().cancelled;
    Matrix before;  // Phi up to the event
    for (;;) {
      if (cancelled && cancelled()) return fail(Termination::interrupted);
      const StepEnd end = propagator_.step(state_, longest_return, options_.sensitivity);
      if (end == StepEnd::failed) return motion_lasts() ? rest() : fail(propagator_.failure());
      compose_segment();
      if (end == StepEnd::time) return rest();
      const std::optional<Termination> period = propagator_.period_end(state_);
      const bool is_return = period.has_value();
      if (is_return && tangent_) before = out_.Phi;
      if (!compose_event()) return fail(Termination::grazing);
      if (is_return) {
        if (*period == Termination::no_return) return rest();
        if (tangent_) compose_return(before);
        out_.duration = state_.t;
        return true;
      }
      if (out_.event_sequence.size() >= options_.max_events) return fail(Termination::event_limit);
    }
  }

  /// Runs to t_end through all events, or through `max_events` events.
  bool run(double t_end, std::size_t max_events) {
    const auto& cancelled = propagator_.options().cancelled;
    while (out_.event_sequence.size() < max_events) {
      if (cancelled && cancelled()) return fail(Termination::interrupted);
      const StepEnd end = propagator_.step(state_, t_end, options_.sensitivity);
      if (end == StepEnd::failed) return fail(propagator_.failure());
      compose_segment();
      if (end == StepEnd::time) return true;
      if (!compose_event()) return fail(Termination::grazing);
      if (out_.event_sequence.size() >= options_.max_events) return fail(Termination::event_limit);
    }
    return true;
  }

  /// Follows the field to t_end and ignores the guards.
  bool coast(double t_end) {
    if (t_end <= state_.t) return true;
    if (!propagator_.coast(state_, t_end, options_.sensitivity)) return fail(Termination::integration_failed);
    compose_segment();
    return true;
  }

  void record_touch() { out_.touch = {state_.t, state_.x, state_.mode, out_.Phi, out_.Psi}; }

  void finish(double t0) {
    if (tangent_ && out_.event_sequence.empty())
      if (const Event* holding = holding_event(propagator_.system(), state_.mode)) compose_rest(*holding, t0);
    if (!kept_.empty()) compose_constraints();
    out_.x1 = state_.x;
    out_.mode1 = state_.mode;
    out_.termination = Termination::time;
  }

 private:
  /// Whether a flight that has used up its steps was so long that no return can be expected. The state becomes its end.
  bool motion_lasts() {
    constexpr double long_flight = 0.1 * longest_return;
    const Segment& flight = propagator_.segment();
    if (!(flight.t1 - flight.t0 >= long_flight) || propagator_.failure() != Termination::integration_failed) return false;
    state_.t = flight.t1;
    state_.x = flight.x1;
    return true;
  }

  bool rest() {
    out_.x1 = state_.x;
    return fail(Termination::no_return);
  }

  bool fail(Termination reason) {
    out_.termination = reason;
    return false;
  }

  void compose_segment() {
    if (!tangent_) return;
    const Segment& segment = propagator_.segment();
    multiply_from_left(segment.Phi, out_.Phi);
    if (parameters_ > 0) out_.Psi = segment.Phi * out_.Psi + segment.Psi;
    out_.log_det += log_abs_det(segment.Phi);
    out_.liouville += segment.divergence;
    if (!options_.keep_factors) return;
    out_.factors.push_back(segment.Phi);
    out_.factor_log_dets.push_back(segment.divergence);
  }

  /// Composes the return map. After an accumulation point no guard defines the instant of return; the map is then projected
  /// orthogonally to the field, which leaves the multipliers unchanged.
  void compose_return(const Matrix& before) {
    const EventRecord& record = propagator_.record();
    const Event& event = propagator_.system().events[record.event];
    Vector field(state_.x.size()), gradient(state_.x.size());
    propagator_.field(state_.mode, state_.t, state_.x, field);
    out_.return_map = out_.Phi;
    if (record.kind == event.kind) {
      event.guard.dx(record.t, record.x_minus, propagator_.parameters(), gradient);
      out_.return_map -= field * (gradient.transpose() * before) / record.normal_speed;
    } else if (field.squaredNorm() > 0.0) {
      out_.return_map -= field * (field.transpose() * out_.Phi) / field.squaredNorm();
    }
  }

  /// Composes the map of a mass held from beginning to end (rest.hpp). A disturbance first loses the part that the stop
  /// absorbs; the remainder evolves in the sticking mode.
  void compose_rest(const Event& holding, double t0) {
    const Vector& p = propagator_.parameters();
    const Vector& start = propagator_.segment().x0;
    HeldMap held = held_map(propagator_.system(), holding, t0, start, p, state_.t - t0);
    const auto& dp = holding.accumulation->reset.dp;
    if (parameters_ > 0 && dp) {  // a shift of the stop shifts the state of rest
      Matrix rest_dp = Matrix::Zero(state_.x.size(), p.size());
      dp(t0, start, p, rest_dp);
      const Matrix forgotten = Matrix::Identity(held.Phi.rows(), held.Phi.cols()) - held.Phi;
      const bool forgets = std::isinf(held.log_det);
      if (held.slope.size() > 0 && holding.guard.dp) {
        Vector guard_dp = Vector::Zero(p.size());
        holding.guard.dp(t0, start, p, guard_dp);
        rest_dp += held.slope * guard_dp.transpose();
      }
      for (Eigen::Index k = 0; k < parameters_; ++k) {
        const Vector moved = rest_dp.col(static_cast<Eigen::Index>(propagator_.active()[static_cast<std::size_t>(k)]));
        out_.Psi.col(k) += out_.Phi * (forgets ? moved : Vector(forgotten * moved));
      }
    }
    if (std::isinf(held.log_det)) forget(held.Phi);
    note_lost(held.Phi);
    out_.Phi = out_.Phi * held.Phi;
    out_.log_det += held.log_det;
    out_.liouville += held.log_det;
    if (!options_.keep_factors) return;
    out_.factor_log_dets.insert(out_.factor_log_dets.begin(),
                                std::isfinite(held.log_det) ? held.log_det : std::numeric_limits<double>::quiet_NaN());
    out_.factors.insert(out_.factors.begin(), std::move(held.Phi));
  }

  /// Notes the directions that a factor loses; whether there are any. (With two states its entries are exactly zero.)
  bool note_lost(const Matrix& factor) {
    if (factor.rows() == 2) return false;
    const auto lost = static_cast<int>(rank_deficiency(factor));
    out_.lost = std::max(out_.lost, lost);
    return lost > 0;
  }

  void keep_constraints() {
    if (!tangent_) return;
    for (const Constraint& one : propagator_.system().modes[state_.mode].constraints) kept_.push_back(&one);
    if (!kept_.empty()) start_ = state_;
  }

  /// Drops the constraints whose disturbances the map of a held mass already annihilates.
  void forget(const Matrix& held) {
    Vector gradient(held.rows());
    const auto annihilated = std::erase_if(kept_, [&](const Constraint* one) {
      one->dx(start_.t, start_.x, propagator_.parameters(), gradient);
      return (gradient.transpose() * held).lpNorm<Eigen::Infinity>() <= lost_part * gradient.lpNorm<Eigen::Infinity>();
    });
    out_.lost = std::max(out_.lost, static_cast<int>(annihilated));
  }

  /// Composes the map of the constraints that have held from start to end: a disturbance off them is lost at once. (Where a
  /// constraint ends, the saltation matrix has the same effect.)
  void compose_constraints() {
    const std::span<const std::size_t> active(propagator_.active().data(), static_cast<std::size_t>(parameters_));
    std::optional<ConstraintMap> lost = constraint_map(propagator_.system(), kept_, start_, propagator_.parameters(), active);
    if (!lost) return;
    if (parameters_ > 0) out_.Psi += out_.Phi * lost->dp;
    note_lost(lost->dx);
    out_.Phi = out_.Phi * lost->dx;
    if (out_.return_map.size() > 0) out_.return_map = out_.return_map * lost->dx;
    out_.log_det = out_.liouville = -std::numeric_limits<double>::infinity();
    if (!options_.keep_factors) return;
    out_.factor_log_dets.insert(out_.factor_log_dets.begin(), std::numeric_limits<double>::quiet_NaN());
    out_.factors.insert(out_.factors.begin(), std::move(lost->dx));
  }

  bool compose_event() {
    const EventRecord& record = propagator_.record();
    const Event& event = propagator_.system().events[record.event];
    out_.event_sequence.push_back(record.event);
    std::erase_if(kept_, [&](const Constraint* one) {
      const std::vector<Constraint>& now = propagator_.system().modes[state_.mode].constraints;
      return std::none_of(now.begin(), now.end(), [&](const Constraint& other) { return other.number == one->number; });
    });
    if (options_.keep_events) out_.events.push_back(record);
    if (!tangent_) return true;
    const SaltationMatrix& saltation = record.saltation;
    if (!saltation.regular) return false;
    if (record.is_followed || (event.continuous && !record.follows)) return true;  // S is the identity
    multiply_from_left(saltation.S, out_.Phi);
    if (parameters_ > 0) out_.Psi = saltation.S * out_.Psi + saltation.Sp;
    const bool singular = note_lost(saltation.S);
    const double volume = singular ? -std::numeric_limits<double>::infinity() : std::log(std::abs(determinant(saltation.S)));
    out_.log_det += volume;
    const bool known = event.log_volume_change && record.kind != EventKind::stick && !record.follows;
    out_.liouville += known ? event.log_volume_change(propagator_.parameters()) : volume;
    if (options_.keep_factors) {
      out_.factors.push_back(saltation.S);
      out_.factor_log_dets.push_back(std::numeric_limits<double>::quiet_NaN());
    }
    return true;
  }

  Propagator& propagator_;
  const TransitionOptions& options_;
  Transition& out_;
  bool tangent_;
  Eigen::Index parameters_;
  HybridState& state_ = propagator_.run();
  std::vector<const Constraint*> kept_;  // constraints that have held since the start
  HybridState start_;                    // the start, if there are constraints
};

/// carry() on the fast path, by a single lane. False: the task does not qualify, or the lane gave it up.
bool carry_in_lane(Propagator& propagator, double t0, double t1, const Vector& x0, const TransitionOptions& options,
                   Transition& out) {
  if (t0 != 0.0 || options.keep_factors || options.keep_events || options.left_out || x0.size() != 2 ||
      options.sensitivity == Sensitivity::state_and_parameters)
    return false;
  const lanes::Oscillator* lane = propagator.one_lane();
  if (!lane || t1 != lane->coefficients[lanes::period]) return false;
  const auto& cancelled = propagator.options().cancelled;
  if (cancelled && cancelled()) return false;
  lanes::Period period;
  const lanes::Motion motion{x0[0], x0[1], 0, &lane->coefficients, lane->grid.get(), nullptr, nullptr, 1, &period};
  const bool tangent = options.sensitivity == Sensitivity::state;
  lanes::Carried carried;
  static const LaneKernels one_lane = lane_kernels(LaneWidth::one);
  one_lane.carry(
      {lane->law, lane->cubic, propagator.options().tolerance, propagator.options().max_steps, tangent, &motion, 1, &carried});
  if (carried.periods == 0 || static_cast<std::size_t>(period.impacts) > options.max_events) return false;
  propagator.count_time(t1);
  out.factors.clear();
  out.factor_log_dets.clear();
  out.events.clear();
  out.log_det = out.liouville = 0.0;
  out.termination = Termination::time;
  out.x1.resize(2);
  out.x1 << period.x, period.v;
  out.mode0 = out.mode1 = 0;
  out.event_sequence.assign(static_cast<std::size_t>(period.impacts), lane->hit);
  if (!tangent) return true;
  out.Phi.resize(2, 2);
  out.Psi.resize(2, 0);
  out.Phi << period.Phi[0], period.Phi[1], period.Phi[2], period.Phi[3];
  out.log_det = std::log(std::abs(period.det));
  out.liouville = period.liouville;
  return true;
}

}  // namespace

void carry(Propagator& propagator, double t0, double t1, const Vector& x0, const TransitionOptions& options, Transition& out) {
  constexpr auto all = std::numeric_limits<std::size_t>::max();
  if (carry_in_lane(propagator, t0, t1, x0, options, out)) return;
  Composer composer(propagator, options, out);
  if (!composer.start(t0, x0)) return;
  if (options.left_out) {
    const LeftOutContact& gap = *options.left_out;
    if (!composer.run(t1, gap.events_before) || !composer.coast(std::min(gap.t_touch, t1))) return;
    composer.record_touch();
    if (!composer.coast(std::min(gap.t_resume, t1))) return;
  }
  if (composer.run(t1, all)) composer.finish(t0);
}

void carry_period(Propagator& propagator, const Vector& x0, const TransitionOptions& options, Transition& out) {
  if (is_forced(propagator.system())) {
    out.duration = forcing_period(propagator.system(), propagator.parameters());
    return carry(propagator, 0.0, out.duration, x0, options, out);
  }
  Composer composer(propagator, options, out);
  if (composer.start_period(x0) && composer.run_to_return()) composer.finish(0.0);
}

}  // namespace graze
