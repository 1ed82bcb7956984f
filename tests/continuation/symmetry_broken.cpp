// SPDX-License-Identifier: GPL-3.0-or-later
// The symmetry-broken orbits between two elastic stops (xi = 1, r = 1, k_S = 25). All points lie within 1e-5 of eta, in the
// order of eta:
// 0.344351669588   BP: pitchfork of the symmetric branch, in which the broken branch is born and turns
// 0.344359338196   PD of the broken branch. A symmetric orbit cannot have a multiplier -1 (its monodromy matrix is the square
// of that of half a period), a broken one can
// 0.344360607273   GR: one of the four contacts is lost. The multiplier there is -2.212. It changes like the root of the
// distance, and therefore all three are so close together
// The reference is the closed-form motion of two_sided_motion.hpp.
#include <graze/continuation/graph/continuation.hpp>
#include <graze/floquet/attractor/settle.hpp>
#include <graze/floquet/orbit/mirror.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/two_sided_motion.hpp"
#include "support/two_sided_oscillator.hpp"

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

constexpr double pitchfork = 0.344351669588, doubling = 0.344359338196, grazing = 0.344360607273;

const HybridSystem& stops() {
  static const HybridSystem system = two_sided_oscillator(false);
  return system;
}

/// The stable broken orbit at eta = 0.412, or its mirror image, followed to `to`.
std::vector<Branch> followed(double eta, const Vector& start, const ContinuationOptions& options) {
  const Vector p = parameters(stops(), {{"eta", eta}});
  const PeriodicOrbit orbit = shoot(stops(), p, start, 1);
  REQUIRE(orbit.converged());
  return continue_orbit(stops(), orbit, options);
}

/// Distance from the mirror image: |x(T/2) + x(0)|.
double asymmetry(const PeriodicOrbit& orbit) {
  return (simulate(stops(), orbit.parameters, 0.0, orbit.state, {.t_end = forcing_period(stops(), orbit.parameters) / 2.0}).x +
          orbit.state)
      .norm();
}

TwoSidedMotion motion_at(double eta) {
  TwoSidedMotion motion;
  motion.eta = eta;
  return motion;
}

}  // namespace

TEST_CASE(
    "an independent motion confirms the multipliers at the period doubling of symmetry-broken orbits between elastic stops") {
  const std::vector<Branch> branches =
      followed(0.36, Vector{{0.8627518937, -0.0429097726}}, {.to = 0.344359, .switch_generations = 0});
  CHECK(check_branch(stops(), branches[0]) == std::vector<std::string>{});
  // Along the whole branch: trace and determinant by differences of the independent motion.
  for (const BranchPoint& point : branches[0].points) {
    const TwoSidedMotion motion = motion_at(point.value);
    const TwoSidedMotion::State z{point.state()[0], point.state()[1]}, end = motion.map(z);
    const TwoSidedMotion::Tangent M = motion.tangent(z);
    const std::complex<double> sum = point.multipliers.values[0] + point.multipliers.values[1];
    INFO("eta " << point.value << " multipliers " << point.multipliers.values[0] << point.multipliers.values[1]);
    CHECK(std::hypot(static_cast<double>(end[0] - z[0]), static_cast<double>(end[1] - z[1])) < 1e-11);
    // The derivative's modulus of continuity at a contact of speed v is 1e-8 / v; v is at least 1e-4 here.
    CHECK(std::abs(static_cast<double>(M.trace()) - sum.real()) < 1e-4);
    CHECK(std::abs(std::log(static_cast<double>(M.det())) + 0.1 * static_cast<double>(motion.period())) < 1e-6);
  }
  const auto doublings = points_of(branches[0], PointType::PD);
  REQUIRE(doublings.size() == 1);
  CHECK(doublings[0].status == PointStatus::converged);
  CHECK(std::abs(doublings[0].value - doubling) < 1e-12);  // known to twelve digits
  CHECK(asymmetry(doublings[0].orbit) > 1e-4);
  CHECK(types_of(branches[0]) == "GR PD");
  CHECK(std::abs(points_of(branches[0], PointType::GR)[0].value - grazing) < 1e-12);
  // 1 + trace + det passes zero there, with slope -5e5 per unit of eta; 6e-8 was measured at the point.
  const Vector& state = doublings[0].orbit.state;
  double sides[2];
  for (const int side : {0, 1}) {
    const TwoSidedMotion motion = motion_at(doublings[0].value + (side == 0 ? -1e-9 : 1e-9));
    long double error = 1.0L;
    const TwoSidedMotion::Tangent M = motion.tangent(motion.orbit({state[0], state[1]}, 1, error));
    CHECK(error < 1e-15L);
    sides[side] = static_cast<double>(1.0L + M.trace() + M.det());
  }
  REQUIRE(sides[0] > 0.0);
  REQUIRE(sides[1] < 0.0);
  CHECK(std::abs(1e-9 * (sides[0] + sides[1]) / (sides[0] - sides[1])) < 2e-12);  // an interpolation over 2e-9, curvature 1e-3
}

