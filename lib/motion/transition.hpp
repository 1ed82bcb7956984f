// SPDX-License-Identifier: GPL-3.0-or-later
// Transition: a state carried from t0 to t1 through all events on the way, with the first-order map along it.
//
//     dx1 = Phi dx0 + Psi dp   (t0, t1 fixed),    Phi = product of segment transition and saltation matrices.
// The factors are kept one by one for the multipliers in product form. A start in a mode with constraints is first moved onto
// them (settle_on_constraints): rounding, or a guess, may have left them.
//
// A period of a forced system is a forcing period from phase 0. A period of an autonomous system is the motion from right after
// a return (returns_of) to right after the next, and the map from state to state is the return map:
//     dx1 = (Phi + f1 g^T) dx0,    g = gradient of the time of return in x0 = -(h_x Phi-)^T / (dh/dt),
// with h the guard of the return, Phi- the first-order map to right before it, f1 the field right after it.
#pragma once

#include <graze/lib/motion/propagator.hpp>

namespace graze {

/// A contact to be left out: after `events_before` events the motion ignores the guards until t_resume, and is recorded at
/// t_touch. This is the smooth continuation of a motion that just touches a barrier.
struct LeftOutContact {
  std::size_t events_before = 0;
  double t_touch = 0.0;
  double t_resume = 0.0;
};

/// State and first-order map at LeftOutContact::t_touch.
struct Touch {
  double t = 0.0;
  Vector x;
  std::size_t mode = 0;
  Matrix Phi, Psi;
};

struct Transition {
  Termination termination = Termination::failed;  ///< time: success
  Vector x1;
  std::size_t mode0 = 0, mode1 = 0;  ///< at t0 and t1
  Matrix Phi;
  Matrix Psi;
  std::vector<Matrix> factors;              ///< Phi = factors.back() ... factors.front(); if TransitionOptions::keep_factors
  std::vector<double> factor_log_dets;      ///< their ln|det| from Liouville's identity; NaN where it does not apply
  std::vector<EventRecord> events;          ///< if TransitionOptions::keep_events
  std::vector<std::size_t> event_sequence;  ///< indices of the events, always
  Touch touch;                              ///< if TransitionOptions::left_out
  double log_det = 0.0;    ///< sum of ln|det| of the factors, from their entries; NaN if it is lost to cancellation
  double liouville = 0.0;  ///< the same from Liouville's identity: divergence and volume changes of the contact laws
  int lost = 0;            ///< directions of disturbances that are lost for sure: at most n - rank of Phi; 0 for two states
  double duration = 0.0;   ///< of a period (carry_period)
  Matrix return_map;       ///< first-order map from return to return, of an autonomous system (carry_period); else empty
};

/// First-order map of a period from state to state.
inline const Matrix& period_map(const Transition& period) {
  return period.return_map.size() > 0 ? period.return_map : period.Phi;
}

struct TransitionOptions {
  Sensitivity sensitivity = Sensitivity::state;
  bool keep_factors = false;
  bool keep_events = false;
  std::size_t max_events = 10000;
  std::optional<LeftOutContact> left_out = {};
  /// The mode at the start if the state is in none, but near the constraints of this one: it is moved onto them.
  std::optional<std::size_t> held_mode = {};
};

/// Carries x0 from t0 to t1. A start that is not admissible is a termination, not an exception.
/// @throws std::invalid_argument for a state of the wrong size.
void carry(Propagator& propagator, double t0, double t1, const Vector& x0, const TransitionOptions& options, Transition& out);

/// Carries x0 over one period: a forcing period, or up to the next return. With Termination::no_return, x1 is the state
/// reached.
void carry_period(Propagator& propagator, const Vector& x0, const TransitionOptions& options, Transition& out);

}  // namespace graze
