// SPDX-License-Identifier: GPL-3.0-or-later
// Motions near grazing in SIMD lanes: the same number of impacts as in the Propagator, for any position of the maximum of x.
#include "support/checks.hpp"
#include "support/lane_differences.hpp"

#include <graze/lib/models/oscillator.hpp>

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::support;

TEST_CASE("lanes miss no impact near grazing", "[sanitized]") {
  const char* law = GENERATE("newton", "hertz", "linear");
  const HybridSystem system = make_oscillator("linear", law);
  // The impactless orbit with its amplitude from just below the barrier to just above, and motions close to it.
  std::vector<Vector> sets;
  std::vector<MotionStart> starts;
  for (const double distance : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12})
    for (const double side : {-1.0, 1.0}) {
      Vector p = parameters(system, {{"eta", 0.65}});
      const Vector steady = steady_response(p);
      const double eta = p[oscillator_parameter::eta], b = p[oscillator_parameter::b], detuning = 1.0 - eta * eta;
      p[oscillator_parameter::r] = p[oscillator_parameter::xi] / std::hypot(detuning, 2.0 * b * eta) + side * distance;
      sets.push_back(p);
      for (int k = 0; k < 16; ++k) starts.push_back({sets.size() - 1, steady[0] + 1e-7 * k * k, steady[1] - 1e-9 * k});
    }
  check_near_grazing(system, sets, starts, 3);
}

TEST_CASE("lanes miss no impact between the points of their grid", "[sanitized]") {
  const char* law = GENERATE("newton", "hertz", "linear");
  // Weak damping above resonance: x has its maxima against the forcing, with the largest curvature possible at the barrier.
  // Transients beside it shift the maxima between the points of the grid, from below the barrier to above it.
  const HybridSystem system = make_oscillator("linear", law);
  std::vector<Vector> sets;
  std::vector<MotionStart> starts;
  for (const double eta : {1.3, 1.9})
    for (const double above : {-3e-2, -1e-2, -1e-4, 1e-9, 1e-4, 1e-2}) {
      Vector p = parameters(system, {{"eta", eta}, {"b", 1e-4}});
      const Vector steady = steady_response(p);
      p[oscillator_parameter::r] = p[oscillator_parameter::xi] / (eta * eta - 1.0) - above;
      sets.push_back(p);
      for (int k = -12; k <= 12; ++k) starts.push_back({sets.size() - 1, steady[0] + 2e-3 * k, steady[1] + 1e-3 * (k % 5)});
    }
  check_near_grazing(system, sets, starts, 4);
}
