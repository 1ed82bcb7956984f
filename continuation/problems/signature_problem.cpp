// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/problems/clear_section.hpp>
#include <graze/continuation/problems/signature_problem.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace graze {

std::size_t EventNodes::insert(std::size_t event, double t, const Vector& x) {
  const auto place = std::upper_bound(times.begin(), times.end(), t) - times.begin();
  sequence.insert(sequence.begin() + place, event);
  times.insert(times.begin() + place, t);
  states.insert(states.begin() + place, x);
  return static_cast<std::size_t>(place);
}

void EventNodes::shorten(int turns) {
  const std::size_t kept = times.size() / static_cast<std::size_t>(turns);
  sequence.resize(kept);
  times.resize(kept);
  states.resize(kept);
}

void EventNodes::repeat(int turns, double duration) {
  const std::size_t once = times.size();
  for (std::size_t k = once; k < once * static_cast<std::size_t>(turns); ++k) {
    sequence.push_back(sequence[k - once]);
    times.push_back(times[k - once] + duration);
    states.push_back(states[k - once]);
  }
}

std::optional<EventNodes> event_nodes(const PeriodicOrbit& orbit) {
  EventNodes nodes;
  for (const EventRecord& event : orbit.events) {
    if (event.kind == EventKind::stick || event.kind == EventKind::release || event.follows) return std::nullopt;
    nodes.sequence.push_back(event.event);
    nodes.times.push_back(event.t);
    nodes.states.push_back(event.x_minus);
  }
  if (nodes.sequence.empty()) return std::nullopt;
  return nodes;
}

SignatureProblem::SignatureProblem(const SharedSystem& system, const Vector& p, int period, std::vector<std::size_t> sequence,
                                   std::vector<FreeParameter> free, const FlowOptions& options)
    : BranchProblem(system, p, std::move(free)), equations_(system, p, period, std::move(sequence), free_indices(), options),
      options_(options) {}

SignatureProblem::SignatureProblem(const SharedSystem& system, const Vector& p, int period, std::vector<std::size_t> sequence,
                                   std::size_t parameter, double scale, const FlowOptions& options)
    : SignatureProblem(system, p, period, std::move(sequence), {{parameter, scale}}, options) {}

Vector SignatureProblem::pack(const EventNodes& nodes, const Vector& values) const {
  const int block = equations_.states() + 1;
  Vector u(unknowns());
  for (int k = 0; k < equations_.events(); ++k) {
    u[k * block] = nodes.times[static_cast<std::size_t>(k)];
    u.segment(k * block + 1, block - 1) = nodes.states[static_cast<std::size_t>(k)];
  }
  set_values(u, values);
  return u;
}

EventNodes SignatureProblem::unpack(const Vector& u) const {
  EventNodes nodes{equations_.sequence(), {}, {}};
  for (int k = 0; k < equations_.events(); ++k) {
    nodes.times.push_back(equations_.time(u, k));
    nodes.states.push_back(equations_.state(u, k));
  }
  return nodes;
}

ZeroProblem SignatureProblem::zero_problem() {
  ZeroProblem problem;
  problem.unknowns = unknowns();
  problem.evaluate = [this](const Vector& u, Vector& residual, Matrix* jacobian) {
    if (!set_value(u)) return false;
    failure_ = "a flight between two impacts could not be carried out";
    if (!equations_.evaluate(u, residual, jacobian)) return false;
    pin_residual(u, residual);
    if (jacobian) pin_rows(*jacobian);
    return true;
  };
  problem.failure = [this] { return failure_; };
  const int size = equations_.states() + 1;
  problem.weights = Vector::Constant(unknowns(), 1.0 / (equations_.events() * size_ * size_));
  for (int k = 0; k < equations_.events(); ++k) problem.weights[k * size] = 1.0 / equations_.events();
  problem.size = size_;
  weigh_values(problem.weights);
  return problem;
}

std::vector<PinnedState> SignatureProblem::kept_states(const Vector& u) const {
  SignatureProblem apart(system(), p_, equations_.period(), equations_.sequence(), free_, options_);
  Vector residual;
  Matrix jacobian;
  if (!apart.set_value(u) || !apart.equations_.holds_states(u)) return {};
  if (!apart.equations_.evaluate(u, residual, &jacobian)) return {};
  return BranchProblem::kept_states(u, jacobian);
}

