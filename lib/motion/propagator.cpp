// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lanes/oscillator.hpp>
#include <graze/lib/motion/propagator.hpp>
#include <graze/lib/motion/unbounded.hpp>
#include <graze/lib/system/guard_rounding.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace graze {

namespace {

/// At one instant, after the first number of events, impacts of negligible speed are plastic; after the second the motion
/// continues in the mode of its state (mode_at); after the third the run ends with Termination::event_limit.
constexpr int many_at_instant = 32, settle_at_instant = 256, most_at_instant = 512;

}  // namespace

Propagator::Propagator(const SharedSystem& system, const Vector& p, std::vector<std::size_t> active, const FlowOptions& options)
    : system_(system), active_(std::move(active)), options_(options), events_of_mode_(system->modes.size()) {
  validate(*system);
  validate(options);
  for (const std::size_t parameter : active_)
    if (parameter >= system->parameters.size())
      throw std::invalid_argument(
          fmt::format("sensitivity in parameter number {} was asked for; system {} has {} (counted from 0)", parameter,
                      system->name, system->parameters.size()));
  const auto n = static_cast<Eigen::Index>(system->states);
  for (std::size_t i = 0; i < system->events.size(); ++i) events_of_mode_[system->events[i].from].push_back(i);
  is_return_.resize(system->events.size());
  if (!is_forced(system))
    for (const std::size_t event : returns_of(system)) is_return_[event] = true;
  for (Vector* v : {&f_minus_, &f_plus_, &gradient_, &f_dt_, &glance_}) v->resize(n);
  f_dx_.resize(n, n);
  record_.x_plus.setConstant(n, std::numeric_limits<double>::quiet_NaN());  // no state is the one behind an event yet
  set_parameters(p);
}

void Propagator::set_parameters(const Vector& p) {
  check_parameters(system_->parameters, p);
  p_ = p;
  time_unit_ = time_unit(*system_, p);
  lane_known_ = plus_known_ = false;
  flows_.clear();
  for (std::size_t mode = 0; mode < system_->modes.size(); ++mode)
    flows_.push_back(make_flow(system_, mode, p_, active_, options_));
}

const lanes::Oscillator* Propagator::one_lane() {
  if (!lane_known_) {
    lane_known_ = true;
    one_lane_.reset();
    if (options_.kind == FlowKind::automatic)
      // One lane is no faster than the flows for Hertz contacts and cantilevers.
      if (auto lane = lanes::lane_oscillator(*system_, p_); lane && lane->law == lanes::Law::restitution && !lane->cubic)
        one_lane_ = std::make_shared<const lanes::Oscillator>(std::move(*lane));
  }
  return one_lane_.get();
}

HybridState Propagator::start(double t, const Vector& x) const { return {t, x, initial_mode(*system_, t, x, p_)}; }

std::optional<HybridState> Propagator::start_period(const Vector& x) {
  const std::optional<std::size_t> mode = mode_at(*system_, 0.0, x, p_);
  if (!mode) return std::nullopt;
  HybridState state{0.0, x, *mode};
  for (const std::size_t event : events_of_mode_[state.mode]) {
    if (!is_return_[event] || system_->events[event].reset.map || !active_at_start(state, event)) continue;
    state.mode = system_->events[event].to;
    break;
  }
  return state;
}

std::optional<Termination> Propagator::period_end(const HybridState& state) const {
  if (!is_return_[record_.event] || record_.t <= at_once) return std::nullopt;
  Vector f(state.x.size());
  field(state.mode, state.t, state.x, f);
  return is_at_equilibrium(f, state.t, state.x) ? Termination::no_return : Termination::time;
}

double Propagator::guard_acceleration(const Guard& guard, std::size_t mode, double t, const Vector& x, const Vector& f) {
  // d2h/dt2 = D_x h (f_x f + f_t), plus the terms of a curved or moving guard.
  const Mode& description = system_->modes[mode];
  description.field_dx(t, x, p_, f_dx_);
  if (description.field_dt) {
    description.field_dt(t, x, p_, f_dt_);
  } else {
    f_dt_.setZero();
  }
  f_dt_.noalias() += f_dx_ * f;
  guard.dx(t, x, p_, gradient_);
  return gradient_.dot(f_dt_) + transversality_change(guard, t, x, f, p_, 1.0, f);
}

