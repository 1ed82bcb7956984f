// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/shooting.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze {

namespace {

/// Romberg's table of central differences for one column of a stretch's transition matrix.
struct Column {
  Vector value;
  double error = std::numeric_limits<double>::infinity();
};

}  // namespace

FiniteDifferenceCheck finite_difference_check(const HybridSystem& system, const PeriodicOrbit& orbit,
                                              const FlowOptions& options) {
  FiniteDifferenceCheck check;
  if (orbit.nodes.empty()) return check;
  ShootingEquations equations(system, orbit.parameters, orbit.period, static_cast<int>(orbit.nodes.size()), std::nullopt, options,
                              orbit.section_phase);
  const int n = equations.states(), count = equations.nodes();
  Vector u(equations.unknowns());
  for (int j = 0; j < count; ++j) u.segment(j * n, n) = orbit.nodes[static_cast<std::size_t>(j)];
  if (equations.autonomous()) {
    u[n * count] = orbit.duration;
    equations.set_phase_reference(orbit.state);
  }
  if (!equations.evaluate(u, {.sensitivity = Sensitivity::state})) return check;
  Transition moved;
  check.applicable = true;
  for (int j = 0; j < count && check.applicable; ++j) {
    const Transition& base = equations.stretch(j);
    const double start = equations.node_time(u, j), length = orbit.duration / count;
    const double scale = 1.0 + base.Phi.cwiseAbs().maxCoeff();
    Matrix factor = Matrix::Zero(n, n);
    for (int k = 0; k < n; ++k) {
      const double unit = 1.0 + std::abs(u[j * n + k]);
      const auto difference = [&](double h) -> std::optional<Vector> {
        Vector ends[2];
        double places[2];
        for (int side = 0; side < 2; ++side) {
          Vector x = equations.node(u, j);
          x[k] += side == 0 ? h : -h;
          places[side] = x[k];
          carry(equations.propagator(), start, start + length, x, {.sensitivity = Sensitivity::none}, moved);
          if (moved.termination != Termination::time || moved.event_sequence != base.event_sequence || moved.mode0 != base.mode0)
            return std::nullopt;
          ends[side] = moved.x1;
        }
        return (ends[0] - ends[1]) / (places[0] - places[1]);
      };
      // From large steps to small: each next one halves, three levels are extrapolated, and the best estimate of its error wins.
      Column best;
      std::optional<Vector> coarse, middle;
      for (double h = 0.02 * unit; h > 1e-7 * unit; h *= 0.5) {
        const std::optional<Vector> fine = difference(h);
        if (coarse && middle && fine) {
          const Vector first = (4.0 * *middle - *coarse) / 3.0, second = (4.0 * *fine - *middle) / 3.0;
          const Vector value = (16.0 * second - first) / 15.0;
          const double rounding = 1e-15 * scale * unit / h;
          const double error = (value - second).lpNorm<Eigen::Infinity>() + rounding;
          if (error < best.error) best = {value, error};
        }
        coarse = middle;
        middle = fine;
      }
      if (!std::isfinite(best.error)) {
        check.applicable = false;
        break;
      }
      factor.col(k) = best.value;
      check.disagreement = std::max(check.disagreement, (best.value - base.Phi.col(k)).lpNorm<Eigen::Infinity>() / scale);
      check.error_estimate = std::max(check.error_estimate, best.error / scale);
    }
    check.monodromy.factors.push_back(std::move(factor));
  }
  check.monodromy.section = orbit.monodromy.section;
  check.monodromy.trivial_direction = orbit.monodromy.trivial_direction;
  if (!check.applicable) check.monodromy.factors.clear();
  return check;
}

}  // namespace graze