std::optional<SignatureEquations::Violation> SignatureProblem::violation(const Vector& u) {
  if (!set_value(u)) return SignatureEquations::Violation{};
  return equations_.violation(u);
}

double SignatureProblem::least_speed(const Vector& u) {
  double least = std::numeric_limits<double>::infinity();
  if (!set_value(u)) return least;
  for (int k = 0; k < equations_.events(); ++k) least = std::min(least, equations_.scaled_speed(u, k));
  return least;
}

bool SignatureProblem::through_modes() const {
  const std::vector<std::size_t>& sequence = equations_.sequence();
  const std::vector<Event>& events = equations_.system().events;
  return std::any_of(sequence.begin(), sequence.end(), [&](std::size_t k) { return events[k].to != events[k].from; });
}

double SignatureProblem::speed(const Vector& u, int event) {
  set_value(u);
  return equations_.speed(u, event);
}

Vector SignatureProblem::speed_gradient(const Vector& u, int event) {
  set_value(u);
  return equations_.speed_gradient(u, event);
}

/// A forcing phase (over 2 pi) clear of impacts: 0 if no impact is within 0.02 of it, else the middle of the widest gap.
double SignatureProblem::clear_section(const Vector& u) const {
  const double T = equations_.duration() / equations_.period();
  std::vector<double> phases;
  for (int k = 0; k < equations_.events(); ++k) {
    const double phase = std::fmod(equations_.time(u, k) / T, 1.0);
    phases.push_back(phase < 0.0 ? phase + 1.0 : phase);
  }
  std::sort(phases.begin(), phases.end());
  constexpr double room = 0.02;
  if (phases.front() > room && phases.back() < 1.0 - room) return 0.0;
  return std::fmod(widest_gap(phases).middle, 1.0);
}

/// The states at these times; NaN if a flight cannot be carried out. Equations evaluated at NaN then fail, which is not misuse.
std::vector<Vector> SignatureProblem::states_at(const Vector& u, const std::vector<double>& times) {
  std::vector<Vector> states = equations_.states_at(u, times);
  const Vector nowhere = Vector::Constant(equations_.states(), std::numeric_limits<double>::quiet_NaN());
  if (states.empty()) states.assign(times.size(), nowhere);
  return states;
}

OrbitProblem& SignatureProblem::stroboscopic(const Vector& u, Vector& out) {
  set_value(u);
  if (stroboscopic_) carried_elsewhere_ += stroboscopic_->time_carried();
  stroboscopic_ = std::make_unique<OrbitProblem>(in_states(u, 1, clear_section(u), out));
  return *stroboscopic_;
}

OrbitProblem SignatureProblem::in_states(const Vector& u, int per_period, double section, Vector& out) {
  set_value(u);
  const int n = equations_.period(), nodes = n * per_period;
  const double T = equations_.duration() / n;
  OrbitProblem problem(system(), p_, n, nodes, free_, options_, section);
  std::vector<double> times(static_cast<std::size_t>(nodes));
  for (int j = 0; j < nodes; ++j) times[static_cast<std::size_t>(j)] = (section + static_cast<double>(j) / per_period) * T;
  out = problem.pack(states_at(u, times), equations_.duration(), values(u));
  problem.measure_by(out);
  problem.pin_as(*this, out);
  return problem;
}

Eigen::MatrixXcd SignatureProblem::cyclic(const Vector& u, std::complex<double> sigma) {
  const int n = equations_.states(), size = n + 1, m = equations_.events();
  Eigen::MatrixXcd K = Eigen::MatrixXcd::Zero(m * size, m * size);
  set_value(u);
  SignatureEquations::Block block;
  for (int k = 0; k < m; ++k) {
    if (!equations_.evaluate(u, k, true, block))
      return Eigen::MatrixXcd::Constant(m * size, m * size, std::numeric_limits<double>::quiet_NaN());
    const std::complex<double> link = k + 1 < m ? 1.0 : sigma;
    K.block(k * size, k * size, n, size) += block.own;
    K.block(k * size, (k + 1) % m * size, n, size) += link * block.next;
    K.row(k * size + n).segment(k * size, size) = block.own_gap.transpose();
  }
  pin_rows(K);
  return K;
}