double Propagator::guard_value(const HybridState& state, std::size_t index) const {
  const Guard& guard = system_->events[index].guard;
  return guard.level ? guard.level->sign * (state.x[static_cast<Eigen::Index>(guard.level->coordinate)] -
                                            p_[static_cast<Eigen::Index>(guard.level->level)])
                     : guard.value(state.t, state.x, p_);
}

bool Propagator::is_behind_last_event(const HybridState& state) const {
  return state.t == record_.t && state.mode == record_.mode_plus && state.x == record_.x_plus;
}

bool Propagator::is_past_a_guard(const HybridState& state) const {
  const std::vector<std::size_t>& events = events_of_mode_[state.mode];
  return std::any_of(events.begin(), events.end(), [&](std::size_t event) {
    const double h = guard_value(state, event);
    return h > 0.0 && h > guard_width(guard_scale(system_->events[event].guard, state.t, state.x, p_), state.t, state.x);
  });
}

bool Propagator::active_at_start(const HybridState& state, std::size_t index) {
  const Guard& guard = system_->events[index].guard;
  const double h = guard_value(state, index);
  const GuardScale scale = guard_scale(guard, state.t, state.x, p_);
  const double tolerance = guard_width(scale, state.t, state.x);
  if (h < -tolerance) return false;
  if (h > tolerance) return true;
  const Flow& flow = flows_[state.mode];
  const bool just_crossed = plus_known_ && is_behind_last_event(state);
  // A release begins at a balance of forces: a mass held until then rests, although the rounding of the forces moves it.
  bool released = false;
  if (just_crossed && record_.kind == EventKind::release) {
    flows_[system_->events[record_.event].from].field(state.t, state.x, f_minus_);
    released = rests(transversality(guard, state.t, state.x, f_minus_, p_), scale, f_minus_);
  }
  if (just_crossed) {
    f_minus_ = f_plus_;
  } else {
    flow.field(state.t, state.x, f_minus_);
  }
  const double speed = transversality(guard, state.t, state.x, f_minus_, p_);
  if (!released && !rests(speed, scale, f_minus_)) return speed > 0.0;
  const auto field = [&](double t, const Vector& x, Vector& out) { flow.field(t, x, out); };
  return rate_after(rest_glance * time_unit_, guard, field, state.t, state.x, p_, f_minus_, glance_) > 0.0;
}

std::size_t Propagator::fired(const HybridState& state, std::size_t index) const {
  for (;;) {
    const auto& otherwise = system_->events[index].otherwise;
    if (!otherwise || otherwise->condition(state.t, state.x, p_) > 0.0) return index;
    index = otherwise->event;
  }
}

void Propagator::snap_to_guard(HybridState& state, std::size_t index) const {
  if (const auto& level = system_->events[index].guard.level)
    state.x[static_cast<Eigen::Index>(level->coordinate)] = p_[static_cast<Eigen::Index>(level->level)];
}

