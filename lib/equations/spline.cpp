// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/spline.hpp>

#include <graze/lib/numerics/vector.hpp>

#include <Eigen/SparseLU>
#include <fmt/format.h>

#include <stdexcept>

namespace graze::equations {

Spline make_spline(Table table) {
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(fmt::format("table {}: {}", table.name, what));
  };
  const std::size_t knots = table.u.size();
  if (table.y.size() != knots) refuse(fmt::format("it has {} arguments and {} values", knots, table.y.size()));
  const std::size_t fewest = table.periodic ? 3 : 2;
  if (knots < fewest) refuse(fmt::format("it has {} points; a spline needs {}", knots, fewest));
  for (std::size_t i = 0; i < knots; ++i) {
    if (!std::isfinite(table.u[i]) || !std::isfinite(table.y[i])) refuse("it holds a value that is not a finite number");
    if (i > 0 && !(table.u[i] > table.u[i - 1])) refuse("its arguments do not increase");
  }
  if (table.periodic && table.y.front() != table.y.back())
    refuse(fmt::format("it is periodic, but its first value {} is not its last {}", table.y.front(), table.y.back()));
  // Equations: continuity of the second derivative at each knot. Unknowns: the slopes.
  const auto n = static_cast<Eigen::Index>(table.periodic ? knots - 1 : knots);
  std::vector<Eigen::Triplet<double>> entries;
  Vector right(n);
  const auto width = [&](std::size_t i) { return table.u[i + 1] - table.u[i]; };
  const auto chord = [&](std::size_t i) { return (table.y[i + 1] - table.y[i]) / width(i); };
  for (Eigen::Index row = 0; row < n; ++row) {
    const auto i = static_cast<std::size_t>(row);
    if (!table.periodic && (row == 0 || row == n - 1)) {
      entries.emplace_back(row, row, 1.0);
      right[row] = row == 0 ? table.first_slope : table.last_slope;
      continue;
    }
    const std::size_t before = i == 0 ? knots - 2 : i - 1;
    const double a = 1.0 / width(before), b = 1.0 / width(i);
    entries.emplace_back(row, static_cast<Eigen::Index>(before), a);
    entries.emplace_back(row, row, 2.0 * (a + b));
    entries.emplace_back(row, table.periodic ? (row + 1) % n : row + 1, b);
    right[row] = 3.0 * (a * chord(before) + b * chord(i));
  }
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SparseLU<Eigen::SparseMatrix<double>> solver(matrix);
  const Vector slopes = solver.solve(right);
  Spline spline{std::move(table), {slopes.begin(), slopes.end()}};
  if (spline.table.periodic) spline.slope.push_back(spline.slope.front());
  return spline;
}

}  // namespace graze::equations
