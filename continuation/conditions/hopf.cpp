// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/hopf.hpp>
#include <graze/lib/numerics/decompositions.hpp>
#include <graze/lib/tasks/newton_loop.hpp>

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace graze {

namespace {

/// The equilibria of a mode in one parameter, from a state near them on.
class Equilibria {
 public:
  Equilibria(const Mode& mode, Vector p, std::size_t parameter, Vector near)
      : mode_(mode), p_(std::move(p)), parameter_(static_cast<Eigen::Index>(parameter)), x_(std::move(near)) {}

  /// The eigenvalue nearest to i omega at the equilibrium for this value; NaN: there is none.
  std::complex<double> eigenvalue(double value, double omega) {
    constexpr double reached = 1e-13;
    p_[parameter_] = value;
    Vector f(x_.size()), last_step;
    NewtonStep measured;
    Matrix J(x_.size(), x_.size());
    // The field may have any unit, so that the step takes the place of the residual.
    const auto length = [&](const Vector& x) -> std::optional<double> {
      mode_.field(0.0, x, p_, f);
      mode_.field_dx(0.0, x, p_, J);
      last_step = -J.partialPivLu().solve(f);
      measured = {.length = last_step.lpNorm<Eigen::Infinity>(), .size = 1.0 + (x + last_step).lpNorm<Eigen::Infinity>()};
      return measured.length / measured.size;
    };
    const auto solve = [&](const Vector&, Vector& step) {
      step = last_step;
      return measured;
    };
    NewtonRule rule = newton_to_rounding(reached, reached);
    rule.max_iterations = 50;
    if (!newton(x_, length, solve, rule).converged()) return std::numeric_limits<double>::quiet_NaN();
    x_ += last_step;
    mode_.field_dx(0.0, x_, p_, J);
    const Eigen::VectorXcd all = eigenvalues(J);
    const std::complex<double> wanted(0.0, omega);
    return *std::min_element(all.begin(), all.end(),
                             [&](const auto& a, const auto& b) { return std::abs(a - wanted) < std::abs(b - wanted); });
  }

 private:
  const Mode& mode_;
  Vector p_;
  Eigen::Index parameter_;
  Vector x_;
};

}  // namespace

Vector field_at_first_node(OrbitProblem& problem, const Vector& u) {
  if (!problem.equations().autonomous()) return {};
  const HybridSystem& system = problem.system();
  Vector p = problem.equations().parameters();
  p[static_cast<Eigen::Index>(problem.parameter())] = problem.value(u);
  const Vector x = u.head(problem.states());
  const std::optional<std::size_t> mode = mode_at(system, 0.0, x, p);
  if (!mode) return {};
  Vector f(x.size());
  system.modes[*mode].field(0.0, x, p, f);
  return f;
}

bool is_equilibrium(OrbitProblem& problem, const Vector& u) {
  const Vector f = field_at_first_node(problem, u);
  if (f.size() == 0) return false;
  return is_at_equilibrium(f, problem.equations().duration(problem.orbit_part(u)), u.head(problem.states()));
}

std::optional<double> locate_hopf(OrbitProblem& problem, const Vector& u) {
  const HybridSystem& system = problem.system();
  const double begin = problem.value(u), duration = problem.equations().duration(problem.orbit_part(u)) / problem.period();
  Vector p = problem.equations().parameters();
  p[static_cast<Eigen::Index>(problem.parameter())] = begin;
  const std::optional<std::size_t> mode = mode_at(system, 0.0, u.head(problem.states()), p);
  if (!mode) return std::nullopt;
  Vector mean = Vector::Zero(problem.states());
  for (int j = 0; j < problem.nodes(); ++j) mean += u.segment(j * problem.states(), problem.states()) / problem.nodes();
  const double omega = 2.0 * std::numbers::pi / duration;
  Equilibria equilibria(system.modes[*mode], p, problem.parameter(), mean);
  // By secants, because the derivative of the eigenvalue is not at hand.
  constexpr int most_steps = 30;
  constexpr double first_step = 1e-6, precision = 1e-14, farthest = 0.1, other_frequency = 0.1;
  double before = begin, value = begin + first_step * problem.scale();
  double real_before = equilibria.eigenvalue(before, omega).real();
  for (int step = 0; step < most_steps; ++step) {
    const std::complex<double> eigenvalue = equilibria.eigenvalue(value, omega);
    const double real = eigenvalue.real(), change = -real * (value - before) / (real - real_before);
    if (real != 0.0 && !std::isfinite(change)) return std::nullopt;
    if (std::abs(value - begin) > farthest * problem.scale()) return std::nullopt;
    if (real == 0.0 || std::abs(change) <= precision * problem.size_of_value(value)) {
      if (std::abs(eigenvalue.imag() - omega) > other_frequency * omega) return std::nullopt;
      return value;
    }
    before = value;
    real_before = real;
    value += change;
  }
  return std::nullopt;
}

}  // namespace graze
