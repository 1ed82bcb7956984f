// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/lane_orbits.hpp>
#include <graze/floquet/orbit/least_period.hpp>
#include <graze/floquet/orbit/shooting.hpp>
#include <graze/floquet/orbit/state_distance.hpp>
#include <graze/lib/numerics/cyclic_blocks.hpp>
#include <graze/lib/numerics/log_product.hpp>
#include <graze/lib/tasks/newton_loop.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace graze {

namespace {

using Pair = CyclicBlocks::Pair;
using Square = CyclicBlocks::Square;

double nodes_size(const std::vector<Pair>& pairs) {
  double most = 0.0;
  for (const Pair& pair : pairs) most = std::max(most, state_size(pair));
  return most;
}

Square product(const Square& A, const Square& B) {
  return {A[0] * B[0] + A[1] * B[2], A[0] * B[1] + A[1] * B[3], A[2] * B[0] + A[3] * B[2], A[2] * B[1] + A[3] * B[3]};
}

/// Spectral radius of the tangent map over these periods.
double growth(const std::vector<PeriodResult>& periods) {
  Square M = {1.0, 0.0, 0.0, 1.0};
  for (const PeriodResult& period : periods) M = product(period.Phi, M);
  return std::abs(eigenvalue_pair(0.5 * (M[0] + M[3]), M[0] * M[3] - M[1] * M[2])[0]);
}

/// The rule of shoot(), which also ends where the residual is rounding: one evaluation less for most orbits. (In shoot() a
/// further step may change the last digits.)
NewtonRule rule_in_lanes(const NewtonPatience& patience) {
  NewtonRule rule = newton_rule({});
  rule.max_halvings = patience.max_halvings;
  rule.rounding = 1e-15;
  return rule;
}

}  // namespace

/// The nodes of an orbit in lanes: one for each period. (In no unnamed namespace: g++ 12 warns of tasks that hold one's types.)
class LaneNodes {
 public:
  using Unknowns = std::vector<Pair>;

  LaneNodes(TaskSlot& lane, double most_growth) : lane_(lane), most_growth_(most_growth) {}

  TaskSlot::Carrying evaluate(const Unknowns& trial) {
    motions_.clear();
    for (const Pair& node : trial) motions_.push_back({lane_.parameters(), node[0], node[1]});
    return lane_.carry(motions_, 1, true);
  }
  std::optional<double> residual(const Unknowns& trial) {
    const std::span<const PeriodResult> ends = lane_.results();
    const std::size_t n = trial.size();
    if (!std::all_of(ends.begin(), ends.end(), [](const auto& one) { return one.termination == Termination::time; }))
      return std::nullopt;
    residual_.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
      const Pair& next = trial[(k + 1) % n];
      residual_[k] = {ends[k].x - next[0], ends[k].v - next[1]};
    }
    return nodes_size(residual_) / size(trial);
  }
  void accept() { carried_.assign(lane_.results().begin(), lane_.results().end()); }
  bool gives_up(const NewtonReport& report) {
    given_up_ = report.iterations() == 0 && growth(carried_) > most_growth_;
    return given_up_;
  }
  NewtonStep solve(const Unknowns& u) {
    Phi_.clear();
    for (const PeriodResult& period : carried_) Phi_.push_back(period.Phi);
    blocks_.solve(Phi_, residual_, step_);
    double length = 0.0;
    for (const Pair& one : step_)
      for (const double entry : one) length = std::isfinite(entry) ? std::max(length, std::abs(entry)) : std::nan("");
    return {.length = length, .size = size(u)};
  }
  void move(const Unknowns& u, double factor, Unknowns& trial) const {
    for (std::size_t k = 0; k < u.size(); ++k)
      for (std::size_t i = 0; i < 2; ++i) trial[k][i] = u[k][i] + factor * step_[k][i];
  }

  /// The orbit through u.
  LaneOrbit orbit(const NewtonReport& report, Unknowns u) const {
    LaneOrbit out;
    out.converged = report.converged();
    out.given_up = given_up_;
    if (!out.converged) return out;
    out.states = std::move(u);
    Square M = {1.0, 0.0, 0.0, 1.0};
    LogProduct determinant;
    double liouville = 0.0, blur = 1.0;
    for (const PeriodResult& period : carried_) {
      M = product(period.Phi, M);
      determinant.multiply(period.det);
      liouville += period.liouville;
      out.impacts += period.impacts;
      out.delicate = out.delicate || period.by_propagator;
      for (const double entry : M) blur = std::max(blur, std::abs(entry));
    }
    const double log_det = determinant.value();
    out.multipliers = eigenvalue_pair(0.5 * (M[0] + M[3]), std::exp(std::isfinite(log_det) ? log_det : liouville));
    constexpr double rounding = 1e-15, good = 1e-10, near_one = 1e-6;
    const double modulus = std::abs(out.multipliers[0]), unsure = std::max(near_one, blur * rounding / near_one);
    out.delicate = out.delicate || !std::isfinite(modulus) || !std::isfinite(log_det) || blur * rounding > good * modulus ||
                   std::abs(modulus - 1.0) < unsure;
    return out;
  }

 private:
  static double size(const Unknowns& u) { return 1.0 + nodes_size(u); }

  TaskSlot& lane_;
  double most_growth_;
  std::vector<MotionStart> motions_;
  std::vector<PeriodResult> carried_;  // from the nodes accepted last
  std::vector<Pair> residual_, step_;
  CyclicBlocks blocks_;
  std::vector<Square> Phi_;
  bool given_up_ = false;
};

namespace {

MotionTask<LaneOrbit> newton_in_lane(TaskSlot& slot, std::vector<Pair> states, NewtonPatience patience) {
  LaneNodes nodes(slot, patience.most_growth);
  const NewtonRule rule = rule_in_lanes(patience);
  const NewtonReport report = co_await newton_loop(nodes, rule, states);
  co_return nodes.orbit(report, std::move(states));
}

}  // namespace

MotionTask<LaneOrbit> shoot_in_lanes(TaskSlot& slot, const std::vector<Vector>& guess, NewtonPatience patience) {
  std::vector<Pair> states;
  std::transform(guess.begin(), guess.end(), std::back_inserter(states), [](const Vector& state) { return pair_of(state); });
  LaneOrbit orbit = co_await newton_in_lane(slot, std::move(states), patience);
  const NewtonPatience any_growth{.max_halvings = patience.max_halvings};
  if (!orbit.converged) co_return orbit;
  for (const std::size_t shorter : shorter_periods(orbit.states)) {
    std::vector<Pair> single = guess_of_shorter(orbit.states, shorter);
    LaneOrbit found = co_await newton_in_lane(slot, std::move(single), any_growth);
    if (!found.converged) continue;
    const double distance = state_distance(found.states[0], orbit.states[0]);
    if (!is_repeated(found.multipliers, orbit.states.size() / found.states.size(), distance, state_size(orbit.states[0])))
      continue;
    orbit = std::move(found);
    break;
  }
  co_return orbit;
}

}  // namespace graze