StepEnd Propagator::step(HybridState& state, double t_end, Sensitivity sensitivity) {
  endless_ = false;
  for (const std::size_t event : events_of_mode_[state.mode]) {
    if (!active_at_start(state, event)) continue;
    if (!is_behind_last_event(state)) leave_instant();
    snap_to_guard(state, event);
    const std::size_t first = fired(state, event);
    const auto n = static_cast<Eigen::Index>(system_->states);
    segment_.mode = state.mode;
    segment_.t0 = segment_.t1 = state.t;
    segment_.x0 = segment_.x1 = state.x;
    segment_.end = FlowEnd::event;
    segment_.event = first;
    segment_.evaluations = 0;
    segment_.divergence = 0.0;
    if (sensitivity != Sensitivity::none) {
      segment_.Phi.setIdentity(n, n);
      segment_.Psi.setZero(n, sensitivity == Sensitivity::state ? 0 : static_cast<Eigen::Index>(active_.size()));
    }
    if (++at_instant_ > most_at_instant) {
      leave_instant();
      endless_ = true;
      return StepEnd::failed;
    }
    cross(state, first, t_end, sensitivity);
    return StepEnd::event;
  }
  if (state.t >= t_end) t_end = state.t;
  flows_[state.mode].carry({state.t, t_end, sensitivity}, state.x, segment_);
  time_carried_ += segment_.t1 - segment_.t0;
  if (segment_.t1 > segment_.t0) leave_instant();
  if (segment_.end == FlowEnd::failed) return StepEnd::failed;
  most_evaluations_ = std::max(most_evaluations_, segment_.evaluations);
  state.t = segment_.t1;
  state.x = segment_.x1;
  // Rounding can hide an event from the flow: one exactly at the end time, or one declared earlier at the same instant.
  for (const std::size_t event : events_of_mode_[segment_.mode]) {
    if (segment_.end == FlowEnd::event && event >= segment_.event) break;
    if (!active_at_start(state, event)) continue;
    segment_.end = FlowEnd::event;
    segment_.event = event;
    snap_to_guard(state, event);
    segment_.x1 = state.x;
    break;
  }
  if (segment_.end == FlowEnd::time) return StepEnd::time;
  segment_.event = fired(state, segment_.event);
  cross(state, segment_.event, t_end, sensitivity);
  return StepEnd::event;
}

void Propagator::leave_instant() {
  at_instant_ = 0;
  fastest_at_instant_ = 0.0;
  followed_.clear();
}

Termination Propagator::failure() const {
  if (endless_) return Termination::event_limit;
  const bool grows = escapes(*system_, p_, segment_.mode, segment_.x1);
  return grows ? Termination::escape : Termination::integration_failed;
}

bool Propagator::coast(HybridState& state, double t_end, Sensitivity sensitivity) {
  flows_[state.mode].carry({state.t, t_end, sensitivity, false}, state.x, segment_);
  time_carried_ += segment_.t1 - segment_.t0;
  if (segment_.end != FlowEnd::time) return false;
  state.t = segment_.t1;
  state.x = segment_.x1;
  return true;
}

void Propagator::cross(HybridState& state, std::size_t index, double t_end, Sensitivity sensitivity) {
  const Event& event = system_->events[index];
  record_.event = index;
  record_.kind = event.kind;
  record_.is_chatter = false;
  record_.t = state.t;
  record_.x_minus = state.x;
  flows_[event.from].field(state.t, state.x, f_minus_);
  if (const auto& rebound = event.reset.rebound) {
    const auto velocity = static_cast<Eigen::Index>(rebound->velocity);
    state.x[static_cast<Eigen::Index>(rebound->coordinate)] = p_[static_cast<Eigen::Index>(rebound->level)];
    state.x[velocity] = -p_[static_cast<Eigen::Index>(rebound->coefficient)] * record_.x_minus[velocity];
  } else if (event.reset.map) {
    event.reset.map(state.t, record_.x_minus, p_, state.x);
  }
  state.mode = event.to;
  const bool settles = at_instant_ == settle_at_instant;
  if (settles) state.mode = mode_at(*system_, state.t, state.x, p_).value_or(event.to);
  record_.x_plus = state.x;
  record_.mode_plus = state.mode;
  record_.follows = !followed_.empty();
  record_.is_followed = false;
  record_.mass = event.effective_mass ? event.effective_mass(state.t, record_.x_minus, p_) : 1.0;
  record_.normal_speed = transversality(event.guard, state.t, record_.x_minus, f_minus_, p_);
  flows_[state.mode].field(state.t, state.x, f_plus_);
  plus_known_ = true;
  record_.exit_speed = event.opening_rate               ? event.opening_rate(state.t, state.x, p_)
                       : event.kind == EventKind::leave ? record_.normal_speed
                                                        : -transversality(event.guard, state.t, state.x, f_plus_, p_);
  f_before_ = f_minus_;
  const Rest rest = event.accumulation && !settles ? accumulate(state, event, t_end) : Rest::none;
  if (sensitivity == Sensitivity::none) return;
  if (rest == Rest::at_impact) flows_[state.mode].field(state.t, state.x, f_plus_);
  const std::span<const std::size_t> active =
      sensitivity == Sensitivity::state ? std::span<const std::size_t>{} : std::span<const std::size_t>(active_);
  const bool jumps_on = rest != Rest::after_chatter && !is_return_[index] && is_past_a_guard(state);
  if (rest == Rest::after_chatter) {
    saltation_of_rest(event, active);
  } else if (record_.follows || jumps_on || rest == Rest::at_impact) {
    if (!record_.follows) f_followed_ = f_before_;
    followed_.push_back({&event.guard, rest == Rest::none ? &event.reset : &event.accumulation->reset, record_.x_minus});
    compose_saltation(record_.x_plus, f_plus_, active);
    if (!record_.saltation.regular && rest == Rest::at_impact && !record_.follows) saltation_of_rest(event, active);
  } else {
    saltation(event, {record_.t, record_.x_minus, record_.x_plus, f_before_, f_plus_}, p_, active, record_.saltation);
  }
  record_.is_followed = jumps_on && record_.saltation.regular;
  if (record_.is_followed) {
    record_.saltation.S.setIdentity();
    record_.saltation.Sp.setZero();
  } else {
    followed_.clear();
  }
}

