// SPDX-License-Identifier: GPL-3.0-or-later
// LinearFlow: x'' + 2 b x' + k x = A cos(w t) + c in closed form,
//     z(t) = z_p(t) + Phi(t - t0) (z(t0) - z_p(t0)),   z = (x, x'),
//     Phi(s) = e^{-b s} [[C + b S, S], [-k S, C - b S]],   C = cos(q s), S = sin(q s)/q, q^2 = k - b^2 (any sign),
// with its derivatives in b, k, A, w, c. Free of discretisation; only the instant of an event needs a root.
//
// No crossing is ever missed: from the current instant, sign (x - level) is bounded from above by its Taylor polynomial of
// degree 5 plus M6 h^6/720, where M6 >= |x^(6)| over the rest of the flight follows from the energy of the transient (which
// only decays) and the forced amplitude. The polynomial's Bernstein coefficients show how far the motion goes without a
// crossing. Where the speed certainly keeps its sign, the root is unique, and found by Halley's method.
#pragma once

#include <graze/lib/flow/flow.hpp>
#include <graze/lib/flow/level_barriers.hpp>

namespace graze {

class LinearFlow {
 public:
  LinearFlow(const HybridSystem& system, std::size_t mode, const Vector& p, std::span<const std::size_t> active,
             const LinearOscillator& oscillator, std::size_t max_steps);

  /// Whether the closed form holds: stiffness > 0, away from undamped resonance, all guards of the mode are levels of x, and
  /// the active parameters are covered.
  static bool applies(const HybridSystem& system, std::size_t mode, std::span<const std::size_t> active,
                      const LinearOscillator& oscillator);

  void carry(const FlowTask& task, const Vector& x0, Segment& out) const;
  void field(double t, const Vector& x, Vector& out) const;

 private:
  struct Damped;  // exp(-b s) C(s), exp(-b s) S(s), exp(-b s)
  struct Point;   // displacement and the first derivatives of x at an instant
  struct Flight;  // the transient of one segment
  Flight depart(double t0, const Vector& x0) const;
  Damped damped(double s) const;
  /// exp(-b s) dS/d(q^2).
  double dS_dq2(double s, const Damped& f) const;
  /// `known`: damped(s), if the caller has it.
  Point at(const Flight& flight, double s, const Damped* known = nullptr) const;
  /// The first crossing of the barrier up to s_end. nullopt: there is none, or the search was given up because `evaluations`
  /// reached max_steps.
  std::optional<double> first_crossing(const Flight& flight, const detail::LevelBarrier& barrier, double s_end,
                                       std::size_t& evaluations) const;
  /// Phi and Psi of out's stretch, of duration s.
  void sensitivities(const Damped& f, double s, bool with_parameters, Segment& out) const;

  LinearOscillator coefficient_;
  std::size_t max_steps_;
  double q2_ = 0.0, cosine_ = 0.0, sine_ = 0.0, offset_ = 0.0;  // x_p = cosine cos(w t) + sine sin(w t) + offset
  double forced_ = 0.0;                                         // hypot(cosine, sine)
  Eigen::Matrix<double, 3, 5> particular_dq_;                   // d(cosine, sine, offset)/d(b, k, A, w, c)
  Matrix active_dp_;                                            // 5 x active
  std::vector<detail::LevelBarrier> barriers_;
};

}  // namespace graze
