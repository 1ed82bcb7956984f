// SPDX-License-Identifier: GPL-3.0-or-later
// NS: a complex pair of multipliers crosses the unit circle. Test: the product of (mu_i mu_j - 1) over all pairs. It also passes
// zero where two real multipliers have product 1 (a neutral saddle, no bifurcation), and a complex pair outside the circle may
// become two real multipliers there: a point is one of NS where as many multipliers leave the circle as pairs do, or enter it,
// but for one real multiplier that crosses it within the same step (LP, PD). In a dissipative system with one degree of freedom
// det M < 1, so that neither can occur.
#include <graze/continuation/conditions/test_function.hpp>

#include <cmath>
#include <cstdlib>

namespace graze {

namespace {

struct Outside {
  int all = 0, pairs = 0;
  int complex = 0;  ///< pairs in all, inside too
};
Outside outside(const TestPoint& point) {
  Outside count;
  for (const auto& mu : nontrivial(point.branch.multipliers)) {
    count.complex += mu.imag() > 0.0 ? 1 : 0;
    if (!(std::abs(mu) > 1.0)) continue;
    ++count.all;
    count.pairs += mu.imag() > 0.0 ? 1 : 0;
  }
  return count;
}

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
    const Outside a = outside(before), b = outside(after);
    const int real = (b.all - a.all) - 2 * (b.pairs - a.pairs);  // that left the circle
    // Where pairs have become real ones, or the other way round, it cannot be told from that.
    return a.pairs != b.pairs && std::abs(real) <= (a.complex == b.complex ? 1 : 0);
  };
  test.distance = [](const BranchPoint& point) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& mu : nontrivial(point.multipliers))
      if (mu.imag() != 0.0) least = std::min(least, std::abs(std::abs(mu) - 1.0));
    return least;
  };
  test.locate = [](BranchProblem& problem, const Vector& u, const TestPoint& near) {
    double theta = 0.0, closest = std::numeric_limits<double>::infinity();
    for (const auto& mu : nontrivial(near.branch.multipliers)) {
      if (mu.imag() > 0.0 && std::abs(std::log(std::abs(mu))) < closest) {
        closest = std::abs(std::log(std::abs(mu)));
        theta = std::arg(mu);
      }
    }
    return locate_multiplier(problem, u, {.theta = theta, .theta_free = true});
  };
  test.describe = [](BranchProblem&, const LocatedPoint& located, SpecialPoint& point) {
    point.details["angle"] = located.theta;
  };
  return test;
}

}  // namespace graze
