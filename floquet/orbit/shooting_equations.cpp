// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/shooting_equations.hpp>

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace graze {

ShootingEquations::ShootingEquations(const SharedSystem& system, const Vector& p, int period, int nodes,
                                     const std::vector<std::size_t>& free, const FlowOptions& options, double section_phase)
    : propagator_(system, p, free, options), n_(static_cast<int>(system->states)), nodes_(nodes > 0 ? nodes : period),
      period_(period), section_phase_(section_phase), free_(free) {
  if (period < 1) throw std::invalid_argument(fmt::format("period n is {}; allowed is a whole number from 1", period));
  if (nodes < 0 || (nodes_ % period != 0 && period % nodes_ != 0))
    throw std::invalid_argument(
        fmt::format("{} shooting nodes were asked for; allowed is a multiple or a divisor of the period {}", nodes, period));
  stretches_.resize(static_cast<std::size_t>(nodes_));
  start_fields_.assign(static_cast<std::size_t>(nodes_), Vector::Zero(n_));
  end_fields_ = start_fields_;
  held_modes_.resize(static_cast<std::size_t>(nodes_));
}

double ShootingEquations::duration(const Vector& u) const {
  return autonomous() ? u[n_ * nodes_] : period_ * forcing_period(system(), parameters());
}

double ShootingEquations::node_time(const Vector& u, int j) const {
  return autonomous() ? orbit_time(u, j) : node_fraction(j) * forcing_period(system(), parameters());
}

double ShootingEquations::orbit_time(const Vector& u, int j) const {
  if (autonomous()) return duration(u) * j / nodes_;
  return (section_phase_ + static_cast<double>(j * period_) / nodes_) * forcing_period(system(), parameters());
}

bool ShootingEquations::evaluate(const Vector& u, const TransitionOptions& options) {
  const double length = duration(u) / nodes_;
  if (!(length > 0.0) || !std::isfinite(length)) {
    failure_ = Termination::failed;
    return false;
  }
  for (int j = 0; j < nodes_; ++j) {
    const auto index = static_cast<std::size_t>(j);
    const double start = node_time(u, j);
    const Vector x0 = node(u, j);
    Transition& transition = stretches_[index];
    TransitionOptions its = options_of_stretch(j, options);
    its.held_mode = held_modes_[index];
    carry(propagator_, start, start + length, x0, its, transition);
    failure_ = transition.termination;
    if (failure_ != Termination::time) return false;
    held_modes_[index] = transition.mode0;
    propagator_.field(transition.mode0, start, x0, start_fields_[index]);
    propagator_.field(transition.mode1, start + length, transition.x1, end_fields_[index]);
  }
  return true;
}

void ShootingEquations::residual(const Vector& u, Vector& out) const {
  out.resize(unknowns());
  for (int j = 0; j < nodes_; ++j) out.segment(j * n_, n_) = stretch(j).x1 - u.segment((j + 1) % nodes_ * n_, n_);
  if (autonomous()) out[n_ * nodes_] = phase_normal_.dot(u.head(n_) - phase_reference_);
}

Matrix ShootingEquations::fixed_time_dp(int j, const Matrix& Phi, const Matrix& Psi) const {
  Matrix out = Psi;
  if (autonomous()) return out;
  // The stretch starts at a fixed fraction of T, which depends on the forcing frequency.
  const Vector period_dp = forcing_period_dp(system(), parameters());
  for (std::size_t k = 0; k < free_.size(); ++k)
    out.col(static_cast<Eigen::Index>(k)) -=
        Phi * start_field(j) * (node_fraction(j) * period_dp[static_cast<Eigen::Index>(free_[k])]);
  return out;
}

Matrix ShootingEquations::stretch_dp(int j) const {
  Matrix out = fixed_time_dp(j, stretch(j).Phi, stretch(j).Psi);
  if (autonomous()) return out;
  const Vector period_dp = forcing_period_dp(system(), parameters());
  for (std::size_t k = 0; k < free_.size(); ++k)
    out.col(static_cast<Eigen::Index>(k)) += end_field(j) * ((node_fraction(j) + static_cast<double>(period_) / nodes_) *
                                                             period_dp[static_cast<Eigen::Index>(free_[k])]);
  return out;
}

void ShootingEquations::jacobian(Matrix& out) const {
  const auto free = static_cast<Eigen::Index>(free_.size());
  out.setZero(unknowns(), unknowns() + free);
  for (int j = 0; j < nodes_; ++j) {
    out.block(j * n_, j * n_, n_, n_) += stretch(j).Phi;
    out.block(j * n_, (j + 1) % nodes_ * n_, n_, n_) -= Matrix::Identity(n_, n_);
    if (autonomous()) out.block(j * n_, n_ * nodes_, n_, 1) = end_fields_[static_cast<std::size_t>(j)] / nodes_;
    if (free > 0) out.block(j * n_, unknowns(), n_, free) = stretch_dp(j);
  }
  if (autonomous()) out.row(n_ * nodes_).head(n_) = phase_normal_.transpose();
}

void ShootingEquations::set_phase_reference(const Vector& x_ref) {
  phase_reference_ = x_ref;
  phase_normal_.resize(n_);
  propagator_.field(propagator_.start(0.0, x_ref).mode, 0.0, x_ref, phase_normal_);
}

}  // namespace graze