void Propagator::compose_saltation(const Vector& x_plus, const Vector& f_plus, std::span<const std::size_t> active) {
  const double t = record_.t;
  const Eigen::Index n = x_plus.size();
  Event all;
  all.guard = *followed_.front().guard;
  all.reset.map = [](double, const Vector& x, const Vector&, Vector& out) { out = x; };  // the derivatives alone are wanted
  Matrix dx = Matrix::Identity(n, n), dp = Matrix::Zero(n, p_.size());
  Vector dt = Vector::Zero(n);
  for (const Jump& jump : followed_) {
    const Reset& reset = *jump.reset;
    if (!reset.map) continue;
    Matrix own_dx(n, n), own_dp = Matrix::Zero(n, p_.size());
    Vector own_dt = Vector::Zero(n);
    reset.dx(t, jump.x_minus, p_, own_dx);
    if (reset.dp) reset.dp(t, jump.x_minus, p_, own_dp);
    if (reset.dt) reset.dt(t, jump.x_minus, p_, own_dt);
    dx = own_dx * dx;
    dp = own_dx * dp + own_dp;
    dt = own_dx * dt + own_dt;
  }
  all.reset.dx = [&](double, const Vector&, const Vector&, Matrix& out) { out = dx; };
  all.reset.dp = [&](double, const Vector&, const Vector&, Matrix& out) { out = dp; };
  all.reset.dt = [&](double, const Vector&, const Vector&, Vector& out) { out = dt; };
  saltation(all, {t, followed_.front().x_minus, x_plus, f_followed_, f_plus}, p_, active, record_.saltation);
}

