// SPDX-License-Identifier: GPL-3.0-or-later
// A bar of mass 1 falls flat on two stops below its ends. The impulses at both commute only if its inertia is that of two
// masses at the ends.
#include <graze/lib/motion/order_of_events.hpp>

#include "support/checks.hpp"
#include "support/system_texts.hpp"

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

HybridSystem bar() {
  SystemWriter writer;
  writer.system.name = "bar";
  writer.parameter("J", "0.5").parameter("k_r", "0.5");
  writer.mechanics({"y", "phi"}, {"v", "w"}, {{{"1", "0"}, {"0", "J"}}});
  writer.stop("left", "y - phi", "newton", {"k_r"}).stop("right", "y + phi", "newton", {"k_r"});
  return equations::make_system(writer.system).system;
}

Trajectory fall(const HybridSystem& system, const Vector& p, double phi) {
  return simulate(system, p, 0.0, vector({1.0, phi, -1.0, 0.0}), {.t_end = 1.5});
}

}  // namespace

TEST_CASE("two stops that are hit together are reported if their order matters") {
  const HybridSystem system = bar();
  Vector p = default_parameters(system.parameters);
  const Trajectory run = fall(system, p, 0.0);
  const auto pairs = noncommuting_events(system, p, run.events);
  REQUIRE(pairs.size() == 1);
  CHECK(system.events[pairs[0].first].name == "left");
  CHECK(system.events[pairs[0].second].name == "right");
  CHECK(std::abs(pairs[0].t - 1.0) < 1e-12);
  // Impulses 1.5/3, 1.5 1.5/3 and 1.5/12 at the left, the right and the left stop; each gives v' = 1 and w' = -+2.
  CHECK((pairs[0].x_plus.tail(2) - vector({0.375, 0.25})).norm() < 1e-12);
  CHECK((pairs[0].x_plus_other.tail(2) - vector({0.375, -0.25})).norm() < 1e-12);
  CHECK((run.x.tail(2) - vector({0.375, 0.25})).norm() < 1e-12);
}

TEST_CASE("stops that are hit together in an irrelevant order or one after the other are not reported") {
  const HybridSystem system = bar();
  Vector p = default_parameters(system.parameters);
  CHECK(noncommuting_events(system, p, fall(system, p, 1e-3).events).empty());
  p[static_cast<Eigen::Index>(parameter_index(system.parameters, "J"))] = 1.0;
  const Trajectory run = fall(system, p, 0.0);
  REQUIRE(run.events.size() == 2);
  REQUIRE(run.events[0].t == run.events[1].t);
  CHECK(noncommuting_events(system, p, run.events).empty());
}
