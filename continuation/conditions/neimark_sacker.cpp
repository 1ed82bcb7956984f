// SPDX-License-Identifier: GPL-3.0-or-later
// NS, Neimark-Sacker: a complex pair of multipliers crosses the unit circle.
//
// Test function: the product of (mu_i mu_j - 1) over all pairs i < j. It also passes zero if two real multipliers have product
// 1 (a neutral saddle, not a bifurcation). A complex pair outside the circle may become two real multipliers near such a point.
// A sign change is therefore NS only if pairs cross the circle while the numbers of pairs and of real multipliers beyond +-1
// stay the same. If these numbers change too (LP, PD, or a pair becomes real), the step is halved. In a dissipative system with
// one degree of freedom det M < 1: neither NS nor a neutral saddle can occur.
#include <graze/continuation/conditions/multiplier_equations.hpp>
#include <graze/continuation/conditions/test_function.hpp>

#include <cmath>

namespace graze {

namespace {

struct Counts {
  int pairs = 0, outside = 0;  ///< complex pairs, and complex pairs outside the unit circle
  int above = 0, below = 0;    ///< real multipliers above 1, and below -1
};
Counts count(const TestPoint& point) {
  Counts counts{.above = real_beyond(point, 1), .below = real_beyond(point, -1)};
  for (const auto& mu : nontrivial(point.branch.multipliers)) {
    counts.pairs += mu.imag() > 0.0 ? 1 : 0;
    counts.outside += mu.imag() > 0.0 && std::abs(mu) > 1.0 ? 1 : 0;
  }
  return counts;
}

/// Whether only complex pairs may have crossed the circle.
bool same_reals(const Counts& a, const Counts& b) { return a.pairs == b.pairs && a.above == b.above && a.below == b.below; }

}  // namespace

TestFunction neimark_sacker_test() {
  TestFunction test;
  test.type = PointType::NS;
  test.summary = "Neimark-Sacker: a complex pair of multipliers passes the unit circle";
  test.value = [](const TestPoint& point) {
    const auto values = nontrivial(point.branch.multipliers);
    std::complex<double> product = 1.0;
    for (std::size_t i = 0; i < values.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) product *= (values[i] * values[j] - 1.0) / (1.0 + std::abs(values[i] * values[j]));
    return product.real();
  };
  test.confirm = [](const TestPoint& before, const TestPoint& after) {
    const Counts a = count(before), b = count(after);
    return same_reals(a, b) && a.outside != b.outside;
  };
  test.too_far_apart = [](const TestPoint& before, const TestPoint& after) { return !same_reals(count(before), count(after)); };
  test.distance = [](const BranchPoint& point) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& mu : nontrivial(point.multipliers))
      if (mu.imag() != 0.0) least = std::min(least, std::abs(std::abs(mu) - 1.0));
    return least;
  };
  test.equations = [](const TestPoint& near) {
    double theta = 0.0, closest = std::numeric_limits<double>::infinity();
    for (const auto& mu : nontrivial(near.branch.multipliers)) {
      if (mu.imag() > 0.0 && std::abs(std::log(std::abs(mu))) < closest) {
        closest = std::abs(std::log(std::abs(mu)));
        theta = std::arg(mu);
      }
    }
    return multiplier_equations({.theta = theta, .theta_free = true});
  };
  test.describe = [](BranchProblem&, const LocatedPoint& located, SpecialPoint& point) {
    point.details["angle"] = located.theta;
  };
  return test;
}

}  // namespace graze