TEST_CASE("the doubled branch is found even if the parameter changes fast with the distance from its parent") {
  // In a range of 2.5e-4 all pushes above 1e-6 led the corrector to other orbits.
  const std::vector<Branch> before =
      followed(0.36, Vector{{0.8627518937, -0.0429097726}}, {.to = 0.3445, .switch_generations = 0});
  const std::vector<Branch> branches = followed(0.3445, before[0].points.back().state(), {.to = 0.344359, .from = 0.3446});
  REQUIRE(branches.size() == 2);
  CHECK(branches[1].parent->label == points_of(branches[0], PointType::PD)[0].label);
  REQUIRE(branches[1].stop == BranchStop::reached_bound);
  CHECK(text_detail(points_of(branches[0], PointType::PD)[0], "criticality") == "supercritical");
  CHECK(branches[1].points.front().stable);
  for (const Branch& branch : branches) CHECK(check_branch(stops(), branch) == std::vector<std::string>{});
  int apart = 0;
  for (const BranchPoint& point : branches[1].points) {
    CHECK(point.value > doubling);  // where its parent is unstable
    const TwoSidedMotion motion = motion_at(point.value);
    const TwoSidedMotion::State z{point.state()[0], point.state()[1]}, once = motion.map(z), twice = motion.map(z, 2);
    // It closes after two periods; the least stable multiplier, -79, amplifies the rounding of the state.
    CHECK(std::hypot(static_cast<double>(twice[0] - z[0]), static_cast<double>(twice[1] - z[1])) < 1e-11);
    apart += std::abs(once[0] - z[0]) > 1e-5L ? 1 : 0;
  }
  CHECK(apart > 20);
}

TEST_CASE("a pitchfork on the branch that turns in it is a branch point and no fold") {
  // The end of the branch is round in the norm of the arclength, with a radius of 1e-4 for a range of this width. Smaller
  // steps pass it and return along the mirror image. Larger ones may land on the symmetric branch, which continues in the
  // direction of the tip.
  ContinuationOptions options;
  options.to = 0.33;
  options.switch_generations = 0;
  options.trace.max_step = 5e-5;
  const std::vector<Branch> first =
      followed(0.36, Vector{{0.8627518937, -0.0429097726}}, {.to = 0.3444, .switch_generations = 0});
  options.from = 0.3444;
  const std::vector<Branch> branches = followed(0.3444, first[0].points.back().state(), options);
  CHECK(types_of(branches[0]) == "GR PD BP PD GR");
  const auto points = points_of(branches[0], PointType::BP);
  REQUIRE(points.size() == 1);
  CHECK(points[0].status == PointStatus::converged);
  CHECK(std::abs(points[0].value - pitchfork) < 1e-12);
  CHECK(asymmetry(points[0].orbit) < 1e-9);
  CHECK(branches[0].points.back().value == Approx(0.3444).epsilon(1e-14));
  CHECK(check_branch(stops(), branches[0]) == std::vector<std::string>{});
}

