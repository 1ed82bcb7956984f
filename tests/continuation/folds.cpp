// SPDX-License-Identifier: GPL-3.0-or-later
// Folds (LP) against closed forms: hard contacts with one impact in n periods. In the forcing amplitude xi, its square is a
// parabola in the impact speed v. In the clearance r, the family is an ellipse in (r, v), including r = 0 and r < 0. In the
// frequency eta, the two orbits of given parameters merge, also on closed branches. Soft contacts are compared with the
// multipliers of orbits on both sides and with the hard limit.
#include <graze/continuation/graph/continuation.hpp>
#include <graze/floquet/attractor/settle.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/damped_hertz.hpp"
#include "support/newton_oscillator.hpp"

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

/// The computed orbit at a closed-form one.
PeriodicOrbit orbit_at(const OneImpactOrbit& closed, int nodes = 0) {
  const Vector p = parameters_of(closed.parameters);
  return shoot(newton_oscillator(), p, closed.states().front(), closed.n, {.nodes = nodes});
}

/// Admissible with a margin, and with the impact away from phase 0, where a start would lie next to it.
bool clear(const OneImpactOrbit& closed) {
  const double phase = closed.time / closed.parameters.period();
  return closed.admissible() && closed.highest < -1e-3 && phase > 0.03 && phase < 0.97;
}

/// The fold of the two one-impact orbits, between an eta with two orbits and an eta with none.
double fold_in_eta(OneImpactParameters q, int n, double with, double without) {
  for (int i = 0; i < 60; ++i) {
    q.eta = 0.5 * (with + without);
    (one_impact_orbits(q, n).size() == 2 ? with : without) = q.eta;
  }
  return 0.5 * (with + without);
}

}  // namespace

TEST_CASE("folds in xi of orbits with one impact in n periods agree with the closed form for every k_r and r and n") {
  int traced = 0, negative = 0, restitutions = 0;
  for (const double k_r : {1.0, 0.9, 0.8, 0.6, 0.3}) {
    const int before = traced;
    for (const double r : {2.0, 1.0, 0.3, 0.0, -0.2, -0.7}) {
      for (const double eta : {0.63, 1.0, 1.31, 1.6, 1.83, 2.2, 2.85, 3.4, 4.6}) {
        for (int n = 1; n <= 4; ++n) {
          const OneImpactFamily family = one_impact_family({.b = 0.05, .eta = eta, .r = r, .k_r = k_r}, n);
          if (!(family.fold_speed() > 0.0)) continue;  // r = 0 has none: xi is proportional to v
          // From twice the impact speed at the fold through the fold and beyond, all of it admissible.
          const auto orbit_of = [&](double v) {
            OneImpactParameters q{.b = 0.05, .xi = family.xi(v), .eta = eta, .r = r, .k_r = k_r};
            for (const OneImpactOrbit& orbit : one_impact_orbits(q, n))
              if (std::abs(orbit.speed - v) < 1e-6 * v) return orbit;
            return OneImpactOrbit{};
          };
          bool whole = true;
          for (const double factor : {2.0, 1.6, 1.3, 1.1, 0.9, 0.7})
            whole = whole && clear(orbit_of(factor * family.fold_speed()));
          if (!whole) continue;
          const PeriodicOrbit orbit = orbit_at(orbit_of(2.0 * family.fold_speed()));
          INFO("k_r " << k_r << " r " << r << " eta " << eta << " n " << n << " fold at xi = " << family.xi_fold() << " speed "
                      << family.fold_speed());
          REQUIRE(orbit.converged());
          REQUIRE(orbit.impacts == 1);
          // The run ends after the fold, at 0.7 of its speed or where the orbit ceases to exist.
          const double start = orbit.parameters[static_cast<Eigen::Index>(parameter_index(newton_oscillator().parameters, "xi"))];
          ContinuationOptions options;
          options.parameter = "xi";
          options.to = 0.5 * family.xi_fold();
          options.from = start;
          options.switch_generations = 0;
          options.max_branches = 1;  // not the families behind its grazing
          const std::vector<Branch> branches = continue_orbit(newton_oscillator(), orbit, options);
          const auto folds = points_of(branches[0], PointType::LP);
          REQUIRE(folds.size() == 1);
          CHECK(folds[0].status == PointStatus::converged);
          CHECK(std::abs(folds[0].value - family.xi_fold()) < 1e-12 * (1.0 + family.xi_fold()));
          CHECK(std::abs(folds[0].value - family.xi_fold()) <= 2.0 * folds[0].precision);
          CHECK(points_of(branches[0], PointType::BP).empty());
          CHECK(check_branch(newton_oscillator(), branches[0]) == std::vector<std::string>{});
          ++traced;
          negative += r < 0.0 ? 1 : 0;
        }
      }
    }
    restitutions += traced > before ? 1 : 0;
  }
  CHECK(traced > 100);  // 115 when this was written, 19 of them with r < 0
  CHECK(negative > 15);
  CHECK(restitutions == 5);
}

