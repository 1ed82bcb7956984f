// SPDX-License-Identifier: GPL-3.0-or-later
// SUNDIALS CVODE with its own root finding: Adams methods, Newton iteration with a dense Jacobian. (The Jacobian is that of
// the motion; its coupling to the sensitivity is left out, because the iteration converges without it.) Of Adams and BDF, each
// with Newton or fixed-point iteration, this was the fastest at 1e-10: BDF of order 5 took two to three times the steps. Every
// event restarts CVODE at order 1, which is its largest cost. Watch::located: the speed of the guard is a second root
// function, so that the run stops at every maximum and detects a crossing just before it.
#pragma once

#include "oscillator.hpp"

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <memory>

namespace baselines {

template <Law law, std::size_t N> class Cvode {
 public:
  Cvode(const Parameters& p, double tolerance, Watch watch) : watch_(watch), field_{p} {
    SUNContext_Create(nullptr, &context_);
    y_ = N_VNew_Serial(static_cast<sunindextype>(N), context_);
    dky_ = N_VNew_Serial(static_cast<sunindextype>(N), context_);
    memory_ = CVodeCreate(CV_ADAMS, context_);
    CVodeInit(memory_, derivative, 0.0, y_);
    CVodeSStolerances(memory_, tolerance, tolerance);
    CVodeSetUserData(memory_, this);
    CVodeSetErrFile(memory_, nullptr);
    matrix_ = SUNDenseMatrix(static_cast<sunindextype>(N), static_cast<sunindextype>(N), context_);
    solver_ = SUNLinSol_Dense(y_, matrix_, context_);
    CVodeSetLinearSolver(memory_, solver_, matrix_);
    CVodeSetJacFn(memory_, jacobian);
    CVodeRootInit(memory_, watch == Watch::located ? 2 : 1, roots);
    int directions[2] = {1, -1};
    CVodeSetRootDirection(memory_, directions);
    CVodeSetNoInactiveRootWarn(memory_);
    CVodeSetMaxNumSteps(memory_, 100000);
  }
  Cvode(const Cvode&) = delete;
  Cvode& operator=(const Cvode&) = delete;
  ~Cvode() {
    CVodeFree(&memory_);
    SUNLinSolFree(solver_);
    SUNMatDestroy(matrix_);
    N_VDestroy(y_);
    N_VDestroy(dky_);
    SUNContext_Free(&context_);
  }

  Stretch carry(bool in_contact, double t, double t_end, State<N>& u) {
    field_.in_contact = in_contact;
    if (t_end - t < 1e-14 * (1.0 + t)) return {t_end, false, false};  // CVODE refuses such a step
    const double sign = field_.direction(), r = field_.p.r, t_start = t;
    std::copy(u.begin(), u.end(), NV_DATA_S(y_));
    CVodeReInit(memory_, t, y_);
    CVodeSetStopTime(memory_, t_end);
    for (;;) {
      const double t_before = t;
      const int flag = CVode(memory_, t_end, y_, &t, CV_NORMAL);
      if (flag < 0) return {t, false, true};
      if (flag != CV_ROOT_RETURN) break;
      int found[2] = {0, 0};
      CVodeGetRootInfo(memory_, found);
      if (found[0] == 0) {  // a maximum: if it lies beyond the guard, the crossing was in this step
        if (sign * (NV_Ith_S(y_, 0) - r) <= 0.0) continue;
        double t_now = 0.0, h = 0.0;
        CVodeGetCurrentTime(memory_, &t_now);
        CVodeGetLastStep(memory_, &h);
        const double lo = std::max({t_now - h, t_before, t_start});
        const auto guard = [&](double s) {
          CVodeGetDky(memory_, lo + s, 0, dky_);
          return Guard{sign * (NV_Ith_S(dky_, 0) - r), sign * NV_Ith_S(dky_, 1)};
        };
        if (guard(0.0).value > 0.0) continue;  // it was beyond before: missed earlier
        t = lo + zero(guard, 0.0, t - lo, -1.0);
        CVodeGetDky(memory_, t, 0, y_);
      }
      std::copy_n(NV_DATA_S(y_), N, u.begin());
      return {t, true, false};
    }
    std::copy_n(NV_DATA_S(y_), N, u.begin());
    return {t_end, false, false};
  }

 private:
  static int derivative(double t, N_Vector u, N_Vector du, void* self) {
    static_cast<const Cvode*>(self)->field_(t, NV_DATA_S(u), NV_DATA_S(du));
    return 0;
  }
  static int jacobian(double, N_Vector u, N_Vector, SUNMatrix J, void* self, N_Vector, N_Vector, N_Vector) {
    const auto pull = static_cast<const Cvode*>(self)->field_.pull(NV_Ith_S(u, 0), NV_Ith_S(u, 1));
    SUNMatZero(J);
    for (sunindextype i = 0; i < static_cast<sunindextype>(N); i += 2) {
      SM_ELEMENT_D(J, i, i + 1) = 1.0;
      SM_ELEMENT_D(J, i + 1, i) = pull.a_x;
      SM_ELEMENT_D(J, i + 1, i + 1) = pull.a_v;
    }
    return 0;
  }
  static int roots(double, N_Vector u, double* g, void* self) {
    const Watch watch = static_cast<const Cvode*>(self)->watch_;
    const Field<law, N>& field = static_cast<const Cvode*>(self)->field_;
    g[0] = field.direction() * (NV_Ith_S(u, 0) - field.p.r);
    if (watch == Watch::located) g[1] = field.direction() * NV_Ith_S(u, 1);
    return 0;
  }
  Watch watch_;
  Field<law, N> field_;
  SUNContext context_ = nullptr;
  N_Vector y_ = nullptr, dky_ = nullptr;
  void* memory_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver solver_ = nullptr;
};

}  // namespace baselines
