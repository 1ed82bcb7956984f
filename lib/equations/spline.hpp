// SPDX-License-Identifier: GPL-3.0-or-later
// A cubic spline through a table (u_i, y_i), twice continuously differentiable.
//
// Periodic: y_0 = y_n, and the spline repeats with period u_n - u_0. Clamped: the slopes at both ends are given (zero by
// default); beyond its ends the spline continues along its end tangents, so that its second derivative jumps there.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace graze::equations {

struct Table {
  std::string name;
  std::vector<double> u;  ///< strictly increasing, at least two (periodic: three)
  std::vector<double> y;
  bool periodic = false;
  double first_slope = 0.0, last_slope = 0.0;  ///< of a clamped spline
};

struct Spline {
  Table table;
  std::vector<double> slope;  ///< at the knots

  /// The value (order 0) or a derivative of the given order at u.
  template <class Number> Number value(int order, Number u) const;
};

/// @throws std::invalid_argument if the table does not describe a spline.
Spline make_spline(Table table);

template <class Number> Number Spline::value(int order, Number u) const {
  using std::floor;
  const std::vector<double>& knots = table.u;
  const Number first = knots.front(), last = knots.back();
  if (table.periodic) {
    u -= (last - first) * floor((u - first) / (last - first));
  } else if (u < first || u > last) {
    const bool below = u < first;
    const Number tangent = below ? slope.front() : slope.back();
    if (order > 1) return Number(0);
    if (order == 1) return tangent;
    return (below ? Number(table.y.front()) : Number(table.y.back())) + tangent * (u - (below ? first : last));
  }
  auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, u, [](const Number& a, double b) { return a < b; });
  const auto i = static_cast<std::size_t>(above - knots.begin()) - 1;
  const Number h = Number(knots[i + 1]) - knots[i], s = u - knots[i];
  const Number chord = (Number(table.y[i + 1]) - table.y[i]) / h;
  const Number c2 = (Number(3) * chord - Number(2) * slope[i] - slope[i + 1]) / h;
  const Number c3 = (Number(slope[i]) + slope[i + 1] - Number(2) * chord) / (h * h);
  switch (order) {
  case 0:
    return table.y[i] + s * (slope[i] + s * (c2 + s * c3));
  case 1:
    return slope[i] + s * (Number(2) * c2 + Number(3) * s * c3);
  case 2:
    return Number(2) * c2 + Number(6) * s * c3;
  case 3:
    return Number(6) * c3;
  default:
    return Number(0);
  }
}

}  // namespace graze::equations
