// SPDX-License-Identifier: GPL-3.0-or-later
// The linear algebra of graze: dense vectors and matrices of double, from Eigen.
#pragma once

#include <Eigen/Dense>

namespace graze {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

}  // namespace graze
