// SPDX-License-Identifier: GPL-3.0-or-later
// Stiff linear stops: a branch at the grazing of the impactless orbit as k_S grows. At a nonsmooth fold of the hard contact
// the branch has a corner of size k_S^-2: below the rounding of doubles from k_S = 1e7 on.
#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

/// From the impactless orbit just before its grazing, with r = 1, b = 0.05, in xi.
std::vector<Branch> through_grazing(const HybridSystem& system, double eta, const char* constant, double value) {
  const double b = 0.05, stiff = 1.0 - eta * eta, drag = 2.0 * b * eta, grazing = std::hypot(stiff, drag), xi = 0.97 * grazing;
  const Vector p = parameters(system, {{"b", b}, {"xi", xi}, {"eta", eta}, {"r", 1.0}, {constant, value}});
  const PeriodicOrbit orbit = shoot(system, p, xi / (grazing * grazing) * Vector{{stiff, drag * eta}}, 1);
  REQUIRE(orbit.converged());
  ContinuationOptions options;
  options.parameter = "xi";
  options.from = 0.9 * grazing;
  options.to = 1.1 * grazing;
  options.switch_generations = 0;
  return follow_branches(system, {{orbit, {1}}}, options).branches;
}

}  // namespace

TEST_CASE("a branch passes the grazing of an arbitrarily stiff stop and tends to the orbits of the rigid one") {
  const HybridSystem elastic = make_oscillator("linear", "linear"), rigid = make_oscillator("linear", "newton");
  // Nonsmooth folds at 0.55, 1.15 and 1.7 (where the sine of the free oscillation over a forcing period is negative),
  // persistence at 0.8 and 2.2. At 0.42 and 0.55 the contact passes phase 0 on the way.
  for (const double eta : {0.42, 0.55, 0.8, 1.15, 1.7, 2.2}) {
    const std::vector<Branch> hard = through_grazing(rigid, eta, "k_r", 1.0);
    REQUIRE(hard.size() == 2);
    REQUIRE(hard[1].stop == BranchStop::reached_bound);
    const BranchPoint& limit = hard[1].points.back();
    const double grazing = points_of(hard[0], PointType::GR).at(0).value;
    const bool fold = text_detail(points_of(hard[0], PointType::GR).at(0), "scenario") == "nonsmooth-fold";
    double last = 0.0;
    for (const double k : {1e4, 1e5, 1e6, 1e7}) {
      INFO("eta " << eta << " k_S " << k);
      const std::vector<Branch> soft = through_grazing(elastic, eta, "k_S", k);
      REQUIRE(soft.size() == 1);
      CHECK(check_branch(elastic, soft[0]) == std::vector<std::string>{});
      REQUIRE(soft[0].stop == BranchStop::reached_bound);
      const auto grazings = points_of(soft[0], PointType::GR);
      REQUIRE(grazings.size() == 1);
      CHECK(std::abs(grazings[0].value - grazing) < 1e-12);
      CHECK(text_detail(grazings[0], "kind") == "gained");
      // The tip of the corner is a fold next to the grazing, or there is none.
      const auto folds = points_of(soft[0], PointType::LP);
      REQUIRE(folds.size() == (fold ? 1 : 0));
      if (fold) CHECK(std::abs(folds[0].value - grazing) < 1e-2 / k);
      // A contact lasts pi / sqrt(k): the orbits differ by that, and by a tenth of it if k is a hundred times larger.
      const BranchPoint& end = soft[0].points.back();
      REQUIRE(end.value == Approx(limit.value).epsilon(1e-13));
      CHECK(end.impacts == 1);
      const double distance = (end.state() - limit.state()).norm();
      CHECK(distance < 40.0 / std::sqrt(k));
      if (last > 0.0) CHECK(last / distance == Approx(std::sqrt(10.0)).epsilon(0.25));
      last = distance;
    }
  }
}
