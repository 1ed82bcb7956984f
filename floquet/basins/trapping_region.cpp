// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/basins/trapping_region.hpp>
#include <graze/floquet/orbit/multipliers.hpp>
#include <graze/floquet/orbit/state_distance.hpp>
#include <graze/lib/motion/rest.hpp>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <random>

namespace graze {

namespace {

/// Contraction rate of one period in the adapted metric, for an orbit whose own is `rate`.
double chosen_rate(double rate) { return std::sqrt(std::max(rate, 0.01)); }

/// H_k of the head comment, by backward iteration around the orbit until they no longer change; empty if this does not happen.
std::vector<Matrix> adapted_metrics(const std::vector<Matrix>& Phi, double q) {
  const auto n = Phi.front().rows();
  const Matrix one = Matrix::Identity(n, n);
  std::vector<Matrix> H(Phi.size(), one);
  constexpr int most_rounds = 1000000;
  constexpr double still = 1e-13;
  for (int round = 0; round < most_rounds; ++round) {
    double change = 0.0;
    for (std::size_t k = Phi.size(); k-- > 0;) {
      const Matrix next = one + Phi[k].transpose() * H[(k + 1) % H.size()] * Phi[k] / (q * q);
      change = std::max(change, (next - H[k]).lpNorm<Eigen::Infinity>() / next.lpNorm<Eigen::Infinity>());
      H[k] = next;
    }
    if (!std::isfinite(change)) return {};
    if (change < still) return H;
  }
  return {};
}

/// Unit vectors in all directions.
std::vector<Vector> directions(Eigen::Index n) {
  std::vector<Vector> list;
  if (n == 2) {
    constexpr int count = 32;
    for (int i = 0; i < count; ++i) list.push_back(Vector{{std::cos(2.0 * M_PI * i / count), std::sin(2.0 * M_PI * i / count)}});
    return list;
  }
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (Eigen::Index i = 0; i < 32 * n; ++i) {
    Vector u(n);
    for (double& entry : u) entry = normal(random);
    list.push_back(u.normalized());
  }
  return list;
}

/// Events across which state or field jumps. The motion is differentiable at the others, whether it meets them or not.
std::vector<std::size_t> jumps(const HybridSystem& system, std::vector<std::size_t> events) {
  std::erase_if(events, [&](std::size_t event) { return system.events[event].continuous; });
  return events;
}

/// The region of a mass at rest on its stop: bounces so small that they end there, or die out.
TrappingRegion around_rest(Propagator& propagator, TrappingRegion region, const Matrix& Phi) {
  const double rate = std::abs(product_eigenvalues({Phi}).front());
  if (!(rate < 1.0)) return region;
  region.rate = rate;
  const Bounces bounces = bounces_to_rest(propagator, region.centres.front());
  if (!(bounces.height > 0.0)) return region;
  region.size = std::max(bounces.height, bounces.speed);
  const Vector scales{{region.size / bounces.height, region.size / bounces.speed}};
  region.metrics = {Matrix(scales.cwiseAbs2().asDiagonal())};
  return region;
}

double norm_in(const Matrix& H, const Vector& d) { return std::sqrt(std::max(0.0, d.dot(H * d))); }

}  // namespace

bool TrappingRegion::holds(const Vector& x) const {
  if (!(size > 0.0)) return rate < 1.0 && std::find(centres.begin(), centres.end(), x) != centres.end();
  const Eigen::Index n = x.size();
  for (std::size_t k = 0; k < centres.size(); ++k) {
    const Vector& c = centres[k];
    bool near = true;  // entry by entry: usually the first one already differs too much
    for (Eigen::Index i = 0; near && i < n; ++i) near = std::abs(x[i] - c[i]) <= size;
    if (!near) continue;
    double V = 0.0;
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) V += (x[i] - c[i]) * metrics[k](i, j) * (x[j] - c[j]);
    if (V <= size * size) return true;
  }
  return false;
}

