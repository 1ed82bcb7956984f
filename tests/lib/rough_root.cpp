// SPDX-License-Identifier: GPL-3.0-or-later
// The approximate root from which the lanes choose their step lengths, against the exact root.
#include <graze/lib/lanes/rough_root.hpp>

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

using namespace graze::lanes;

TEST_CASE("the approximate root of a ratio has an error below 4 per cent") {
  for (const double x : {2.5e-14, 1e-10, 1.0})
    for (double y = 1e-290; y < 1e290; y *= 1.37) {
      REQUIRE(std::abs(rough_root<20>(x, y) / std::pow(x / y, 1.0 / 20.0) - 1.0) < 0.04);
      REQUIRE(std::abs(rough_root<15>(x, y) / std::pow(x / y, 1.0 / 15.0) - 1.0) < 0.04);
    }
}

TEST_CASE("the approximate root is a positive number for any value of the series") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const double y : {0.0, std::numeric_limits<double>::denorm_min(), 1e308, infinity, std::nan("")}) {
    CHECK(rough_root<16>(1e-13, y) > 0.0);
    CHECK(std::isfinite(rough_root<16>(1e-13, y)));
  }
}

TEST_CASE("the approximate root has identical bits in a register") {
  using Register = xsimd::batch<double, xsimd::sse2>;
  for (double y = 1e-30; y < 1e10; y *= 3.1) {
    alignas(16) double both[2] = {y, 0.1 * y};
    put(both, rough_root<20>(2.5e-14, take<Register>(both)));
    CHECK(both[0] == rough_root<20>(2.5e-14, y));
    CHECK(both[1] == rough_root<20>(2.5e-14, 0.1 * y));
  }
}