TEST_CASE("the error bars of folds and period doublings cover the steps of the general integrator") {
  const OneImpactFamily family = one_impact_family({.b = 0.05, .eta = 1.31, .r = 0.3, .k_r = 0.8}, 1);
  const double start = family.xi(2.0 * family.fold_speed());
  constexpr double reference_doubling = 0.91954264308734801;  // data/reference.toml, quad precision
  const Vector settled = settle(damped_hertz(), hertz_parameters(), Vector::Zero(2)).state;
  for (const double tolerance : {1e-13, 1e-11, 1e-9, 1e-8}) {
    INFO("tolerance " << tolerance);
    ContinuationOptions options;
    options.shooting.flow = {.kind = FlowKind::general, .tolerance = tolerance};
    options.switch_generations = 0;
    OneImpactParameters q{.b = 0.05, .xi = start, .eta = 1.31, .r = 0.3, .k_r = 0.8};
    const Vector p = parameters_of(q);
    options.parameter = "xi";
    options.from = start;
    options.to = 0.5 * family.xi_fold();
    const PeriodicOrbit orbit =
        shoot(newton_oscillator(), p, one_impact_orbits(q, 1).front().states().front(), 1, options.shooting);
    REQUIRE(orbit.converged());
    const auto folds = points_of(continue_orbit(newton_oscillator(), orbit, options)[0], PointType::LP);
    REQUIRE(folds.size() == 1);
    const double fold_off = std::abs(folds[0].value - family.xi_fold());
    CHECK(fold_off < folds[0].precision);
    CHECK(folds[0].precision < 3.0 * fold_off + 1e-12);

    ContinuationOptions in_eta = options;
    in_eta.parameter = "eta";
    in_eta.from.reset();
    in_eta.to = 0.91;
    const PeriodicOrbit soft = shoot(damped_hertz(), hertz_parameters(), settled, 1, options.shooting);
    REQUIRE(soft.converged());
    const auto doublings = points_of(continue_orbit(damped_hertz(), soft, in_eta)[0], PointType::PD);
    REQUIRE(doublings.size() == 1);
    const double doubling_off = std::abs(doublings[0].value - reference_doubling);
    CHECK(doubling_off < doublings[0].precision);
    CHECK(doublings[0].precision < 3.0 * doubling_off + 1e-12);
  }
}

TEST_CASE("folds in the clearance agree with the closed form from r = 0 to either sign of r") {
  // (r - alpha v)^2 + slope^2 v^2 = amplitude^2: an ellipse. Its largest |r|, with the sign of alpha, is amplitude
  // hypot(alpha, slope) / |slope|, at v = r alpha / (alpha^2 + slope^2).
  int traced[2] = {0, 0};
  for (const double k_r : {0.9, 0.8, 0.6, 0.3}) {
    for (const double eta : {0.63, 1.31, 1.6, 2.2, 2.6, 3.1, 4.2, 5.2}) {
      for (int n = 1; n <= 3; ++n) {
        const OneImpactParameters q{.b = 0.05, .xi = 1.0, .eta = eta, .r = 0.0, .k_r = k_r};
        const OneImpactFamily family = one_impact_family(q, n);
        const double size = std::hypot(family.alpha, family.slope);
        const double exact = std::copysign(impactless_amplitude(q) * size / std::abs(family.slope), family.alpha);
        const auto start = one_impact_orbits(q, n);
        bool whole = start.size() == 1 && clear(start[0]) && std::abs(exact) < 20.0;
        for (const double part : {0.3, 0.6, 0.9, 0.99, 0.999, 1.0 - 1e-9}) {
          if (!whole) break;
          OneImpactParameters on_the_way = q;
          on_the_way.r = part * exact;
          const auto orbits = one_impact_orbits(on_the_way, n);
          whole = !orbits.empty() && clear(orbits[0]);  // the faster one leads to the fold
        }
        if (!whole) continue;
        INFO("k_r " << k_r << " eta " << eta << " n " << n << " fold at r = " << exact);
        const PeriodicOrbit orbit = orbit_at(start[0]);
        REQUIRE(orbit.converged());
        ContinuationOptions options;
        options.parameter = "r";
        options.to = 1.1 * exact;
        options.from = 0.98 * exact;
        options.switch_generations = 0;
        options.max_branches = 1;
        const std::vector<Branch> branches = continue_orbit(newton_oscillator(), orbit, options);
        const auto folds = points_of(branches[0], PointType::LP);
        REQUIRE(folds.size() == 1);
        CHECK(folds[0].status == PointStatus::converged);
        CHECK(std::abs(folds[0].value - exact) < 1e-12 * (1.0 + std::abs(exact)));
        CHECK(check_branch(newton_oscillator(), branches[0]) == std::vector<std::string>{});
        ++traced[exact < 0.0 ? 0 : 1];
      }
    }
  }
  CHECK(traced[0] > 20);  // 26 at r < 0 and 6 at r > 0 when this was written
  CHECK(traced[1] > 4);
}

