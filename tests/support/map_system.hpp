// SPDX-License-Identifier: GPL-3.0-or-later
// Any map x -> g(x, lambda) as a hybrid system: the state is constant except for one reset per forcing period, at forcing
// phase 1. (A second event, at phase 1 + pi, arms it again: a guard that stays at zero and rises would fire forever.) Its
// stroboscopic map is g itself, and its monodromy matrix is D_x g. It is a reference for every bifurcation of a fixed point,
// in any dimension. Parameters: omega (forcing frequency, 1) and lambda.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

#include <cmath>

namespace graze::support {

struct Map {
  std::string name;
  std::size_t states = 1;
  std::function<Vector(const Vector& x, double lambda)> value;
  std::function<Matrix(const Vector& x, double lambda)> dx;
  std::function<Vector(const Vector& x, double lambda)> dlambda;
};

inline HybridSystem map_system(const Map& map) {
  enum : Eigen::Index { omega, lambda };
  HybridSystem system;
  system.name = map.name;
  system.states = map.states;
  system.parameters.resize(2);
  system.parameters[omega].name = "omega";
  system.parameters[omega].default_value = 1.0;
  system.parameters[omega].lower = 0.0;
  system.parameters[omega].lower_open = true;
  system.parameters[lambda].name = "lambda";
  system.forcing_frequency = omega;
  Mode still;
  still.name = "still";
  still.field = [](double, const Vector&, const Vector&, Vector& f) { f.setZero(); };
  still.field_dx = still.field_dp = [](double, const Vector&, const Vector&, Matrix& J) { J.setZero(); };
  system.modes = {still, still};
  system.modes[1].name = "done";
  Event step;
  step.name = "step";
  step.from = 0;
  step.to = 1;
  step.guard.value = [](double t, const Vector&, const Vector& p) { return std::sin(p[omega] * t - 1.0); };
  step.guard.dx = [](double, const Vector&, const Vector&, Vector& g) { g.setZero(); };
  step.guard.dp = [](double t, const Vector&, const Vector& p, Vector& g) {
    g.setZero();
    g[omega] = t * std::cos(p[omega] * t - 1.0);
  };
  step.guard.dt = [](double t, const Vector&, const Vector& p) { return p[omega] * std::cos(p[omega] * t - 1.0); };
  step.reset.map = [map](double, const Vector& x, const Vector& p, Vector& out) { out = map.value(x, p[lambda]); };
  step.reset.dx = [map](double, const Vector& x, const Vector& p, Matrix& J) { J = map.dx(x, p[lambda]); };
  step.reset.dp = [map](double, const Vector& x, const Vector& p, Matrix& J) {
    J.setZero();
    J.col(lambda) = map.dlambda(x, p[lambda]);
  };
  Event arm = step;
  arm.name = "arm";
  arm.from = 1;
  arm.to = 0;
  arm.continuous = true;
  arm.reset = {};
  arm.guard.value = [](double t, const Vector&, const Vector& p) { return -std::sin(p[omega] * t - 1.0); };
  arm.guard.dp = [](double t, const Vector&, const Vector& p, Vector& g) {
    g.setZero();
    g[omega] = -t * std::cos(p[omega] * t - 1.0);
  };
  arm.guard.dt = [](double t, const Vector&, const Vector& p) { return -p[omega] * std::cos(p[omega] * t - 1.0); };
  system.events = {step, arm};
  system.initial_mode = [](double t, const Vector&, const Vector& p) -> std::optional<std::size_t> {
    return std::sin(p[omega] * t - 1.0) < 0.0 ? 0 : 1;
  };
  validate(system);
  return system;
}

/// A map of one dimension from plain functions of (x, lambda).
inline HybridSystem scalar_map(std::string name, double (*g)(double, double), double (*g_x)(double, double),
                               double (*g_lambda)(double, double)) {
  return map_system({std::move(name), 1, [g](const Vector& x, double lambda) { return Vector::Constant(1, g(x[0], lambda)); },
                     [g_x](const Vector& x, double lambda) { return Matrix::Constant(1, 1, g_x(x[0], lambda)); },
                     [g_lambda](const Vector& x, double lambda) { return Vector::Constant(1, g_lambda(x[0], lambda)); }});
}

/// x -> lambda x (1 - x): fixed point 1 - 1/lambda, PD at 3, of the doubled orbit at 1 + sqrt(6); period 3 born at 1 + sqrt(8).
inline HybridSystem logistic_map() {
  return scalar_map(
      "logistic", [](double x, double l) { return l * x * (1.0 - x); }, [](double x, double l) { return l * (1.0 - 2.0 * x); },
      [](double x, double) { return x * (1.0 - x); });
}
/// x -> x + lambda - x^2: fixed points +-sqrt(lambda), multiplier 1 - 2 x. LP at 0, PD at 1 on the upper one.
inline HybridSystem fold_map() {
  return scalar_map(
      "fold", [](double x, double l) { return x + l - x * x; }, [](double x, double) { return 1.0 - 2.0 * x; },
      [](double, double) { return 1.0; });
}
/// x -> (1 + lambda) x - x^2: x = 0 and x = lambda cross at BP = 0.
inline HybridSystem transcritical_map() {
  return scalar_map(
      "transcritical", [](double x, double l) { return (1.0 + l) * x - x * x; },
      [](double x, double l) { return 1.0 + l - 2.0 * x; }, [](double x, double) { return x; });
}
/// x -> (1 + lambda) x - x^3: x = 0 and x^2 = lambda cross at BP = 0.
inline HybridSystem pitchfork_map() {
  return scalar_map(
      "pitchfork", [](double x, double l) { return (1.0 + l) * x - x * x * x; },
      [](double x, double l) { return 1.0 + l - 3.0 * x * x; }, [](double x, double) { return x; });
}
/// x -> -(1 + lambda) x + c x^3: x = 0 doubles its period at 0, normal form coefficient c (> 0: supercritical), orbit
/// x^2 = lambda / c.
template <int c> HybridSystem flip_map() {
  return scalar_map(
      "flip", [](double x, double l) { return -(1.0 + l) * x + c * x * x * x; },
      [](double x, double l) { return -(1.0 + l) + 3.0 * c * x * x; }, [](double x, double) { return -x; });
}
/// (x, y) -> (lambda x (1 - y), x): fixed point x = y = 1 - 1/lambda, NS at 2 with angle pi/3.
inline HybridSystem delayed_logistic_map() {
  return map_system({"delayed-logistic", 2,
                     [](const Vector& x, double l) {
                       return Vector{{l * x[0] * (1.0 - x[1]), x[0]}};
                     },
                     [](const Vector& x, double l) {
                       return Matrix{{l * (1.0 - x[1]), -l * x[0]}, {1.0, 0.0}};
                     },
                     [](const Vector& x, double) {
                       return Vector{{x[0] * (1.0 - x[1]), 0.0}};
                     }});
}
/// x -> D(lambda) x with the diagonal given by a function.
inline HybridSystem diagonal_map(std::string name, std::size_t states, std::function<Vector(double)> diagonal,
                                 std::function<Vector(double)> slope) {
  return map_system({std::move(name), states,
                     [diagonal](const Vector& x, double l) { return Vector(diagonal(l).cwiseProduct(x)); },
                     [diagonal](const Vector&, double l) { return Matrix(diagonal(l).asDiagonal()); },
                     [slope](const Vector& x, double l) { return Vector(slope(l).cwiseProduct(x)); }});
}

}  // namespace graze::support
