// SPDX-License-Identifier: GPL-3.0-or-later
// Comparison of two rows at one value: orbits and chaos from different starts, coexisting attractors, neighbours.
#include <graze/floquet/follow/same_attractor.hpp>

#include "support/damped_hertz.hpp"

#include <catch2/catch.hpp>

#include <algorithm>

using namespace graze;
using namespace graze::support;

namespace {

/// The first row of a sweep from this start.
SweepRow row_from(double eta, const Vector& start, int samples = 200) {
  SweepOptions options;
  options.from = eta;
  options.to = eta + 1e-6;
  options.step = 1.0;
  options.samples = samples;
  options.attractor.periods_on_orbit = 0;
  options.attractor.lyapunov.standard_error = 2e-3;
  const std::vector<SweepRow> rows = sweep(damped_hertz(), hertz_parameters(), start, options);
  REQUIRE(rows.size() == 1);
  return rows.front();
}

const Vector at_rest{{0.0, 0.0}}, other_start{{-0.7, 0.4}};

}  // namespace

TEST_CASE("same attractor: an orbit is the same from any start and for any order of its states") {
  const SweepRow one = row_from(0.918, at_rest);
  REQUIRE(one.attractor.period == 2);
  SweepRow turned = row_from(0.918, other_start);
  CHECK(on_same_attractor(one, turned));
  std::swap(turned.states[0], turned.states[1]);
  CHECK(on_same_attractor(one, turned));
  CHECK_FALSE(on_same_attractor(one, row_from(0.918001, at_rest)));
  CHECK_FALSE(on_same_attractor(one, row_from(0.93, at_rest)));  // another period
}

TEST_CASE("same attractor: chaos is the same from any start and different at another value") {
  const SweepRow one = row_from(0.711, at_rest);
  REQUIRE(one.attractor.type == AttractorType::chaotic);
  CHECK(on_same_attractor(one, row_from(0.711, other_start)));
  CHECK(on_same_attractor(one, row_from(0.711, Vector{{0.9, -0.2}})));
  CHECK_FALSE(on_same_attractor(one, row_from(0.735, at_rest)));
  // The exponents differ; where they do not, the states do.
  SweepRow moved = row_from(0.711, other_start);
  for (Vector& state : moved.states) state[0] += 0.3;
  CHECK_FALSE(on_same_attractor(one, moved));
  SweepRow part = row_from(0.711, other_start);
  const auto [left, right] =
      std::minmax_element(part.states.begin(), part.states.end(), [](const Vector& a, const Vector& b) { return a[0] < b[0]; });
  const double middle = 0.5 * ((*left)[0] + (*right)[0]);
  std::erase_if(part.states, [&](const Vector& state) { return state[0] > middle; });
  REQUIRE(part.states.size() > 50);
  REQUIRE(part.states.size() < 150);
  CHECK_FALSE(on_same_attractor(one, part));
  CHECK_FALSE(on_same_attractor(one, row_from(0.711, other_start, 16)));  // too few states to decide
}

TEST_CASE("same attractor: an orbit differs from the chaos beside it and an undecided row is unknown") {
  SweepRow chaos = row_from(0.7022, at_rest);
  REQUIRE(chaos.attractor.type == AttractorType::chaotic);
  SweepRow undecided = chaos;
  undecided.attractor.type = AttractorType::undecided;
  CHECK_FALSE(on_same_attractor(undecided, undecided));
  CHECK(on_same_attractor(chaos, chaos));
}
