// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: the coefficients of a mode's structure that depend on the active parameters. The series of a flow carry derivatives
// in the coefficients; dx/dp is dx/dq dq/dp.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <span>
#include <vector>

namespace graze::detail {

struct Sources {
  std::vector<std::size_t> coefficients;
  Matrix dp;  ///< of these coefficients in the active parameters

  /// `all` is d(coefficients)/dp in all parameters.
  Sources(const Matrix& all, std::span<const std::size_t> active) {
    Matrix of_active(all.rows(), static_cast<Eigen::Index>(active.size()));
    for (std::size_t i = 0; i < active.size(); ++i)
      of_active.col(static_cast<Eigen::Index>(i)) = all.col(static_cast<Eigen::Index>(active[i]));
    for (Eigen::Index i = 0; i < all.rows(); ++i)
      if (!of_active.row(i).isZero(0.0)) coefficients.push_back(static_cast<std::size_t>(i));
    dp.resize(static_cast<Eigen::Index>(coefficients.size()), of_active.cols());
    for (std::size_t i = 0; i < coefficients.size(); ++i)
      dp.row(static_cast<Eigen::Index>(i)) = of_active.row(static_cast<Eigen::Index>(coefficients[i]));
  }
};

}  // namespace graze::detail