Eigen::VectorXcd SignatureProblem::cyclic_derivative(const Vector& u, std::complex<double> sigma, const Eigen::VectorXcd& left,
                                                     const Eigen::VectorXcd& v) {
  const Eigen::VectorXcd w = without_pinned_rows(left);
  // The derivative only enters the Jacobian of Newton's method, and the equations are smooth: a standard step suffices.
  constexpr double difference_step = 1e-6;
  const int n = equations_.states(), size = n + 1, m = equations_.events();
  Eigen::VectorXcd derivative = Eigen::VectorXcd::Zero(unknowns());
  SignatureEquations::Block block;
  // The contribution of the rows of event k to w^H K v.
  const auto form = [&](const Vector& at, int k) -> std::optional<std::complex<double>> {
    if (!equations_.evaluate(at, k, true, block)) return std::nullopt;
    const std::complex<double> link = k + 1 < m ? 1.0 : sigma;
    const Eigen::VectorXcd rows =
        block.own * v.segment(k * size, size) + link * (block.next * v.segment((k + 1) % m * size, size));
    return w.segment(k * size, n).dot(rows) +
           std::conj(w[k * size + n]) * (block.own_gap.transpose() * v.segment(k * size, size))[0];
  };
  const auto form_of_all = [&](const Vector& at, const std::vector<int>& events) -> std::optional<std::complex<double>> {
    std::complex<double> sum = 0.0;
    for (const int k : events) {
      const std::optional<std::complex<double>> one = form(at, k);
      if (!one) return std::nullopt;
      sum += *one;
    }
    return sum;
  };
  std::vector<int> all(static_cast<std::size_t>(m));
  std::iota(all.begin(), all.end(), 0);
  for (Eigen::Index i = 0; i < unknowns(); ++i) {
    const bool is_parameter = i >= orbit_unknowns();
    // The state of an event affects the flight after it; the time of an event also affects the flight before it.
    const int k = static_cast<int>(i) / size, before = (k + m - 1) % m;
    std::vector<int> affected = is_parameter ? all : std::vector<int>{k};
    if (!is_parameter && i % size == 0 && before != k) affected.push_back(before);
    derivative[i] = difference(difference_step * size_of_unknown(u, i), [&](double shift) -> std::optional<std::complex<double>> {
      Vector shifted = u;
      shifted[i] += shift;
      if (is_parameter && !set_value(shifted)) return std::nullopt;
      return form_of_all(shifted, affected);
    });
  }
  set_value(u);
  return derivative;
}

double SignatureProblem::state_scale(const Vector& u) const {
  // Between events the forced and the free part of a motion are larger than their sum at the events.
  constexpr double cancelled = 4.0;
  double largest = 0.0;
  for (int k = 0; k < equations_.events(); ++k) largest = std::max(largest, equations_.state(u, k).lpNorm<Eigen::Infinity>());
  return 1.0 + cancelled * largest;
}

std::vector<BranchProblem::Image> SignatureProblem::images(const Vector& u, const Vector& tangent) const {
  const std::vector<std::size_t>& sequence = equations_.sequence();
  const int m = equations_.events(), size = equations_.states() + 1, n = equations_.period();
  const Vector p = parameters_at(u);
  const double T = forcing_period(equations_.system(), p);
  const Vector T_dp = forcing_period_dp(equations_.system(), p)(free_indices());
  std::vector<Image> list{{u, tangent}};
  for (int by = 0; by < m; ++by) {
    bool same = true;
    for (int k = 0; k < m && same; ++k)
      same = sequence[static_cast<std::size_t>(k)] == sequence[static_cast<std::size_t>((k + by) % m)];
    // Event times may be counted from any forcing period: along a closed branch they may shift by whole periods.
    for (int periods = -n; same && periods <= n; ++periods) {
      if (by == 0 && periods == 0) continue;
      Image image{u, tangent};
      for (int k = 0; k < m; ++k) {
        const int from = (k + by) % m;
        const double later = (k + by >= m ? n : 0) + periods;
        image.u.segment(k * size, size) = u.segment(from * size, size);
        image.tangent.segment(k * size, size) = tangent.segment(from * size, size);
        image.u[k * size] += later * T;
        for (Eigen::Index i = 0; i < T_dp.size(); ++i) image.tangent[k * size] += later * T_dp[i] * values(tangent)[i];
      }
      list.push_back(std::move(image));
    }
  }
  return list;
}

