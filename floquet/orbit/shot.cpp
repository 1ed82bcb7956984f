// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/least_period.hpp>
#include <graze/floquet/orbit/returns.hpp>
#include <graze/floquet/orbit/shooting_nodes.hpp>
#include <graze/floquet/orbit/shot.hpp>
#include <graze/lib/numerics/cyclic_blocks.hpp>
#include <graze/lib/numerics/decompositions.hpp>
#include <graze/lib/numerics/log_product.hpp>
#include <graze/lib/tasks/newton_loop.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace graze {

namespace {

bool are_admissible(const std::vector<Vector>& states, const HybridSystem& system, const Vector& p) {
  return std::all_of(states.begin(), states.end(), [&](const Vector& x) { return mode_at(system, 0.0, x, p).has_value(); });
}

double growth(const MonodromyMatrix& monodromy) {
  const Matrix M = monodromy.product();
  return M.rows() == 2 ? std::abs(eigenvalue_pair(0.5 * M.trace(), M(0, 0) * M(1, 1) - M(0, 1) * M(1, 0))[0])
                       : spectral_radius(M);
}

/// The rule of shoot(), which also ends where the residual is rounding: one evaluation less for most orbits. (In shoot() a
/// further step may change the last digits.)
NewtonRule rule_of(const NewtonPatience& patience) {
  NewtonRule rule = newton_rule({});
  rule.max_halvings = patience.max_halvings;
  rule.rounding = 1e-15;
  return rule;
}

Shot shot_of(PeriodicOrbit found) {
  Shot shot;
  shot.converged = found.converged();
  if (!shot.converged) return shot;
  shot.holds = (found.stable() || found.neutral()) && found.admissible == Admissibility::admissible;
  shot.orbit = StableOrbit(std::move(found));
  return shot;
}

}  // namespace

/// The nodes of an orbit as the unknowns of Newton's method: n states at the beginning of each period, a column for each. (In no
/// unnamed namespace, as the next one: g++ 12 warns of tasks that hold one's types.)
class PeriodNodes {
 public:
  using Unknowns = Matrix;

  PeriodNodes(TaskSlot& slot, double most_growth) : slot_(slot), most_growth_(most_growth) {}

  TaskSlot::CarryingOne evaluate(const Matrix& trial) { return slot_.carry_nodes(trial, modes_); }
  std::optional<double> residual(const Matrix& trial) {
    const CarriedPeriods ends = slot_.carried();
    Vector end(trial.rows());
    residual_.resize(trial.rows(), trial.cols());
    for (std::size_t k = 0; k < ends.size(); ++k) {
      if (ends.termination(k) != Termination::time) return std::nullopt;
      ends.state(k, end);
      const auto node = static_cast<Eigen::Index>(k);
      residual_.col(node) = end - trial.col((node + 1) % trial.cols());
    }
    return residual_.lpNorm<Eigen::Infinity>() / size(trial);
  }
  void accept() {
    const CarriedPeriods periods = slot_.carried();
    maps_.factors.resize(periods.size());
    maps_.lost = 0;
    lost_.clear();
    determinant_ = {};
    liouville_ = 0.0;
    impacts_ = 0;
    by_propagator_ = false;
    for (std::size_t k = 0; k < periods.size(); ++k) {
      periods.map(k, maps_.factors[k]);
      lost_.push_back(periods.lost(k));
      maps_.lost = std::max(maps_.lost, lost_.back());
      periods.multiply_determinant(k, determinant_);
      liouville_ += periods.liouville(k);
      impacts_ += periods.impacts(k);
      by_propagator_ = by_propagator_ || periods.by_propagator(k);
    }
  }
  bool gives_up(const NewtonReport& report) {
    given_up_ = report.iterations() == 0 && growth(maps_) > most_growth_;
    return given_up_;
  }
  NewtonStep solve(const Matrix& u) {
    if (u.rows() == 2)
      blocks_.solve(maps_.factors, residual_, step_);
    else
      step_ = step_on_dense_nodes(u);
    return {.length = step_.allFinite() ? step_.lpNorm<Eigen::Infinity>() : std::nan(""), .size = size(u)};
  }
  void move(const Matrix& u, double factor, Matrix& trial) const { trial = u + factor * step_; }

  /// The orbit through u, where the iteration has ended.
  Shot shot(const NewtonReport& report, const Matrix& u) const {
    Shot out;
    out.converged = report.converged();
    out.given_up = given_up_;
    if (!out.converged) return out;
    StableOrbit& orbit = out.orbit;
    for (const auto& node : u.colwise()) orbit.states.emplace_back(node);
    orbit.period = static_cast<int>(orbit.states.size());
    orbit.duration = orbit.period * forcing_period(slot_.system(), slot_.p());
    orbit.impacts = orbit.isolated_impacts = impacts_;  // shoot() decides about sticking orbits
    orbit.multipliers = multipliers(orbit.duration);
    out.holds = std::abs(out.multiplier()) < 1.0;
    return out;
  }
  /// Whether the multipliers show if the orbit is stable, and determine their sizes to 1e-10; a stable one must have been carried
  /// in lanes.
  bool is_sure(const Shot& shot) const {
    constexpr double rounding = 1e-15, good = 1e-10, near_one = 1e-6;
    const double modulus = std::abs(shot.multiplier()), blur = largest_entry();
    const double unsure = std::max(near_one, blur * rounding / near_one);
    return std::isfinite(modulus) && std::isfinite(determinant_.value()) && blur * rounding <= good * modulus &&
           std::abs(modulus - 1.0) >= unsure && !(by_propagator_ && modulus < 1.0);
  }

 private:
  static double size(const Matrix& u) { return 1.0 + u.lpNorm<Eigen::Infinity>(); }

