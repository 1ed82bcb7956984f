// SPDX-License-Identifier: GPL-3.0-or-later
// Predicts, to first order, the orbits that begin where a periodic orbit of a hard oscillator touches the barrier once in its
// period (one degree of freedom). A reference by linear algebra alone.
//
// M is the linear map of the deviation (x, x') over one turn, from touch to touch. A weak impact of speed v adds the kick (0,
// -(1 + k_r) v). I is the set of those of the m turns that have an impact. Consider the orbit that closes after m turns with a
// single kick of unit speed. R_k is its deviation in x, k turns after the kick:
//     R_k = first of M^k z,  k = 1 ... m,   z = (1 - M^m)^{-1} (0, -(1 + k_r)).
// The free maxima of the turns lie at h_i = d + sum_{j in I} R_{i - j} v_j above the barrier; d is the value for the orbit
// without any impact. In the turns of I the maximum touches to first order (h_i = 0; its excess is the square of the speed).
// In all other turns it must stay below the barrier. The conditions are therefore v_j > 0 in I and h_i < 0 elsewhere. d > 0:
// the family exists beyond the grazing; d < 0: on the near side.
#pragma once

#include <Eigen/LU>

#include <vector>

namespace graze::support {

/// 1: beyond the grazing, -1: on the near side, 0: no such family. `struck`: the turns with an impact.
inline int side_of_family(const Eigen::Matrix2d& M, double k_r, int turns, const std::vector<int>& struck) {
  Eigen::Matrix2d power = Eigen::Matrix2d::Identity();
  for (int k = 0; k < turns; ++k) power = M * power;
  const Eigen::Vector2d z = (Eigen::Matrix2d::Identity() - power).inverse() * Eigen::Vector2d(0.0, -(1.0 + k_r));
  std::vector<double> R{0.0};
  Eigen::Vector2d deviation = z;
  for (int k = 1; k <= turns; ++k) {
    deviation = M * deviation;
    R.push_back(deviation[0]);
  }
  const auto response = [&](int i, int j) { return R[static_cast<std::size_t>((i - j + turns - 1) % turns + 1)]; };
  const auto count = static_cast<Eigen::Index>(struck.size());
  Eigen::MatrixXd A(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j)
      A(i, j) = response(struck[static_cast<std::size_t>(i)], struck[static_cast<std::size_t>(j)]);
  const Eigen::VectorXd per_d = A.partialPivLu().solve(Eigen::VectorXd::Constant(count, -1.0));
  for (const int d : {1, -1}) {
    bool exists = (d * per_d.array() > 0.0).all();
    for (int i = 0; i < turns && exists; ++i) {
      double h = d;
      bool free = true;
      for (Eigen::Index j = 0; j < count; ++j) {
        h += response(i, struck[static_cast<std::size_t>(j)]) * d * per_d[j];
        free = free && struck[static_cast<std::size_t>(j)] != i;
      }
      exists = !free || h < 0.0;
    }
    if (exists) return d;
  }
  return 0;
}

/// The same for the family with the impact in the first `struck` turns.
inline int side_of_family(const Eigen::Matrix2d& M, double k_r, int turns, int struck) {
  std::vector<int> list;
  for (int i = 0; i < struck; ++i) list.push_back(i);
  return side_of_family(M, k_r, turns, list);
}

}  // namespace graze::support
