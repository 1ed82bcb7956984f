// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/problems/branch_problem.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace graze {

double parameter_unit(double low, double high) {
  constexpr double smallest = 0.1, largest = 10.0;  // of order one
  const double size = std::max(std::abs(low), std::abs(high));
  if (!(size > 0.0) || !std::isfinite(size)) return 1.0;
  return size < smallest ? size / smallest : size > largest ? size / largest : 1.0;
}

BranchProblem::BranchProblem(SharedSystem system, Vector p, std::vector<FreeParameter> free)
    : system_(std::move(system)), p_(std::move(p)), free_(std::move(free)) {
  if (free_.empty()) throw std::invalid_argument("no free parameter was given; give at least one");
  for (auto one = free_.begin(); one != free_.end(); ++one) {
    if (one->index >= system_->parameters.size())
      throw std::invalid_argument(fmt::format("free parameter {} was asked for; allowed is an index from 0 to {}", one->index,
                                              std::ssize(system_->parameters) - 1));
    if (std::any_of(free_.begin(), one, [&](const FreeParameter& other) { return other.index == one->index; }))
      throw std::invalid_argument(
          fmt::format("free parameter {} was given twice; give it once", system_->parameters[one->index].name));
    if (one->unit == 0.0) one->unit = parameter_unit(one->scale, p_[static_cast<Eigen::Index>(one->index)]);
  }
}

std::vector<std::size_t> BranchProblem::free_indices() const {
  std::vector<std::size_t> list;
  for (const FreeParameter& one : free_) list.push_back(one.index);
  return list;
}

void BranchProblem::set_values(Vector& u, const Vector& values) const {
  if (values.size() != std::ssize(free_))
    throw std::invalid_argument(fmt::format("the number of values is {}, and that of free parameters {}; give one value for each",
                                            values.size(), free_.size()));
  u.tail(values.size()) = values;
}

void BranchProblem::weigh_values(Vector& weights) const {
  Eigen::Index i = orbit_unknowns();
  for (const FreeParameter& one : free_) weights[i++] = 1.0 / (one.scale * one.scale);
}

double BranchProblem::size_of_unknown(const Vector& u, Eigen::Index i) const {
  const Eigen::Index place = i - orbit_unknowns();
  return (place < 0 ? 1.0 : free_[static_cast<std::size_t>(place)].unit) + std::abs(u[i]);
}

double BranchProblem::largest_change(const Vector& change) const {
  double largest = orbit_part(change).lpNorm<Eigen::Infinity>();
  for (std::size_t k = 0; k < free_.size(); ++k)
    largest = std::max(largest, std::abs(values(change)[static_cast<Eigen::Index>(k)]) / free_[k].unit);
  return largest;
}

Vector BranchProblem::parameters_at(const Vector& u) const {
  constexpr double slack = 1e-13;
  Vector p = p_;
  Eigen::Index i = u.size() - std::ssize(free_);
  for (const FreeParameter& one : free_) {
    const ParameterInfo& info = system_->parameters[one.index];
    double& value = p[static_cast<Eigen::Index>(one.index)];
    value = u[i++];
    if (value < info.lower && value > info.lower - slack * (one.unit + std::abs(info.lower)) && !info.lower_open)
      value = info.lower;
    if (value > info.upper && value < info.upper + slack * (one.unit + std::abs(info.upper))) value = info.upper;
  }
  return p;
}

std::vector<PinnedState> BranchProblem::kept_states(const Vector& u, const Matrix& jacobian) const {
  const Layout at = layout();
  const auto kept = [&](const KeptState& one) {
    // Of the columns of times and parameters: the sum over all stretches, and that of the absolute values.
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(jacobian.cols()), size = sum;
    for (Eigen::Index j = 0; j < at.nodes; ++j) {
      Eigen::RowVectorXd row = one.row(jacobian, j * at.block);
      const double rounding = one.rounding(row);
      row.segment(j * at.block + at.before, at.states) -= one.gradient(at.states);
      row.segment((j + 1) % at.nodes * at.block + at.before, at.states) += one.gradient(at.states);
      for (Eigen::Index k = 0; k < at.nodes; ++k) {
        auto states = row.segment(k * at.block + at.before, at.states);
        if (states.lpNorm<Eigen::Infinity>() > rounding) return false;
        states.setZero();
      }
      sum += row;
      size += row.cwiseAbs();
    }
    for (Eigen::Index k = 0; k < std::ssize(free_); ++k) {
      const double unit = free_[static_cast<std::size_t>(k)].unit;
      sum[orbit_unknowns() + k] *= unit;
      size[orbit_unknowns() + k] *= unit;
    }
    constexpr double rounding_of_sum = 1e-10;
    return (sum.array().abs() <= rounding_of_sum * (1.0 + size.array())).all();
  };
  std::vector<PinnedState> list;
  for (const KeptState& one : find_kept_states(at.states, kept)) list.push_back({one, one.of(u.segment(at.before, at.states))});
  return list;
}

void require_one_parameter(const BranchProblem& problem) {
  if (problem.free().size() != 1)
    throw std::invalid_argument(
        fmt::format("a point was asked for in {} free parameters; a point has 1: free one of them, and give the others values",
                    problem.free().size()));
}

}  // namespace graze
