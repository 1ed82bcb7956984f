// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/returns.hpp>
#include <graze/floquet/orbit/shooting.hpp>
#include <graze/floquet/verify/orbit_verification.hpp>
#include <graze/lib/numerics/decompositions.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

namespace graze {

namespace {

/// The orbit's own nodes, carried by the general integrator in every mode.
PeriodicOrbit carried_by_general(const HybridSystem& system, const PeriodicOrbit& orbit) {
  ShootingEquations equations(system, orbit.parameters, orbit.period, static_cast<int>(orbit.nodes.size()), {},
                              {.kind = FlowKind::general}, orbit.section_phase);
  Vector u(equations.unknowns());
  Eigen::Index filled = 0;
  for (const Vector& node : orbit.nodes) {
    u.segment(filled, node.size()) = node;
    filled += node.size();
  }
  if (equations.autonomous()) {
    u[filled] = orbit.duration;
    equations.set_phase_reference(orbit.state);
  }
  return describe_orbit(equations, u, orbit.newton);
}

/// First-order effect of relative errors of the factors on their product: S of the header.
double error_growth(const std::vector<Matrix>& factors) {
  const std::size_t count = factors.size();
  std::vector<double> after(count, 1.0);  // norms of the products to the left of each factor
  Matrix left = Matrix::Identity(factors.front().rows(), factors.front().rows()), right = left;
  for (std::size_t k = count; k-- > 0;) {
    after[k] = left.norm();
    left = left * factors[k];
  }
  double sum = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    sum += after[k] * (1.0 + factors[k].norm()) * right.norm();
    right = factors[k] * right;
  }
  return sum;
}

/// Compares the multipliers of `other`, from factors of relative error `factor_error`, with those of the orbit.
OrbitCheck compare_multipliers(const std::string& name, const VerifiedOrbit& verified, const FloquetMultipliers& other,
                               const std::vector<Matrix>& factors, double factor_error, const std::string& obstacle) {
  OrbitCheck check{name, -1.0, factor_error, obstacle};
  const FloquetMultipliers& ours = verified.orbit.multipliers;
  if (!ours.valid || !other.valid || factors.empty() || ours.values.size() != other.values.size()) return check;
  const double norm = verified.orbit.monodromy.product().norm(), error = factor_error * error_growth(factors);
  const double power = 1.0 / static_cast<double>(ours.values.size()), scale = 1.0 + std::abs(ours.values.front());
  const double always = std::pow(2.0 * norm + error, 1.0 - power) * std::pow(error, power);
  check.limit = std::min(verified.eigenvector_condition * error, always) / scale;
  check.reason.clear();
  // The order of nearly equal moduli depends on rounding: compare each with the nearest one left.
  std::vector<std::complex<double>> left = other.values;
  check.disagreement = 0.0;
  for (const std::complex<double>& mu : ours.values) {
    const auto nearest = std::min_element(left.begin(), left.end(),
                                          [&](const auto& a, const auto& b) { return std::abs(a - mu) < std::abs(b - mu); });
    check.disagreement = std::max(check.disagreement, std::abs(*nearest - mu) / scale);
    left.erase(nearest);
  }
  return check;
}

/// Where the average of an orbit begins, and kappa of its monodromy matrix there.
struct AverageBegin {
  Vector state;
  int turn = 1;  ///< periods or returns of the orbit
  double eigenvector_condition = 0.0;
};

/// Empty if the motion of an autonomous orbit does not return.
std::optional<AverageBegin> average_begin(const HybridSystem& system, const VerifiedOrbit& verified) {
  const PeriodicOrbit& orbit = verified.orbit;
  if (is_forced(system)) return AverageBegin{orbit.state, orbit.period, verified.eigenvector_condition};
  Propagator propagator(system, orbit.parameters);
  Transition to_next;
  carry_period(propagator, orbit.nodes.front(), {.sensitivity = Sensitivity::none}, to_next);
  if (to_next.termination != Termination::time) return std::nullopt;
  AverageBegin out{to_next.x1, std::max(1, count_returns(system, orbit))};
  const auto n = static_cast<Eigen::Index>(system.states);
  Matrix turn = Matrix::Identity(n, n);
  Vector at = out.state;
  for (int k = 0; k < out.turn; ++k) {
    carry_period(propagator, at, {.sensitivity = Sensitivity::state}, to_next);
    if (to_next.termination != Termination::time) return std::nullopt;
    turn = to_next.Phi * turn;
    at = to_next.x1;
  }
  out.eigenvector_condition = eigenvector_condition(turn);
  return out;
}

constexpr const char* no_multipliers = "the multipliers do not exist";

/// Why the exponents of the orbit cannot be averaged; empty: they can.
std::string average_obstacle(const PeriodicOrbit& orbit, const VerificationOptions& options) {
  const std::vector<double>& exponents = orbit.multipliers.exponents;
  if (options.average_periods == 0) return "no average was asked for";
  if (!orbit.multipliers.valid) return no_multipliers;
  if (!orbit.stable()) return "the orbit is unstable";
  if (orbit.admissible != Admissibility::admissible) return "the orbit is not admissible";
  if (!std::all_of(exponents.begin(), exponents.end(), [](double e) { return std::isfinite(e); })) return "a multiplier is zero";
  return {};
}

OrbitCheck compare_exponents(const HybridSystem& system, VerifiedOrbit& verified, const VerificationOptions& options) {
  const PeriodicOrbit& orbit = verified.orbit;
  OrbitCheck check{"exponents", -1.0, bound::exponent, average_obstacle(orbit, options)};
  if (!check.reason.empty()) return check;
  const std::optional<AverageBegin> begin = average_begin(system, verified);
  if (!begin)
    check.reason = "the motion does not return";
  else if (!std::isfinite(begin->eigenvector_condition))
    check.reason = "the monodromy matrix is defective";
  if (!check.reason.empty()) return check;
  const auto whole_turns = [n = begin->turn](std::int64_t periods) { return (periods + n - 1) / n * n; };
  LyapunovOptions averaging;
  averaging.standard_error = 0.0;
  averaging.max_periods = whole_turns(options.average_periods);
  averaging.aligning = whole_turns(options.aligning);
  averaging.cancelled = options.cancelled;
  verified.average = lyapunov_spectrum(system, orbit.parameters, begin->state, averaging);
  if (verified.average.stop == LyapunovStop::interrupted) {
    check.reason = "the average was interrupted";
    return check;
  }
  const double period = is_forced(system) ? forcing_period(system, orbit.parameters) : orbit.duration / begin->turn;
  const double time = static_cast<double>(averaging.max_periods) * period;
  std::vector<double> exponents = orbit.multipliers.exponents;
  std::sort(exponents.rbegin(), exponents.rend());  // the multiplier 1 of an autonomous orbit is its last
  const auto n = static_cast<double>(exponents.size());
  check.limit += 2.0 * std::max(0.0, 2.0 * n - 3.0) * std::log(begin->eigenvector_condition) / time;
  // An interrupted run proves nothing.
  check.disagreement = verified.average.stop == LyapunovStop::budget ? 0.0 : std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < exponents.size() && check.disagreement >= 0.0; ++i) {
    const double difference = std::abs(verified.average.exponents[i] - exponents[i]);
    check.disagreement = std::isnan(difference) ? difference : std::max(check.disagreement, difference);
  }
  return check;
}

}  // namespace

