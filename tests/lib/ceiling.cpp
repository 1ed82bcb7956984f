// SPDX-License-Identifier: GPL-3.0-or-later
// The ceiling of a flight in the lanes: while both ends of a grid cell lie below it, the lanes skip the search for an impact
// in the cell. It is checked against the closed form of the flight.
#include "support/checks.hpp"

#include <graze/lib/lanes/flight.hpp>
#include <graze/lib/lanes/oscillator.hpp>
#include <graze/lib/models/oscillator.hpp>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

using namespace graze;
using namespace graze::support;
using namespace graze::lanes;

namespace {

std::mt19937_64 engine(20261127);
double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }

/// A flight from (x, v) at forcing phase `phase`.
struct Flying {
  const Coefficients& q;
  double x, v, phase;

  double position(double t) const {
    const double s = q[frequency] * t + phase, C = q[cosine], S = q[sine], b = q[damping];
    const double d = x - (C * std::cos(phase) + S * std::sin(phase) + q[offset]),
                 e = v - q[frequency] * (S * std::cos(phase) - C * std::sin(phase)), turn = q[rate] * t;
    return C * std::cos(s) + S * std::sin(s) + q[offset] +
           std::exp(-b * t) * (d * std::cos(turn) + (e + b * d) / q[rate] * std::sin(turn));
  }
  double ceiling_of() const {
    const auto m = std::make_unique<Memory<double>>();
    for (std::size_t i = 0; i < coefficients; ++i) m->coefficient[i][0] = q[i];
    begin_flight<double, false>(*m, true, x, v, std::cos(phase), std::sin(phase));
    return (*m)[ceiling];
  }
};

/// Follows flights near the barrier up to the barrier. Returns the largest rise within a cell above its higher end, as a
/// fraction of the distance from ceiling to barrier.
double largest_need(const Coefficients& q) {
  double need = 0.0;
  const double r = q[barrier], h = q[cell];
  for (int start = 0; start < 400; ++start) {
    const Flying motion{q, r - std::pow(10.0, between(-3.0, 1.0)), std::pow(10.0, between(-2.0, 1.0)) * (start % 2 ? 1.0 : -1.0),
                        between(0.0, 6.28)};
    const double top = motion.ceiling_of();
    if (top >= r) FAIL("the ceiling is not below the barrier");
    for (double t = between(0.0, h); t < 20.0 * h; t += h) {
      const double higher_end = std::max(motion.position(t), motion.position(t + h));
      if (higher_end >= r) break;
      double highest = higher_end;
      for (int i = 1; i < 64; ++i) highest = std::max(highest, motion.position(t + h * i / 64.0));
      if (higher_end < top && highest >= r) FAIL("start " << start << " reaches the barrier");
      if (highest >= r) break;
      need = std::max(need, (highest - higher_end) / (r - top));
    }
  }
  return need;
}

}  // namespace

TEST_CASE("a flight below the ceiling at both ends of a cell stays below the barrier in between") {
  double need = 0.0;
  for (const char* law : {"newton", "linear"}) {
    const HybridSystem system = make_oscillator("linear", law);
    for (int draw = 0; draw < 150; ++draw) {
      const double b = draw % 3 == 0 ? between(0.0, 0.95) : between(0.0, 0.1), eta = between(0.1, 4.0), r = between(-2.0, 3.0);
      std::vector<std::pair<const char*, double>> values{{"b", b}, {"eta", eta}, {"r", r}};
      if (std::string(law) == "linear") values.emplace_back("k_S", between(0.1, 100.0));
      const std::optional<Oscillator> oscillator = lane_oscillator(system, parameters(system, values));
      REQUIRE(oscillator);
      INFO(law << ": b = " << b << ", eta = " << eta << ", r = " << r);
      need = std::max(need, largest_need(oscillator->coefficients));
      if (oscillator->law == Law::linear_elastic) need = std::max(need, largest_need(oscillator->pressed));
    }
  }
  CHECK(need < 1.0);
  CHECK(need > 0.9);  // the ceiling is sharp: one slightly closer to the barrier would fail
}