std::vector<StateEllipse> TrappingRegion::ellipses() const {
  constexpr double larger = 1.001;  // than the effect of rounding
  std::vector<StateEllipse> list;
  constexpr double nothing_else = 1e300;  // any number times the square of a distance
  if (!(size > 0.0)) {
    if (!(rate < 1.0)) return list;
    for (const Vector& c : centres) list.push_back({c[0], c[1], nothing_else, 0.0, nothing_else});
    return list;
  }
  const double scale = 1.0 / (larger * size * size);
  for (std::size_t k = 0; k < centres.size(); ++k) {
    const Matrix H = scale * metrics[k];
    list.push_back({centres[k][0], centres[k][1], H(0, 0), H(0, 1) + H(1, 0), H(1, 1)});
  }
  return list;
}

double TrappingRegion::distance(const Vector& x) const { return nearest_distance(centres, x); }

TrappingRegion trapping_region(const HybridSystem& system, const Vector& p, const Vector& state, int period,
                               const FlowOptions& flow) {
  TrappingRegion region;
  Propagator propagator(system, p, {}, flow);
  Transition transition;
  std::vector<Matrix> Phi;
  std::vector<std::vector<std::size_t>> events;
  Vector x = state;
  double scale = 1.0;
  bool differentiable = true;
  for (int k = 0; k < period; ++k) {
    region.centres.push_back(x);
    scale = std::max(scale, 1.0 + x.lpNorm<Eigen::Infinity>());
    if (differentiable) carry_period(propagator, x, {}, transition);
    differentiable = differentiable && transition.termination == Termination::time;
    if (!differentiable) carry_period(propagator, x, {.sensitivity = Sensitivity::none}, transition);
    if (transition.termination != Termination::time) return region;
    Phi.push_back(period_map(transition));
    events.push_back(jumps(system, transition.event_sequence));
    x = transition.x1;
  }
  if (!differentiable) return region;
  if (period == 1 && permanent_rest(propagator, state) == state) return around_rest(propagator, std::move(region), Phi.front());
  const auto values = product_eigenvalues(Phi);
  const double rate = std::pow(std::abs(values.front()), 1.0 / period);
  if (!(rate < 1.0)) return region;
  region.rate = rate;
  const double q = chosen_rate(rate), enough = 0.5 * (1.0 + q);
  std::vector<Matrix> H = adapted_metrics(Phi, q);
  if (H.empty()) return region;
  std::vector<Matrix> unit_ball;  // each maps the unit ball onto V_k <= 1
  for (const Matrix& metric : H) {
    const Eigen::LLT<Matrix> root(metric);
    const Matrix upper = root.matrixU();
    unit_ball.push_back(upper.triangularView<Eigen::Upper>().solve(Matrix::Identity(upper.rows(), upper.cols())));
  }
  const std::vector<Vector> round = directions(state.size());
  // Maps the unit ball onto that of V_k; for an autonomous system within the surface of the returns.
  const auto on_ball = [&](std::size_t k, const Vector& u) {
    if (is_forced(system)) return Vector(unit_ball[k] * u);
    const Vector along = Phi[(k + Phi.size() - 1) % Phi.size()] * u;
    const double length = norm_in(H[k], along);
    return Vector(length > 0.0 ? along / length : along);
  };
  const auto contracts = [&](double size) {
    for (std::size_t k = 0; k < H.size(); ++k) {
      const std::size_t next = (k + 1) % H.size();
      for (const Vector& u : round) {
        carry_period(propagator, region.centres[k] + size * on_ball(k, u), {.sensitivity = Sensitivity::none}, transition);
        if (transition.termination != Termination::time || jumps(system, transition.event_sequence) != events[k]) return false;
        if (norm_in(H[next], transition.x1 - region.centres[next]) > enough * size) return false;
      }
    }
    return true;
  };
  // Below this size the rounding in the motion over a period would be visible.
  const double smallest = 1e-8 * scale;
  for (double size = 0.5 * scale; size > smallest; size *= 0.5) {
    if (!contracts(2.0 * size) || !contracts(size) || !contracts(0.5 * size)) continue;
    region.size = size;
    break;
  }
  region.metrics = std::move(H);
  return region;
}

}  // namespace graze