double finite_difference_bound(const FiniteDifferenceCheck& check) {
  return std::max(bound::finite_difference, check.error_estimate);
}

std::string liouville_obstacle(const PeriodicOrbit& orbit) {
  if (!orbit.multipliers.valid) return no_multipliers;
  const std::vector<std::complex<double>>& values = orbit.multipliers.values;
  const bool zero = std::find(values.begin(), values.end(), 0.0) != values.end();
  return zero ? "a multiplier is zero" : "the determinant is lost to rounding";
}

bool VerifiedOrbit::agrees() const {
  return std::all_of(checks.begin(), checks.end(), [](const OrbitCheck& check) { return check.passes(); });
}

VerifiedOrbit verify_orbit(const HybridSystem& system, const PeriodicOrbit& orbit, const VerificationOptions& options) {
  if (orbit.nodes.empty()) throw std::invalid_argument("the orbit to verify has no nodes; it must come from shoot()");
  if (options.average_periods < 0 || options.aligning < 0)
    throw std::invalid_argument(fmt::format("average_periods is {} and aligning is {}; allowed are whole numbers >= 0",
                                            options.average_periods, options.aligning));
  VerifiedOrbit out{orbit};
  out.general = carried_by_general(system, orbit);
  out.eigenvector_condition = orbit.multipliers.valid ? eigenvector_condition(orbit.monodromy.product()) : 0.0;
  out.checks.push_back({"residual", orbit.checks.residual, bound::residual});
  const auto checked = [](const char* name, double disagreement, double limit, const std::string& obstacle) {
    return OrbitCheck{name, disagreement, limit, disagreement < 0.0 ? obstacle : std::string()};
  };
  out.checks.push_back(checked("Liouville", orbit.checks.liouville, bound::liouville, liouville_obstacle(orbit)));
  const FiniteDifferenceCheck difference = orbit.checks.finite_difference.value_or(finite_difference_check(system, orbit));
  if (difference.applicable) out.differences = multipliers(difference.monodromy, orbit.duration);
  out.checks.push_back(checked("finite differences", difference.applicable ? difference.disagreement : -1.0,
                               finite_difference_bound(difference), difference_obstacle));
  // The same digits come from the same integrator: the orbit was computed by it, and nothing is compared.
  const bool same = out.general.monodromy.factors == orbit.monodromy.factors;
  if (same) out.general.multipliers = {};
  const std::string no_general = same                       ? "the orbit was computed by this integrator"
                                 : !orbit.multipliers.valid ? no_multipliers
                                                            : "this integrator gives no multipliers";
  if (out.general.multipliers.valid && orbit.multipliers.valid) {
    const Matrix ours = orbit.monodromy.product(), theirs = out.general.monodromy.product();
    out.checks.push_back({"GSL: motion", out.general.checks.residual, bound::flow});
    out.checks.push_back(
        {"GSL: matrix", (ours - theirs).cwiseAbs().maxCoeff() / (1.0 + ours.cwiseAbs().maxCoeff()), bound::finite_difference});
    out.checks.push_back(
        checked("GSL: Liouville", out.general.checks.liouville, bound::liouville, liouville_obstacle(out.general)));
  } else {
    out.checks.push_back({"GSL: matrix", -1.0, bound::finite_difference, no_general});
  }
  out.checks.push_back(compare_multipliers("multipliers: differences", out, out.differences, difference.monodromy.factors,
                                           finite_difference_bound(difference),
                                           orbit.multipliers.valid ? difference_obstacle : no_multipliers));
  out.checks.push_back(compare_multipliers("multipliers: GSL", out, out.general.multipliers, out.general.monodromy.factors,
                                           bound::finite_difference, no_general));
  out.checks.push_back(compare_exponents(system, out, options));
  return out;
}

}  // namespace graze
