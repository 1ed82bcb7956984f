// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/problems/orbit_problem.hpp>
#include <graze/lib/motion/rest.hpp>

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

namespace graze {

namespace {

/// Relative step of the central differences of transition matrices. It is small because near a weak impact of a hard contact
/// the matrices change over lengths proportional to the square of its speed. The accuracy suffices: the differences only enter
/// the Jacobian of Newton's method.
constexpr double difference_step = 1e-7;

/// Whether there are constraints, and a disturbance off them is lost (constraint_map).
bool holds(const HybridSystem& system, const std::vector<Constraint>& constraints, const HybridState& at, const Vector& p) {
  if (constraints.empty()) return false;
  std::vector<const Constraint*> all;
  for (const Constraint& one : constraints) all.push_back(&one);
  return constraint_map(system, all, at, p, {}).has_value();
}

}  // namespace

OrbitProblem::OrbitProblem(const SharedSystem& system, const Vector& p, int period, int nodes, std::vector<FreeParameter> free,
                           const FlowOptions& options, double section_phase)
    : BranchProblem(system, p, std::move(free)), equations_(system, p, period, nodes, free_indices(), options, section_phase) {}

OrbitProblem::OrbitProblem(const SharedSystem& system, const Vector& p, int period, int nodes, std::size_t parameter,
                           double scale, const FlowOptions& options, double section_phase)
    : OrbitProblem(system, p, period, nodes, {{parameter, scale}}, options, section_phase) {}

OrbitProblem OrbitProblem::with_section(double section_phase) const {
  OrbitProblem other(system(), p_, period(), nodes(), free_, equations_.options(), section_phase);
  other.measure_as(*this);
  return other;
}

std::optional<Vector> OrbitProblem::carried_on(const Vector& u, double ahead) {
  const int n = states();
  if (!evaluate(u, {.sensitivity = Sensitivity::none})) return std::nullopt;
  const Vector shortened = orbit_part(u);
  Vector out = u;
  Transition transition;
  for (int j = 0; j < nodes(); ++j) {
    const double start = equations_.node_time(shortened, j);
    carry(equations_.propagator(), start, start + ahead, equations_.node(shortened, j), {.sensitivity = Sensitivity::none},
          transition);
    if (transition.termination != Termination::time) return std::nullopt;
    out.segment(j * n, n) = transition.x1;
  }
  return out;
}

std::optional<Vector> OrbitProblem::to_section(OrbitProblem& other, const Vector& u) {
  const int n = states(), N = nodes();
  if (!set_value(equations_, u)) return std::nullopt;
  const double T = equations_.duration(orbit_part(u)) / period(), length = T * period() / N;
  // Each new node lies on a stretch that begins at an old node, `ahead` after it.
  double ahead = std::fmod((other.equations_.section_phase() - equations_.section_phase()) * T, length);
  if (ahead < 0.0) ahead += length;
  const auto shift =
      static_cast<int>(std::lround((equations_.section_phase() * T + ahead - other.equations_.section_phase() * T) / length));
  const std::optional<Vector> moved = carried_on(u, ahead);
  if (!moved) return std::nullopt;
  Vector out = u;
  for (int j = 0; j < N; ++j) out.segment(((j + shift) % N + N) % N * n, n) = moved->segment(j * n, n);
  return out;
}

OrbitProblem OrbitProblem::in_half_steps() const {
  FlowOptions options = equations_.options();
  options.tolerance *= half_steps;
  OrbitProblem other(system(), p_, period(), nodes(), free_, options, equations_.section_phase());
  other.measure_as(*this);
  other.equations_.copy_phase_condition(equations_);
  return other;
}

OrbitProblem OrbitProblem::with_nodes(int times) const {
  OrbitProblem finer(system(), p_, period(), times * nodes(), free_, equations_.options(), equations_.section_phase());
  finer.measure_as(*this);
  return finer;
}

OrbitProblem OrbitProblem::repeated(int times) const {
  OrbitProblem longer(system(), p_, times * period(), times * nodes(), free_, equations_.options(), equations_.section_phase());
  longer.measure_as(*this);
  return longer;
}

Vector OrbitProblem::repeat(const Vector& u, int times) const {
  if (times < 1) throw std::invalid_argument(fmt::format("an orbit was to be repeated {} times; allowed is 1 and more", times));
  const Eigen::Index length = states() * nodes(), rest = u.size() - length;
  Vector out(times * length + rest);
  out << u.head(length).replicate(times, 1), u.tail(rest);
  if (equations_.autonomous()) out[times * length] *= times;
  return out;
}

std::optional<Vector> OrbitProblem::to_nodes(OrbitProblem& finer, const Vector& u) {
  const int times = finer.nodes() / nodes();
  if (!evaluate(u, {.sensitivity = Sensitivity::none})) return std::nullopt;
  const Vector shortened = orbit_part(u);
  const double length = equations_.duration(shortened) / finer.nodes();
  std::vector<Vector> nodes_there;
  Transition transition;
  for (int j = 0; j < nodes(); ++j) {
    nodes_there.push_back(equations_.node(shortened, j));
    for (int k = 1; k < times; ++k) {
      const double start = equations_.node_time(shortened, j);
      carry(equations_.propagator(), start, start + k * length, nodes_there[static_cast<std::size_t>(j * times)],
            {.sensitivity = Sensitivity::none}, transition);
      if (transition.termination != Termination::time) return std::nullopt;
      nodes_there.push_back(transition.x1);
    }
  }
  return finer.pack(nodes_there, equations_.duration(shortened), values(u));
}

Vector OrbitProblem::pack(const std::vector<Vector>& nodes, double duration, const Vector& values) const {
  if (static_cast<int>(nodes.size()) != this->nodes())
    throw std::invalid_argument(fmt::format("{} nodes were given; these equations have {}", nodes.size(), this->nodes()));
  Vector u(unknowns());
  const int n = states();
  for (int j = 0; j < this->nodes(); ++j) u.segment(j * n, n) = nodes[static_cast<std::size_t>(j)];
  if (equations_.autonomous()) u[n * this->nodes()] = duration;
  set_values(u, values);
  return u;
}

bool OrbitProblem::evaluate(const Vector& u, const TransitionOptions& options) {
  if (!set_value(equations_, u)) return false;
  // At the start of a branch there is no earlier orbit to which the phase condition could refer.
  if (equations_.autonomous() && !equations_.has_phase_reference()) equations_.set_phase_reference(u.head(states()));
  if (equations_.evaluate(orbit_part(u), options)) return true;
  failure_ = termination_text(equations_.failure());
  return false;
}

std::string OrbitProblem::failure() const { return failure_; }

bool OrbitProblem::residual(const Vector& u, Vector& residual, Matrix* jacobian) {
  if (!evaluate(u, {.sensitivity = jacobian ? Sensitivity::state_and_parameters : Sensitivity::none})) return false;
  equations_.residual(orbit_part(u), residual);
  pin_residual(u, residual);
  if (jacobian) {
    equations_.jacobian(*jacobian);
    pin_rows(*jacobian);
  }
  return residual.allFinite() && (!jacobian || jacobian->allFinite());
}

std::vector<PinnedState> OrbitProblem::kept_states(const Vector& u) const {
  if (!u.allFinite()) return {};
  OrbitProblem apart = with_section(equations_.section_phase());
  apart.pinned_.clear();
  if (!apart.set_value(apart.equations_, u)) return {};
  const Vector& p = apart.p_;
  // Only if constraints already hold at the first node. Separate equations are used, so that this does not count as time
  // carried for the branch.
  const HybridState start{apart.equations_.node_time(u, 0), equations_.node(u, 0), 0};
  const std::optional<std::size_t> mode = mode_at(system(), start.t, start.x, p);
  if (!mode || !holds(system(), system()->modes[*mode].constraints, {start.t, start.x, *mode}, p)) return {};
  Vector residual;
  Matrix jacobian;
  if (!apart.residual(u, residual, &jacobian)) return {};
  return BranchProblem::kept_states(u, jacobian);
}

ZeroProblem OrbitProblem::zero_problem() {
  ZeroProblem problem;
  problem.unknowns = unknowns();
  problem.evaluate = [this](const Vector& u, Vector& r, Matrix* J) { return residual(u, r, J); };
  problem.failure = [this] { return failure(); };
  // The mean over the nodes: the arclength does not depend on their number.
  problem.weights = Vector::Constant(unknowns(), 1.0 / (nodes() * size_ * size_));
  problem.size = size_;
  weigh_values(problem.weights);
  return problem;
}

PeriodicOrbit OrbitProblem::orbit(const Vector& u, const std::optional<NewtonReport>& report) {
  p_ = parameters_at(u);
  equations_.set_parameters(p_);
  if (equations_.autonomous()) equations_.set_phase_reference(u.head(states()));
  const Vector unknowns = orbit_part(u);
  return report ? describe_orbit(equations_, unknowns, *report) : describe_orbit(equations_, unknowns);
}

BranchPoint OrbitProblem::branch_point(const Vector& u, double arclength) {
  const PeriodicOrbit here = orbit(u);
  BranchPoint point = to_branch_point(here, value(u), arclength);
  point.shape = shape_of(system(), here);
  return point;
}

BranchPoint to_branch_point(const PeriodicOrbit& orbit, double value, double arclength) {
  BranchPoint point;
  point.value = value;
  point.arclength = arclength;
  point.states = orbit.states;
  point.nodes = orbit.nodes;
  point.section_phase = orbit.section_phase;
  point.duration = orbit.duration;
  point.multipliers = orbit.multipliers;
  point.signature = orbit.signature;
  point.impacts = orbit.impacts;
  point.isolated_impacts = orbit.isolated_impacts;
  point.stable = orbit.stable();
  point.admissible = orbit.admissible;
  point.checks = orbit.checks;
  return point;
}

Eigen::MatrixXcd OrbitProblem::cyclic(const Vector&, std::complex<double> sigma) {
  const int n = states(), N = nodes();
  Eigen::MatrixXcd K = Eigen::MatrixXcd::Zero(n * N, n * N);
  for (int j = 0; j < N; ++j) {
    K.block(j * n, j * n, n, n) += equations_.stretch(j).Phi.cast<std::complex<double>>();
    const std::complex<double> link = j + 1 < N ? 1.0 : sigma;
    K.block(j * n, (j + 1) % N * n, n, n).diagonal().array() -= link;
  }
  pin_rows(K);
  return K;
}

std::vector<BranchProblem::Image> OrbitProblem::images(const Vector& u, const Vector& tangent) const {
  std::vector<Image> list{{u, tangent}};
  const Eigen::Index size = states() * nodes();
  if (equations_.autonomous() || nodes() % period() != 0) return list;
  const Eigen::Index one_period = size / period();
  for (Eigen::Index by = one_period; by < size; by += one_period) {
    const auto later = [&](const Vector& v) {
      Vector out = v;
      out.head(size) << v.segment(by, size - by), v.head(by);
      return out;
    };
    list.push_back({later(u), later(tangent)});
  }
  return list;
}

BranchProblem::Doubled OrbitProblem::doubled(const Vector& u) const {
  return {std::make_unique<OrbitProblem>(repeated(2)), repeat(u, 2)};
}

Vector OrbitProblem::half_difference(const Vector& u) const {
  if (period() % 2 != 0 || nodes() % 2 != 0) return {};
  const Eigen::Index half = states() * nodes() / 2;
  return u.segment(half, half) - u.head(half);
}

Eigen::VectorXcd OrbitProblem::cyclic_derivative(const Vector& u, std::complex<double>, const Eigen::VectorXcd& left,
                                                 const Eigen::VectorXcd& v) {
  const Eigen::VectorXcd w = without_pinned_rows(left);
  const int n = states(), N = nodes();
  Eigen::VectorXcd derivative = Eigen::VectorXcd::Zero(unknowns());
  const auto form = [&](int j, const Matrix& Phi) -> std::complex<double> {
    return w.segment(j * n, n).dot(Phi.cast<std::complex<double>>() * v.segment(j * n, n));
  };
  const TransitionOptions tangent{.sensitivity = Sensitivity::state};
  // A node affects its own stretch only. The parameters (and the duration) affect all stretches.
  if (!evaluate(u, tangent)) return derivative;
  Transition moved;
  for (int j = 0; j < N; ++j) {
    const Vector shortened = orbit_part(u);
    const double start = equations_.node_time(shortened, j), length = equations_.duration(shortened) / N;
    for (int k = 0; k < n; ++k)
      derivative[j * n + k] =
          difference(difference_step * (1.0 + std::abs(u[j * n + k])), [&](double shift) -> std::optional<std::complex<double>> {
            Vector x = equations_.node(u, j);
            x[k] += shift;
            carry(equations_.propagator(), start, start + length, x, tangent, moved);
            if (moved.termination != Termination::time) return std::nullopt;
            return form(j, moved.Phi);
          });
  }
  for (Eigen::Index i = n * N; i < unknowns(); ++i)
    derivative[i] = difference(difference_step * size_of_unknown(u, i), [&](double shift) -> std::optional<std::complex<double>> {
      Vector shifted = u;
      shifted[i] += shift;
      if (!evaluate(shifted, tangent)) return std::nullopt;
      std::complex<double> sum = 0.0;
      for (int j = 0; j < N; ++j) sum += form(j, equations_.stretch(j).Phi);
      return sum;
    });
  evaluate(u, tangent);
  return derivative;
}

}  // namespace graze
