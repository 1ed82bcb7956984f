// SPDX-License-Identifier: GPL-3.0-or-later
// Regular motion is not classified as chaos. Standard errors account for a trend. In a conservative system the growth of
// tangents distinguishes islands from the chaotic sea.
#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/basins/basins.hpp>
#include <graze/floquet/exponents/exponents.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/numerics/batch_means.hpp>

#include "support/checks.hpp"
#include "support/newton_oscillator.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <random>

using namespace graze;
using namespace graze::support;

namespace {

Vector conservative() {
  return parameters(newton_oscillator(), {{"k_r", 1.0}, {"b", 0.0}, {"xi", 1.0}, {"eta", 2.8}, {"r", -0.1}});
}

}  // namespace

TEST_CASE("the standard error accounts for a trend: ln N / N is not significantly positive") {
  for (const int periods : {500, 2000, 20000}) {
    INFO("periods " << periods);
    BatchMeans means;
    for (int k = 1; k <= periods; ++k) means.add(std::log1p(1.0 / k));
    const double error = means.standard_error() / std::sqrt(16.0);  // as for 16 equal motions side by side
    CHECK(means.mean() > 5.0 * error);                              // five standard errors would count as chaos
    CHECK(means.mean() < 3.0 * with_trend(error, means.drift()));
  }
}

TEST_CASE("a series without a trend keeps the standard error of its batch means") {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.3, 1.0);
  int larger = 0;
  constexpr int series = 200;
  for (int i = 0; i < series; ++i) {
    BatchMeans means;
    for (int k = 0; k < 3000; ++k) means.add(normal(random));
    if (with_trend(means.standard_error(), means.drift()) != means.standard_error()) ++larger;
  }
  CHECK(larger <= 1);  // one in 16000 by chance
}

TEST_CASE("an island is not chaotic by 15 standard errors and no attractor is claimed") {
  AttractorOptions options;
  options.transient = 100;
  options.lyapunov.max_periods = 40000;
  const Attractor found = find_attractor(newton_oscillator(), conservative(), Vector{{-0.68771149, 0.365807336}}, options);
  CHECK(found.type == AttractorType::undecided);
  CHECK(found.conservative);
  CHECK(found.motion == ConservativeMotion::island);
}

TEST_CASE("islands and the chaotic sea are classified as by an alignment index") {
  // The smaller alignment index of two tangent vectors over 6000 periods, from a separate program in 80-bit arithmetic.
  struct Start {
    double x, v;
    ConservativeMotion motion;
  };
  const std::vector<Start> starts = {
      {-0.788726414, -0.883460488, ConservativeMotion::island},
      {-0.546910673, -0.474599866, ConservativeMotion::island},
      {-0.211278593, -0.737475967, ConservativeMotion::island},
      {-0.472262189, -0.802460286, ConservativeMotion::island},
      {-0.170191024, 0.896660143, ConservativeMotion::island},
      {-1.440871046, 0.358359490, ConservativeMotion::island},
      {-0.341540801, -0.828202603, ConservativeMotion::island},
      {-1.278685348, -1.024035780, ConservativeMotion::island},
      {-1.277286968, 0.027840964, ConservativeMotion::chaotic_sea},
      {-1.111651383, 0.083943713, ConservativeMotion::chaotic_sea},
      {-1.127481373, -0.167075048, ConservativeMotion::chaotic_sea},
      {-0.588154743, -0.226871011, ConservativeMotion::chaotic_sea},
  };
  AttractorOptions options;
  options.transient = 0;
  options.lyapunov.max_periods = 40000;
  for (const Start& start : starts) {
    INFO("start " << start.x << ", " << start.v);
    const Attractor found = find_attractor(newton_oscillator(), conservative(), Vector{{start.x, start.v}}, options);
    CHECK(found.conservative);
    CHECK(found.motion == start.motion);
    CHECK((found.type == AttractorType::chaotic) == (start.motion == ConservativeMotion::chaotic_sea));
  }
}

TEST_CASE("at twice the natural period each motion without impact is an orbit and that through the start is found (fixed)") {
  // x = 4/3 cos(t/2) + A cos t + B sin t: period 4 pi for every A and B. The singular Jacobian of shooting must not move them.
  const Vector p = parameters(newton_oscillator(), {{"k_r", 0.5}, {"b", 0.0}, {"xi", 1.0}, {"eta", 0.5}, {"r", 2.0}});
  for (const double recurrence : {0.0, 1e-4}) {
    INFO("recurrence " << recurrence);
    AttractorOptions options;
    options.recurrence = recurrence;
    options.lyapunov.max_periods = 3000;
    for (const Vector& start : {Vector{{0.0, 0.0}}, Vector{{1.0, 0.25}}}) {
      const Attractor found = find_attractor(newton_oscillator(), p, start, options);
      CHECK(found.type == AttractorType::periodic);
      CHECK(found.motion == ConservativeMotion::neutral);
      CHECK(found.period == 1);
      CHECK((found.state - start).norm() < 1e-10);
    }
  }
  BasinOptions options;
  const Basins basins = find_attractors(newton_oscillator(), p, Matrix{{0.0, 0.5, 1.0}, {0.0, 0.1, 0.2}}, options);
  CHECK(basins.attractors.size() == 1);
  CHECK(basins.lost == 0);
}