  Matrix step_on_dense_nodes(const Matrix& u) const {
    const Eigen::Index n = u.rows(), count = u.cols();
    Matrix jacobian = Matrix::Zero(u.size(), u.size());
    std::vector<NodeMap> maps;
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto node = static_cast<std::size_t>(k);
      jacobian.block(k * n, k * n, n, n) += maps_.factors[node];
      jacobian.block(k * n, (k + 1) % count * n, n, n) -= Matrix::Identity(n, n);
      maps.push_back({&maps_.factors[node], lost_[node]});
    }
    return step_on_nodes(jacobian, residual_.reshaped(), maps).reshaped(n, count);
  }

  FloquetMultipliers multipliers(double duration) const {
    if (maps_.factors.front().rows() > 2) return graze::multipliers(maps_, duration);
    const double log_det = determinant_.value();
    const auto [first, second] =
        eigenvalue_pair(0.5 * maps_.product().trace(), std::exp(std::isfinite(log_det) ? log_det : liouville_));
    return multipliers_of_values({first, second}, duration);
  }

  /// Of the products of the first maps; at least 1.
  double largest_entry() const {
    double most = 1.0;
    Matrix M = Matrix::Identity(maps_.factors.front().rows(), maps_.factors.front().rows());
    for (const Matrix& map : maps_.factors) {
      M = map * M;
      most = std::max(most, M.cwiseAbs().maxCoeff());
    }
    return most;
  }

  TaskSlot& slot_;
  double most_growth_;
  bool given_up_ = false;
  std::vector<std::optional<std::size_t>> modes_;  // at the nodes
  Matrix residual_, step_;
  CyclicBlocks blocks_;
  // Of the periods from the nodes accepted last:
  MonodromyMatrix maps_;
  std::vector<int> lost_;
  LogProduct determinant_;
  double liouville_ = 0.0;
  int impacts_ = 0;
  bool by_propagator_ = false;
};

/// A shot, the outcome of Newton's method, and whether it needs no proof.
struct LightShot {
  Shot shot;
  NewtonReport newton;
  bool sure = true;
};

namespace {

MotionTask<LightShot> newton_from(TaskSlot& slot, const std::vector<Vector>& guess, NewtonPatience patience) {
  Matrix u(guess.front().size(), std::ssize(guess));
  for (std::size_t k = 0; k < guess.size(); ++k) u.col(static_cast<Eigen::Index>(k)) = guess[k];
  PeriodNodes nodes(slot, patience.most_growth);
  const NewtonRule rule = rule_of(patience);
  LightShot out;
  out.newton = co_await newton_loop(nodes, rule, u);
  out.shot = nodes.shot(out.newton, u);
  if (out.shot.converged) out.sure = nodes.is_sure(out.shot);
  co_return out;
}

/// The orbit of a motion without forcing, from the states right after its returns.
Shot shot_at_returns(Propagator& propagator, const std::vector<Vector>& guess, const NewtonPatience& patience) {
  if (std::isfinite(patience.most_growth)) {
    MonodromyMatrix maps;
    Transition transition;
    for (const Vector& state : guess) {
      carry_period(propagator, state, {.sensitivity = Sensitivity::state}, transition);
      maps.factors.push_back(period_map(transition));
    }
    if (growth(maps) > patience.most_growth) return {.given_up = true};
  }
  ShootingOptions shooting;
  shooting.flow = propagator.options();
  shooting.max_halvings = patience.max_halvings;
  return shot_of(at_returns(propagator.system(), shoot_returns(propagator, guess, shooting), guess.front()));
}

/// The whole orbit through the nodes; if they were carried in lanes and are none for a Propagator, the one of shoot().
Shot proved(const TaskSlot& slot, const LightShot& light) {
  const std::vector<Vector>& states = light.shot.orbit.states;
  const int period = light.shot.orbit.period;
  ShootingOptions shooting;
  shooting.flow = slot.flow();
  ShootingEquations equations(slot.system(), slot.p(), period, period, {}, shooting.flow);
  Vector u(equations.unknowns());
  for (std::size_t k = 0; k < states.size(); ++k)
    u.segment(static_cast<Eigen::Index>(k) * equations.states(), equations.states()) = states[k];
  PeriodicOrbit orbit = describe_orbit(equations, u, light.newton);
  if (!(orbit.checks.residual < shooting.acceptance)) orbit = shoot(slot.system(), slot.p(), states, period, shooting);
  return shot_of(std::move(orbit));
}

}  // namespace

MotionTask<Shot> shoot_from(TaskSlot& slot, const std::vector<Vector>& guess, NewtonPatience patience) {
  if (!are_admissible(guess, slot.system(), slot.p())) co_return Shot();
  if (!is_forced(slot.system())) co_return shot_at_returns(slot.propagator(), guess, patience);
  LightShot light = co_await newton_from(slot, guess, patience);
  if (!light.shot.converged) co_return std::move(light.shot);
  const std::vector<Vector> states = light.shot.orbit.states;
  const NewtonPatience any_growth{.max_halvings = patience.max_halvings};
  for (const std::size_t shorter : shorter_periods(states)) {
    const std::vector<Vector> single = guess_of_shorter(states, shorter);
    LightShot found = co_await newton_from(slot, single, any_growth);
    if (!found.shot.converged) continue;
    const StableOrbit& orbit = found.shot.orbit;
    const double distance = state_distance(orbit.states[0], states[0]);
    if (!is_repeated(orbit.multipliers.values, states.size() / orbit.states.size(), distance, state_size(states[0]))) continue;
    light = std::move(found);
    break;
  }
  if (light.sure) co_return std::move(light.shot);
  co_return proved(slot, light);
}

}  // namespace graze
