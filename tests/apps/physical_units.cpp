// SPDX-License-Identifier: GPL-3.0-or-later
// Conversions against values worked out by hand, with numbers that leave short decimals.
#include <graze/lib/models/physical_units.hpp>

#include <catch2/catch.hpp>

#include <cmath>
#include <stdexcept>

using namespace graze;
using Catch::Matchers::Contains;

namespace {

/// A few roundings.
Approx exactly(double value) { return Approx(value).epsilon(1e-14).margin(0.0); }

}  // namespace

TEST_CASE("kinematic excitation is converted") {
  // K = 30 + 70 = 100 N/m, alpha = sqrt(100/4) = 5 rad/s, x = X / 0.04 m.
  const Dimensionless d = to_dimensionless(
      KinematicExcitation{.m = 4.0, .k = 30.0, .k_e = 70.0, .c = 2.0, .a = 0.04, .omega = 4.75, .rho = 0.08, .k_3 = 5000.0},
      {.k_h = 50000.0, .b_h = 0.5, .k_s = 2500.0});
  CHECK(d.alpha == exactly(5.0));
  CHECK(d.length == exactly(0.04));
  CHECK(d.xi == exactly(0.7));
  CHECK(d.b == exactly(0.05));     // 2 / (2 sqrt(400))
  CHECK(d.eta == exactly(0.95));   // 4.75 / 5
  CHECK(d.r == exactly(2.0));      // 0.08 / 0.04
  CHECK(d.k_H == exactly(100.0));  // 50000 * 0.2 / 100
  CHECK(d.b_H == exactly(0.1));    // 0.5 * 0.04 * 5
  CHECK(d.k_S == exactly(25.0));   // 2500 / 100
  CHECK(d.beta == exactly(0.08));  // 5000 * 0.0016 / 100
}

TEST_CASE("force excitation is converted") {
  // alpha = sqrt(100/4) = 5 rad/s, x_st = 4/100 = 0.04 m.
  const Dimensionless d =
      to_dimensionless(ForceExcitation{.m = 4.0, .k = 100.0, .c = 2.0, .F0 = 4.0, .omega = 4.75, .rho = 0.08, .k_3 = 0.0},
                       {.k_h = 50000.0, .b_h = 0.5, .k_s = 2500.0});
  CHECK(d.alpha == exactly(5.0));
  CHECK(d.length == exactly(0.04));
  CHECK(d.xi == 1.0);
  CHECK(d.b == exactly(0.05));
  CHECK(d.eta == exactly(0.95));
  CHECK(d.r == exactly(2.0));
  CHECK(d.k_H == exactly(100.0));
  CHECK(d.b_H == exactly(0.1));
  CHECK(d.k_S == exactly(25.0));
  CHECK(d.beta == 0.0);
}

TEST_CASE("beam excitation is converted") {
  // k_1 = 12 * 0.0675 / 0.027 = 30 N/m, alpha = sqrt(30/1.2) = 5 rad/s, x = X / 0.3 m.
  const Dimensionless d =
      to_dimensionless(BeamExcitation{.M = 1.2, .L = 0.3, .EI = 0.0675, .c = 0.312, .F0 = 0.72, .omega = 2.77, .rho = 0.0237},
                       {.k_h = 0.0, .b_h = 0.2, .k_s = 750.0});
  CHECK(d.alpha == exactly(5.0));
  CHECK(d.length == exactly(0.3));
  CHECK(d.stiffness == exactly(30.0));
  CHECK(d.b == exactly(0.026));  // 0.312 / (2 sqrt(36))
  CHECK(d.xi == exactly(0.08));  // 0.72 / (25 * 1.2 * 0.3)
  CHECK(d.eta == exactly(0.554));
  CHECK(d.r == exactly(0.079));
  CHECK(d.beta == exactly(36.0 / 35.0));
  CHECK(d.b_H == exactly(0.3));  // 0.2 * 0.3 * 5
  CHECK(d.k_S == exactly(25.0));
}

TEST_CASE("Hertz stiffness of a beam scales with the root of its length") {
  // ell = 0.25 m, k_1 = 12 * 0.01 / 0.015625 = 7.68 N/m: k_H = 1536 * 0.5 / 7.68 = 100.
  const Dimensionless d = to_dimensionless(
      BeamExcitation{.M = 1.0, .L = 0.25, .EI = 0.01, .c = 0.0, .F0 = 1.0, .omega = 1.0, .rho = 0.1}, {.k_h = 1536.0});
  CHECK(d.k_H == exactly(100.0));
}

TEST_CASE("conversion by names gives the same as by structs") {
  for (const ExcitationKind& kind : excitation_kinds()) {
    INFO(kind.name);
    std::map<std::string, double> quantities = {{"k_h", 3.0}, {"b_h", 0.2}, {"k_s", 7.0}};
    double value = 1.5;
    for (const ParameterInfo& info : kind.quantities) quantities[info.name] = value += 0.25;
    const Dimensionless d = kind.convert(quantities);
    for (const char* name : {"b", "beta", "xi", "eta", "r", "k_H", "b_H", "k_S"}) {
      REQUIRE(find_value(d, name));
      CHECK(*find_value(d, name) > 0.0);
    }
  }
  CHECK(find_value(Dimensionless{}, "k_r") == nullptr);
  const Dimensionless direct =
      to_dimensionless(ForceExcitation{.m = 1.0, .k = 2.0, .c = 0.3, .F0 = 4.0, .omega = 5.0, .rho = 6.0, .k_3 = 7.0});
  const Dimensionless named = excitation_kind("force").convert(
      {{"m", 1.0}, {"k", 2.0}, {"c", 0.3}, {"F0", 4.0}, {"omega", 5.0}, {"rho", 6.0}, {"k_3", 7.0}});
  for (const char* name : {"b", "beta", "xi", "eta", "r"}) CHECK(*find_value(named, name) == *find_value(direct, name));
}

TEST_CASE("an unknown excitation is refused with the nearest name") {
  CHECK_THROWS_WITH(excitation_kind("kinematik"), Contains("kinematic"));
}
