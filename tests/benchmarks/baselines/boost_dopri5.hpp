// SPDX-License-Identifier: GPL-3.0-or-later
// Boost.odeint's Dormand-Prince pair of order 5(4). Events are located in its dense output. The state at an event is then a
// plain step from the start of the step, corrected once by Newton's method: the interpolant of order 4 would lose accuracy.
#pragma once

#include "oscillator.hpp"

#include <boost/numeric/odeint.hpp>

namespace baselines {

template <class Field> class BoostDopri5Of {
  static constexpr std::size_t N = Field::size;
  using Stepper = boost::numeric::odeint::runge_kutta_dopri5<State<N>>;

 public:
  BoostDopri5Of(const typename Field::Parameters& p, double tolerance, Watch watch)
      : watch_(watch), field_{p}, dense_(boost::numeric::odeint::make_dense_output(tolerance, tolerance, Stepper())) {}

  Stretch carry(bool in_contact, double t, double t_end, State<N>& u) {
    field_.in_contact = in_contact;
    const double sign = field_.direction(), r = field_.p.r;
    const auto system = [this](const State<N>& z, State<N>& dz, double at) { field_(at, z.data(), dz.data()); };
    double& h_kept = sizes_[in_contact ? 1 : 0];
    dense_.initialize(u, t, h_kept);
    for (int steps = 0; steps < 100000; ++steps) {
      const auto [t_before, t_after] = dense_.do_step(system);
      h_kept = dense_.current_time_step();
      // Not past the end: events beyond it do not belong to this run.
      const double t0 = t_before, h = std::min(t_after, t_end) - t0;
      const State<N>& before = dense_.previous_state();
      State<N> z = dense_.current_state();
      if (t_after > t_end) dense_.calc_state(t_end, z);
      const auto guard = [&](double s) {
        State<N> y;
        dense_.calc_state(t0 + s, y);
        return Guard{sign * (y[0] - r), sign * y[1]};
      };
      const auto speed = [&](double s) {
        State<N> y, dy;
        dense_.calc_state(t0 + s, y);
        field_(t0 + s, y.data(), dy.data());
        return Guard{sign * y[1], sign * dy[1]};
      };
      const Guard a{sign * (before[0] - r), sign * before[1]}, b{sign * (z[0] - r), sign * z[1]};
      double s = crossing(watch_, a, b, h, guard, speed);
      if (s >= 0.0) {
        step(system, before, t0, s, u);
        const double correction = (r - u[0]) / u[1];
        if (std::abs(correction) < 0.1 * h) {
          s += correction;
          step(system, State<N>(u), t0 + s - correction, correction, u);
        }
        return {t0 + s, true, false};
      }
      if (t_after >= t_end) {
        step(system, before, t0, h, u);
        return {t_end, false, false};
      }
    }
    return {t_end, false, true};
  }

 private:
  /// A plain step. The method keeps the last derivative of the step before (FSAL), which is not that of `from`.
  template <class System> void step(const System& system, const State<N>& from, double t, double h, State<N>& to) {
    stepper_.reset();
    stepper_.do_step(system, from, t, to, h);
  }

  Watch watch_;
  Field field_;
  typename boost::numeric::odeint::result_of::make_dense_output<Stepper>::type dense_;
  Stepper stepper_;
  double sizes_[2] = {1e-2, 1e-2};  // of steps in flight and in contact, kept from one stretch to the next of its kind
};

template <Law law, std::size_t N> class BoostDopri5 : public BoostDopri5Of<Field<law, N>> {
 public:
  using BoostDopri5Of<Field<law, N>>::BoostDopri5Of;
};

}  // namespace baselines