BranchProblem::Doubled SignatureProblem::doubled(const Vector& u) const {
  const Vector p = parameters_at(u);
  EventNodes twice = unpack(u);
  twice.repeat(2, equations_.period() * forcing_period(equations_.system(), p));
  auto problem =
      std::make_unique<SignatureProblem>(system(), p, 2 * equations_.period(), twice.sequence, free_, options_);
  problem->measure_as(*this);
  Vector start = problem->pack(twice, values(u));
  return {std::move(problem), std::move(start)};
}

std::unique_ptr<BranchProblem> SignatureProblem::with_half_steps() const {
  FlowOptions options = options_;
  options.tolerance *= half_steps;
  auto other =
      std::make_unique<SignatureProblem>(system(), p_, equations_.period(), equations_.sequence(), free_, options);
  other->measure_as(*this);
  return other;
}

Vector SignatureProblem::half_difference(const Vector& u) const {
  const std::vector<std::size_t>& sequence = equations_.sequence();
  const int m = equations_.events(), size = equations_.states() + 1, n = equations_.period();
  if (n % 2 != 0 || m % 2 != 0 || !std::equal(sequence.begin(), sequence.begin() + m / 2, sequence.begin() + m / 2)) return {};
  const Vector p = parameters_at(u);
  Vector out = u.segment(m / 2 * size, m / 2 * size) - u.head(m / 2 * size);
  const int half = n / 2;
  for (int k = 0; k < m / 2; ++k) out[k * size] -= half * forcing_period(equations_.system(), p);
  return out;
}

double SignatureProblem::time_carried() const {
  return equations_.time_carried() + carried_elsewhere_ + (stroboscopic_ ? stroboscopic_->time_carried() : 0.0);
}

PeriodicOrbit SignatureProblem::orbit(const Vector& u, const std::optional<NewtonReport>& report) {
  Vector states;
  OrbitProblem& problem = stroboscopic(u, states);
  return problem.orbit(states, report);
}

BranchPoint SignatureProblem::branch_point(const Vector& u, double arclength) {
  BranchPoint point;
  if (!set_value(u)) return point;
  const HybridSystem& system = equations_.system();
  const int n = equations_.period(), m = equations_.events();
  const double T = equations_.duration() / n;
  point.value = value(u);
  point.arclength = arclength;
  point.duration = equations_.duration();
  point.section_phase = clear_section(u);
  std::vector<double> phase_0, sections;
  for (int j = 0; j < n; ++j) {
    phase_0.push_back(j * T);
    sections.push_back((point.section_phase + j) * T);
  }
  point.states = states_at(u, phase_0);
  point.nodes = point.section_phase == 0.0 ? point.states : states_at(u, sections);
  std::vector<std::pair<double, std::size_t>> events;
  for (int k = 0; k < m; ++k) {
    double t = std::fmod(equations_.time(u, k), point.duration);
    if (t < 0.0) t += point.duration;
    events.emplace_back(t, equations_.sequence()[static_cast<std::size_t>(k)]);
  }
  std::sort(events.begin(), events.end());
  point.signature.mode = equations_.mode_at(u, 0.0);
  for (const auto& event : events) point.signature.events.push_back(event.second);
  point.impacts = point.isolated_impacts = impacts(system, point.signature);
  point.shape.period = n;
  for (int k = 0; k < m; ++k)
    point.shape.nodes.push_back(
        {equations_.sequence()[static_cast<std::size_t>(k)], equations_.time(u, k) / T, equations_.state(u, k)});
  Vector residual;
  if (equations_.evaluate(u, residual, nullptr))
    point.checks.residual = residual.lpNorm<Eigen::Infinity>() / (1.0 + u.lpNorm<Eigen::Infinity>());
  point.multipliers = multipliers(equations_.monodromy(u, &point.checks.liouville), point.duration);
  point.weakest_speed = least_speed(u);
  point.stable = point.multipliers.stable();
  point.admissible = equations_.violation(u) ? Admissibility::inadmissible : Admissibility::admissible;
  return point;
}

}  // namespace graze
