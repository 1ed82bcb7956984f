// SPDX-License-Identifier: GPL-3.0-or-later
// Propagator: carries a hybrid state through flow, event, reset and next flow. All consumers of motion (trajectories,
// shooting, exponents, sweeps) use it, or a LaneCarrier for many periods at once in SIMD lanes. It keeps the flows
// of all modes and their buffers, so that a new stretch allocates nothing.
//
// Chattering (infinitely many impacts in finite time): the flights form a geometric series of remaining time
// 2 u+ / (a (1 - e)), with u+ the speed after the impact, e = u+/u-, a the pressing acceleration. When it falls below
// FlowOptions::accumulation_window, the run jumps to the accumulation point and continues in the sticking mode. The event is
// then recorded as EventKind::stick, with t and x_plus of the accumulation point and x_minus of the last impact before it. With
// more than two states it is recorded as a plastic impact in place of that last one (accumulate() says why). A mass at rest at
// its stop sticks too, for any e. A run never jumps past its end time.
#pragma once

#include <graze/lib/motion/trajectory.hpp>

#include <functional>
#include <memory>
#include <span>

namespace graze::lanes {
struct Oscillator;
}

namespace graze {

struct HybridState {
  double t = 0.0;
  Vector x;
  std::size_t mode = 0;
};

enum class StepEnd { failed, time, event };

/// An autonomous motion without a return within this dimensionless time does not return.
inline constexpr double longest_return = 1e4;
/// An event within this time after the start of a period belongs to the start and does not end the period.
inline constexpr double at_once = 1e-12;

class Propagator {
 public:
  /// `active` are the indices of the parameters for sensitivities.
  Propagator(const SharedSystem& system, const Vector& p, std::vector<std::size_t> active = {}, const FlowOptions& options = {});

  const HybridSystem& system() const { return *system_; }
  const Vector& parameters() const { return p_; }
  const std::vector<std::size_t>& active() const { return active_; }
  const FlowOptions& options() const { return options_; }
  /// Sets the parameter values and rebuilds the flows.
  void set_parameters(const Vector& p);

  /// The hybrid state of `x` at time t. @throws std::invalid_argument if it is not admissible.
  HybridState start(double t, const Vector& x) const;

  /// The same at time 0, the start of a period. A state right after a return does not meet that return again. Empty: not
  /// admissible.
  std::optional<HybridState> start_period(const Vector& x);

  /// How the last event, which led to `state`, ends a period of an autonomous system that began at time 0: time, or no_return
  /// if the motion has come to rest. Empty: the period continues.
  std::optional<Termination> period_end(const HybridState& state) const;

  /// Carries `state` to t_end or through the next event, whichever comes first. `segment()` and, after an event, `record()`
  /// describe the step. An event that is active at the start gives a segment of zero length.
  StepEnd step(HybridState& state, double t_end, Sensitivity sensitivity = Sensitivity::none);

  /// Why the last step failed.
  Termination failure() const;

  /// Follows the mode's field to t_end and ignores its guards (for an orbit with one of its impacts left out). False: failure.
  bool coast(HybridState& state, double t_end, Sensitivity sensitivity = Sensitivity::none);

  /// Dimensionless time carried so far in all runs: the measure of cost.
  double time_carried() const { return time_carried_; }

  /// Largest number of evaluations of the field (or of its closed form) in one stretch between two events so far.
  std::size_t most_evaluations() const { return most_evaluations_; }

  /// The oscillator for the fast path: a single lane carries whole forcing periods from phase 0 if only their results are
  /// needed. Null: not a linear impact oscillator with restitution that the lanes support, or FlowOptions::kind is not
  /// automatic.
  const lanes::Oscillator* one_lane();
  /// Adds the time of a period carried on the fast path to time_carried().
  void count_time(double duration) { time_carried_ += duration; }

  /// A state for the caller's run; its storage is reused from run to run.
  HybridState& run() { return run_; }

  const Segment& segment() const { return segment_; }
  const EventRecord& record() const { return record_; }
  /// f(t, x) of a mode.
  void field(std::size_t mode, double t, const Vector& x, Vector& out) const { flows_[mode].field(t, x, out); }

 private:
  /// An event that another one follows at once, and the state before it.
  struct Jump {
    const Guard* guard;
    const Reset* reset;
    Vector x_minus;
  };
  /// How an impact comes to rest: not at all, as a plastic impact, or at the accumulation point.
  enum class Rest { none, at_impact, after_chatter };

  double guard_value(const HybridState& state, std::size_t index) const;
  bool active_at_start(const HybridState& state, std::size_t index);
  bool is_behind_last_event(const HybridState& state) const;
  bool is_past_a_guard(const HybridState& state) const;
  /// The event that fires if the guard of event `index` is met: this event or an alternative.
  std::size_t fired(const HybridState& state, std::size_t index) const;
  void snap_to_guard(HybridState& state, std::size_t index) const;
  void leave_instant();
  void cross(HybridState& state, std::size_t index, double t_end, Sensitivity sensitivity);
  Rest accumulate(HybridState& state, const Event& event, double t_end);
  /// To first order, the accumulation point does not depend on the path to it: the map is the derivative of the reset.
  void saltation_of_rest(const Event& event, std::span<const std::size_t> active);
  /// The saltation matrix of all followed_ events as one.
  void compose_saltation(const Vector& x_plus, const Vector& f_plus, std::span<const std::size_t> active);
  double guard_acceleration(const Guard& guard, std::size_t mode, double t, const Vector& x, const Vector& f);

  SharedSystem system_;
  Vector p_;
  std::vector<std::size_t> active_;
  FlowOptions options_;
  std::vector<Flow> flows_;
  std::vector<std::vector<std::size_t>> events_of_mode_;
  std::vector<bool> is_return_;
  HybridState run_;
  Segment segment_;
  EventRecord record_;
  double time_carried_ = 0.0;
  std::size_t most_evaluations_ = 0;
  bool plus_known_ = false;     // whether f_plus_ is the field right after record_
  std::vector<Jump> followed_;  // events at this instant with EventRecord::is_followed, in order
  Vector f_followed_;           // the field before the first of them
  Vector f_before_;             // the field before the last event
  Vector rest_from_;            // the state from which the last event's accumulation came to rest
  double time_unit_ = 1.0;
  int at_instant_ = 0;               // events at this instant
  double fastest_at_instant_ = 0.0;  // largest speed of their impacts
  bool endless_ = false;             // whether the last step failed for their number
  bool lane_known_ = false;          // whether one_lane_ is up to date
  std::shared_ptr<const lanes::Oscillator> one_lane_;
  Vector f_minus_, f_plus_, gradient_, f_dt_, glance_;
  Matrix f_dx_;
};

}  // namespace graze
