// SPDX-License-Identifier: GPL-3.0-or-later
// GSL's Prince-Dormand pair of order 8(7) with GSL's own step control. It has no dense output. The motion inside a step is a
// partial step of the same method, for the state alone during the root search and for all variables at the root.
#pragma once

#include "oscillator.hpp"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include <memory>

namespace baselines {

/// Whole: the field of all variables; Motion: the field of the state alone, which is the first part of the whole.
template <class Whole, class Motion> class GslRk8pdOf {
  static constexpr std::size_t N = Whole::size, motion = Motion::size;

 public:
  GslRk8pdOf(const typename Whole::Parameters& p, double tolerance, Watch watch)
      : watch_(watch), field_{p}, field_of_state_{p}, step_(gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk8pd, N)),
        step_of_state_(gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk8pd, motion)),
        control_(gsl_odeiv2_control_y_new(tolerance, tolerance)), evolve_(gsl_odeiv2_evolve_alloc(N)) {}

  Stretch carry(bool in_contact, double t, double t_end, State<N>& u) {
    field_.in_contact = field_of_state_.in_contact = in_contact;
    const double sign = field_.direction(), r = field_.p.r;
    const gsl_odeiv2_system system{callback<Whole>, nullptr, N, &field_};
    const gsl_odeiv2_system system_of_state{callback<Motion>, nullptr, motion, &field_of_state_};
    gsl_odeiv2_evolve_reset(evolve_.get());
    gsl_odeiv2_step_reset(step_.get());
    double& h_kept = sizes_[in_contact ? 1 : 0];
    double h = h_kept;
    const auto inside = [&](double t0, const State<N>& from, double s) {
      State<motion> z;
      std::copy_n(from.begin(), motion, z.begin());
      double error[motion];
      gsl_odeiv2_step_apply(step_of_state_.get(), t0, s, z.data(), error, nullptr, nullptr, &system_of_state);
      return z;
    };
    while (t < t_end) {
      const State<N> before = u;
      const double t_before = t;
      if (gsl_odeiv2_evolve_apply(evolve_.get(), control_.get(), step_.get(), &system, &t, t_end, &h, u.data()) != GSL_SUCCESS)
        return {t, false, true};
      if (t < t_end) h_kept = h;
      const auto guard = [&](double s) {
        const State<motion> z = inside(t_before, before, s);
        return Guard{sign * (z[0] - r), sign * z[1]};
      };
      const auto speed = [&](double s) {
        const State<motion> z = inside(t_before, before, s);
        double dz[motion];
        field_of_state_(t_before + s, z.data(), dz);
        return Guard{sign * z[1], sign * dz[1]};
      };
      const double s = crossing(watch_, {sign * (before[0] - r), sign * before[1]}, {sign * (u[0] - r), sign * u[1]},
                                t - t_before, guard, speed);
      if (s < 0.0) continue;
      u = before;
      double error[N];
      gsl_odeiv2_step_apply(step_.get(), t_before, s, u.data(), error, nullptr, nullptr, &system);
      return {t_before + s, true, false};
    }
    return {t_end, false, false};
  }

 private:
  template <class Field> static int callback(double t, const double u[], double du[], void* field) {
    (*static_cast<const Field*>(field))(t, u, du);
    return GSL_SUCCESS;
  }
  struct Free {
    void operator()(gsl_odeiv2_step* s) const { gsl_odeiv2_step_free(s); }
    void operator()(gsl_odeiv2_control* c) const { gsl_odeiv2_control_free(c); }
    void operator()(gsl_odeiv2_evolve* e) const { gsl_odeiv2_evolve_free(e); }
  };
  Watch watch_;
  Whole field_;
  Motion field_of_state_;
  std::unique_ptr<gsl_odeiv2_step, Free> step_, step_of_state_;
  std::unique_ptr<gsl_odeiv2_control, Free> control_;
  std::unique_ptr<gsl_odeiv2_evolve, Free> evolve_;
  double sizes_[2] = {1e-2, 1e-2};  // of steps in flight and in contact, kept from one stretch to the next of its kind
};

template <Law law, std::size_t N> class GslRk8pd : public GslRk8pdOf<Field<law, N>, Field<law, 2>> {
 public:
  using GslRk8pdOf<Field<law, N>, Field<law, 2>>::GslRk8pdOf;
};

}  // namespace baselines