Propagator::Rest Propagator::accumulate(HybridState& state, const Event& event, double t_end) {
  const double t_impact = state.t;
  const double before = record_.normal_speed;
  const double after = std::max(0.0, record_.exit_speed);
  // At a level guard with a Rebound, the pressing acceleration is the field's velocity component.
  const double pressing = event.reset.rebound && event.guard.level
                              ? event.guard.level->sign * f_plus_[static_cast<Eigen::Index>(event.reset.rebound->velocity)]
                          : event.accumulation->pressing ? event.accumulation->pressing(state.t, state.x, p_)
                                                         : guard_acceleration(event.guard, event.to, state.t, state.x, f_plus_);
  const double unit = std::min(1.0, 2.0 * std::numbers::pi * time_unit_);
  const double instant = 1e-12 * (unit + std::abs(state.t));  // a flight this short counts as none
  double remaining = 0.0;
  fastest_at_instant_ = std::max(fastest_at_instant_, before);
  // Impacts of several stops upon each other, at one instant, shrink like the powers of a number: they have an end, too.
  constexpr double negligible = 1e-12;
  const bool fades = at_instant_ > many_at_instant && before < negligible * fastest_at_instant_;
  const bool moving = !fades && before > 0.0 && !rests(before, guard_scale(event.guard, t_impact, record_.x_minus, p_), f_minus_);
  if (moving) {
    if (!(pressing > 0.0)) return Rest::none;
    const double flight = 2.0 * after / pressing;
    if (flight > instant) {
      if (after >= before) return Rest::none;  // no loss: a series of equal flights does not end
      remaining = flight / (1.0 - after / before);
      // Where the mass is hardly pressed to its stop, near its release, bounces that are lower than the state's rounding may last
      // long. They count as complete, too: their impacts come at the wrong speed, which would keep them going.
      const double height = 0.5 * after * after / pressing;
      const bool resolved = height > std::numeric_limits<double>::epsilon() * (1.0 + state.x.lpNorm<Eigen::Infinity>());
      if (resolved && !(remaining < options_.accumulation_window * unit)) return Rest::none;
    }
  } else if (!(pressing > -guard_tolerance)) {
    return Rest::none;  // at rest and pulled away (in balance, the guards of the sticking mode decide)
  }
  if (remaining > t_end - state.t) {  // the run ends within the series
    if (remaining > instant) return Rest::none;
    remaining = std::max(0.0, t_end - state.t);
  }
  const Accumulation& rest = *event.accumulation;
  const Vector here = state.x;
  // Where other masses move along, the series is one plastic impact, after which the mass is held. The stop acts in one direction
  // only: on the way the motion differs from the held one by the bounce in this direction alone, which is over at the
  // accumulation point. The rest is of third order in the remaining time, and of second order in the derivative.
  const bool others_move = moving && system_->states > 2;
  if (others_move) {
    state.x = record_.x_minus;
  } else {
    state.t += remaining;
    state.x += remaining * f_plus_;
  }
  rest.reset.map(state.t, Vector(state.x), p_, state.x);
  if (others_move && remaining == 0.0) {
    // A plastic impact. A body that it tears from the mass, or drives against it, is not held.
    constexpr double rounding = 1e-9;
    const double torn = (state.x - here).lpNorm<Eigen::Infinity>();
    if (torn > rounding * before + guard_tolerance * (1.0 + here.lpNorm<Eigen::Infinity>())) {
      state.x = here;
      return Rest::none;
    }
  }
  state.mode = rest.sticking_mode;
  // The mass is held only if it is pressed to the stop at the accumulation point too. At rest, other bodies that hit it do not
  // matter.
  for (const std::size_t other : events_of_mode_[state.mode]) {
    if (!moving && begins_contact(system_->events[other].kind)) continue;
    if (active_at_start(state, other)) {
      state.t = t_impact;
      state.x = here;
      state.mode = event.to;
      return Rest::none;
    }
  }
  plus_known_ = false;
  record_.kind = EventKind::stick;
  record_.is_chatter = true;
  record_.t = state.t;
  record_.exit_speed = 0.0;
  record_.x_plus = state.x;
  record_.mode_plus = state.mode;
  rest_from_ = here;
  return others_move ? Rest::at_impact : Rest::after_chatter;
}

void Propagator::saltation_of_rest(const Event& event, std::span<const std::size_t> active) {
  SaltationMatrix own;
  const Eigen::Index n = record_.x_plus.size(), m = static_cast<Eigen::Index>(active.size());
  own.regular = true;
  own.transversality = record_.normal_speed;
  own.S.resize(n, n);
  const Reset& reset = event.accumulation->reset;
  reset.dx(record_.t, rest_from_, p_, own.S);
  own.Sp.setZero(n, m);
  if (reset.dp && m > 0) {
    Matrix dp = Matrix::Zero(n, p_.size());
    reset.dp(record_.t, rest_from_, p_, dp);
    for (Eigen::Index k = 0; k < m; ++k) own.Sp.col(k) = dp.col(static_cast<Eigen::Index>(active[static_cast<std::size_t>(k)]));
  }
  if (record_.follows) {
    compose_saltation(record_.x_minus, f_before_, active);
    own.regular = record_.saltation.regular;
    own.Sp += own.S * record_.saltation.Sp;
    own.S = own.S * record_.saltation.S;
  }
  record_.saltation = std::move(own);
}

}  // namespace graze