TEST_CASE("closed branches in eta are followed exactly one turn for any section") {
  struct Closed {
    OneImpactParameters q;  ///< eta somewhere between the folds
    int n;
    double low, high;  ///< beyond the folds
  };
  const std::vector<Closed> list = {
      {{.b = 0.02, .xi = 1.0, .eta = 2.7, .r = 2.0, .k_r = 1.0}, 2, 1.9, 3.6},
      {{.b = 0.02, .xi = 1.0, .eta = 4.0, .r = 2.0, .k_r = 1.0}, 3, 3.2, 4.8},
      {{.b = 0.02, .xi = 1.0, .eta = 5.5, .r = 1.0, .k_r = 1.0}, 4, 4.1, 7.0},
      {{.b = 0.05, .xi = 1.0, .eta = 6.6, .r = 0.5, .k_r = 1.0}, 5, 5.9, 7.4},
      {{.b = 0.02, .xi = 1.0, .eta = 2.6, .r = 2.0, .k_r = 0.95}, 2, 2.05, 3.3},
      {{.b = 0.02, .xi = 1.0, .eta = 3.7, .r = 1.0, .k_r = 0.8}, 3, 3.1, 4.4},
      {{.b = 0.005, .xi = 1.0, .eta = 4.6, .r = 2.0, .k_r = 0.8}, 4, 4.1, 5.1},
  };
  for (const Closed& isola : list) {
    const double low = fold_in_eta(isola.q, isola.n, isola.q.eta, isola.low);
    const double high = fold_in_eta(isola.q, isola.n, isola.q.eta, isola.high);
    const auto orbits = one_impact_orbits(isola.q, isola.n);
    REQUIRE(orbits.size() == 2);
    // Nodes at other phases: if a forcing period has several nodes, the impact passes one of them and the section moves.
    for (const int nodes : {isola.n, 2 * isola.n, 3 * isola.n, 4 * isola.n}) {
      for (const OneImpactOrbit& start : orbits) {
        INFO("r " << isola.q.r << " n " << isola.n << " nodes " << nodes << " speed " << start.speed);
        const PeriodicOrbit orbit = orbit_at(start, nodes);
        REQUIRE(orbit.converged());
        ContinuationOptions options;
        options.to = isola.high;
        options.from = isola.low;
        options.switch_generations = 0;
        options.trace.max_points = 1000;
        const std::vector<Branch> branches = continue_orbit(newton_oscillator(), orbit, options);
        CHECK(branches[0].stop == BranchStop::returned);
        CHECK(branches[0].points.size() < 400);
        const auto folds = points_of(branches[0], PointType::LP);
        CHECK(folds.size() == 2);
        for (const SpecialPoint& fold : folds) {
          CHECK(fold.status == PointStatus::converged);
          CHECK(std::abs(fold.value - (fold.value > isola.q.eta ? high : low)) < 1e-12);
        }
        CHECK((branches[0].points.back().state() - branches[0].points.front().state()).norm() < 1e-8);
        CHECK(check_branch(newton_oscillator(), branches[0]) == std::vector<std::string>{});
      }
    }
  }
}

TEST_CASE("a user value near a fold is met on both sides of it in the order of the branch") {
  // Newton's law, k_r = 0.8, r = 0.3, eta = 1.31: fold at xi = 0.05; the values lie within one step of it.
  const OneImpactFamily family = one_impact_family({.b = 0.05, .eta = 1.31, .r = 0.3, .k_r = 0.8}, 1);
  OneImpactParameters q{.b = 0.05, .xi = family.xi(1.7 * family.fold_speed()), .eta = 1.31, .r = 0.3, .k_r = 0.8};
  const PeriodicOrbit orbit = orbit_at(one_impact_orbits(q, 1).front());
  REQUIRE(orbit.converged());
  ContinuationOptions options;
  options.parameter = "xi";
  options.to = 0.5 * family.xi_fold();
  options.from = q.xi;
  options.switch_generations = 0;
  const double near = family.xi_fold() * (1.0 + 1e-5), far = family.xi_fold() * (1.0 + 1e-4);
  options.user_values = {near, far};
  const std::vector<Branch> branches = continue_orbit(newton_oscillator(), orbit, options);
  CHECK(types_of(branches[0]) == "UZ UZ LP UZ UZ");
  const auto points = points_of(branches[0], PointType::UZ);
  REQUIRE(points.size() == 4);
  CHECK(points[0].value == far);
  CHECK(points[1].value == near);
  CHECK(points[2].value == near);
  CHECK(points[3].value == far);
  // On each side the speed of the impact is that of the closed form.
  for (const std::size_t k : {0u, 1u, 2u, 3u}) {
    q.xi = points[k].value;
    const auto closed = one_impact_orbits(q, 1);
    REQUIRE(closed.size() == 2);
    CHECK(std::abs(points[k].orbit.events.at(0).normal_speed - closed[k < 2 ? 0 : 1].speed) <
          1e-9);  // 1e-12 over the root of 1e-5
  }
}