TEST_CASE("a special point is reported on its own branch even if another branch is closer than a step") {
  // The symmetric branch, from both sides of the pitchfork, with steps a hundred times longer than the structures beside it.
  // The tracer once switched to the broken branch and reported a BP in between.
  for (const double start : {0.36, 0.33}) {
    const Vector p = parameters(stops(), {{"eta", start}});
    const Vector guess = start == 0.36 ? Vector{{0.7395270387, -0.0073492821}} : settle(stops(), p, Vector::Zero(2)).state;
    const PeriodicOrbit orbit = shoot(stops(), p, guess, 1);
    REQUIRE(orbit.converged());
    REQUIRE(asymmetry(orbit) < 1e-10);
    const std::vector<Branch> branches =
        continue_orbit(stops(), orbit, {.to = start == 0.36 ? 0.33 : 0.36, .switch_generations = 0});
    INFO("from eta = " << start << ": " << types_of(branches[0]));
    const auto points = points_of(branches[0], PointType::BP);
    REQUIRE(points.size() == 1);
    CHECK(points[0].status == PointStatus::converged);
    CHECK(std::abs(points[0].value - pitchfork) < 1e-12);
    CHECK(points_of(branches[0], PointType::PD).empty());
    CHECK(branches[0].stop == BranchStop::reached_bound);
    CHECK(check_branch(stops(), branches[0]) == std::vector<std::string>{});
  }
}

TEST_CASE("the branch of broken symmetry is followed and its mirror image is counted once") {
  const Vector p = parameters(stops(), {{"eta", 0.33}});
  const PeriodicOrbit orbit = shoot(stops(), p, settle(stops(), p, Vector::Zero(2)).state, 1);
  REQUIRE(orbit.converged());
  const std::vector<Branch> branches = continue_orbit(stops(), orbit, {.to = 0.36, .switch_generations = 2, .max_multiple = 1});
  const auto crossings = points_of(branches[0], PointType::BP);
  REQUIRE(crossings.size() == 1);
  const std::vector<const Branch*> broken = born_at(crossings[0], branches);
  REQUIRE(broken.size() == 1);
  CHECK(broken[0]->mirrored);
  CHECK(!branches[0].mirrored);
  CHECK(check_branch(stops(), *broken[0]) == std::vector<std::string>{});
  // The points that were found on the way from above are found on it, 8e-6 and 9e-6 from its birth.
  REQUIRE(points_of(*broken[0], PointType::PD).size() == 1);
  CHECK(std::abs(points_of(*broken[0], PointType::PD)[0].value - doubling) < 1e-12);
  CHECK(std::abs(points_of(*broken[0], PointType::GR)[0].value - grazing) < 1e-12);
  CHECK(asymmetry(points_of(*broken[0], PointType::PD)[0].orbit) > 1e-4);
  // Each branch born on it has a mirror image too.
  int descendants = 0;
  for (const Branch& branch : branches) {
    if (!branch.parent || branch.parent->branch != broken[0]->id) continue;
    ++descendants;
    CHECK(branch.mirrored);
  }
  CHECK(descendants > 0);
}

TEST_CASE("with two rigid stops both halves of the pitchfork are attractors and one is listed") {
  const HybridSystem system = two_sided_oscillator(true);
  ContinuationOptions options;
  options.to = 0.3;
  const Vector p = parameters(system, {{"eta", 0.8}});
  const PeriodicOrbit orbit = shoot(system, p, settle(system, p, Vector{{0.0, 0.0}}).state, 1);
  REQUIRE(orbit.converged());
  std::size_t halves = 0, attracting = 0;
  for (const Branch& branch : continue_orbit(system, orbit, options)) {
    if (!branch.mirrored) continue;
    ++halves;
    for (const BranchPoint& point : branch.points) {
      if (!point.stable || std::abs(point.multipliers.values.front()) > 0.9) continue;
      Vector there = p;
      there[static_cast<Eigen::Index>(parameter_index(system.parameters, "eta"))] = point.value;
      const std::vector<Vector> image = mirror_image(system, there, *branch.mirrored, point.states);
      REQUIRE(image.size() == 1);
      CHECK((image[0] - point.state()).norm() > 1e-5);
      Vector beside = image[0];
      beside[1] += 1e-6;
      CHECK((settle(system, there, beside, {.periods = 400}).state - image[0]).norm() < 1e-9);
      ++attracting;
    }
  }
  CHECK(halves > 0);
  CHECK(attracting > 0);
}
