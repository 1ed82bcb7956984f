// SPDX-License-Identifier: GPL-3.0-or-later
// The Taylor series of the oscillator with a cubic spring: against an independent integration in long double, its order, its
// tolerance, and its events at and near the barrier.
#include "support/checks.hpp"
#include "support/extrapolation.hpp"

#include <graze/lib/flow/cubic_series.hpp>
#include <graze/lib/flow/flow.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/trajectory.hpp>

using namespace graze;
using namespace graze::support;

namespace {

using Number = long double;
enum : Eigen::Index { b, beta, xi, eta, r, k_S };

/// Equations of motion and of the tangent, in the order x, v, dx/dx0, dv/dx0, dx/dv0, dv/dv0. In contact the stop is included.
auto motion_of(const Vector& p, bool contact) {
  return [p, contact](Number t, const LongState<6>& z, LongState<6>& dz) {
    const Number k = contact ? 1 + Number(p[k_S]) : Number(1), x = z[0];
    const auto force = [&](Number moved) { return -k * moved; };
    dz[0] = z[1];
    dz[1] = Number(p[xi]) * std::cos(Number(p[eta]) * t) - 2 * Number(p[b]) * z[1] + force(x) - Number(p[beta]) * x * x * x;
    if (contact) dz[1] += Number(p[k_S]) * Number(p[r]);
    for (std::size_t column = 2; column < 6; column += 2) {
      dz[column] = z[column + 1];
      dz[column + 1] = force(z[column]) - 3 * Number(p[beta]) * x * x * z[column] - 2 * Number(p[b]) * z[column + 1];
    }
  };
}

Segment carry_one(const HybridSystem& system, std::size_t mode, const Vector& p, const FlowTask& task, const Vector& x0,
                  const FlowOptions& options = {}) {
  Flow flow = make_flow(system, mode, p, all_parameters(system), options);
  Segment segment;
  flow.carry(task, x0, segment);
  return segment;
}

}  // namespace

TEST_CASE("the series gives motion and tangent for any stiffness and damping in flight and in contact") {
  const HybridSystem system = make_oscillator("cantilever", "linear");
  Random random(17);
  for (const double damping : {0.0, 0.026, 1.0, 2.5}) {
    for (const bool contact : {false, true}) {
      for (int i = 0; i < 4; ++i) {
        const Vector p = parameters(system, {{"b", damping},
                                             {"beta", i == 0 ? -0.1 : random(0.2, 3.0)},
                                             {"xi", random(0.05, 1.0)},
                                             {"eta", random(0.3, 2.0)},
                                             {"r", contact ? -50.0 : 50.0},
                                             {"k_S", 0.5}});
        const double t0 = random(-3.0, 10.0), t1 = t0 + random(0.1, 8.0);
        const Vector x0 = vector({random(-0.8, 0.8), random(-0.8, 0.8)});
        // The guards are off. At r = -50 the stop pushes with a constant force of 25, and a softening spring would escape.
        if (contact && i == 0) continue;
        const Segment one = carry_one(system, contact, p, {t0, t1, Sensitivity::state, false}, x0);
        const LongState<6> exact = extrapolate<6>(motion_of(p, contact), t0, t1, {x0[0], x0[1], 1, 0, 0, 1});
        REQUIRE(one.end == FlowEnd::time);
        REQUIRE(one.t1 == t1);
        const double found[] = {one.x1[0], one.x1[1], one.Phi(0, 0), one.Phi(1, 0), one.Phi(0, 1), one.Phi(1, 1)};
        INFO("b = " << damping << (contact ? " in contact" : " in flight") << ", run " << i);
        double size = 1.0;
        for (const Number z : exact) size = std::max(size, static_cast<double>(std::abs(z)));
        // Some tens of steps, each within a twentieth of the tolerance 1e-13, amplified by the motion.
        for (std::size_t k = 0; k < 6; ++k) CHECK(static_cast<double>(std::abs(found[k] - exact[k])) < 1e-12 * size);
        CHECK(one.divergence == Approx(-2.0 * damping * (t1 - t0)).epsilon(1e-15));
      }
    }
  }
}

TEST_CASE("the series of the cubic oscillator and its tangent have order 16 on any processor") {
  CubicOscillator oscillator{{0.07, 26.0, 36.0 / 35.0, 1.1, 0.8, 2.0}};
  const Vector p = vector({0.07, 36.0 / 35.0, 1.1, 0.8, 2.0 / 25.0, 25.0});
  const std::vector<std::size_t> none;
  for (const detail::SeriesKernels* kernels : {&detail::series_generic, &detail::series_kernels()}) {
    detail::CubicSeries<1> series(oscillator, none, 0.25, *kernels);
    detail::CubicState<1> z;
    z.v = 0.4;
    z.cosine = std::cos(0.3 * oscillator.value[CubicOscillator::frequency]);
    z.sine = std::sin(0.3 * oscillator.value[CubicOscillator::frequency]);
    z.dx[0] = z.dv[1] = 1.0;
    series.expand(0.3, z);
    std::array<std::array<double, 6>, 2> error{};
    for (std::size_t i = 0; i < 2; ++i) {
      const double h = i == 0 ? 1.0 : 0.5;
      const LongState<6> exact = extrapolate<6>(motion_of(p, true), 0.3L, 0.3L + Number(h), {0.25L, 0.4L, 1, 0, 0, 1});
      const detail::CubicState<1> end = series.at(h);
      const std::array<double, 6> found{0.25 + end.moved, end.v, end.dx[0], end.dv[0], end.dx[1], end.dv[1]};
      for (std::size_t k = 0; k < 6; ++k) error[i][k] = static_cast<double>(std::abs(found[k] - exact[k]));
    }
    for (std::size_t k = 0; k < 6; ++k) {
      INFO("quantity " << k << ": errors " << error[0][k] << " " << error[1][k]);
      CHECK(error[0][k] > 1e-12);                      // above rounding, so that the order shows
      CHECK(error[1][k] < error[0][k] / 3e4 + 2e-14);  // at least 2^15
    }
  }
}

TEST_CASE("the series of the cubic oscillator agree to rounding on any processor and with more columns") {
  CubicOscillator oscillator{{0.07, 2.0, 36.0 / 35.0, 1.1, 0.8, 0.4}};
  const std::vector<std::size_t> none, all{0, 1, 2, 3, 4, 5};
  detail::CubicSeries<1> generic(oscillator, none, 0.25, detail::series_generic), best(oscillator, none, 0.25);
  detail::CubicSeries<3> generic_all(oscillator, all, 0.25, detail::series_generic), best_all(oscillator, all, 0.25);
  Random random(5);
  for (int i = 0; i < 100; ++i) {
    std::array<double, 6> start;
    for (double& one : start) one = random(-1.0, 1.0);
    const double t = random(0.0, 10.0), h = random(0.0, 1.0);
    const auto end = [&](auto& series) {
      typename std::remove_reference_t<decltype(series)>::State z;
      z.moved = start[0];
      z.v = start[1];
      z.cosine = std::cos(oscillator.value[CubicOscillator::frequency] * t);
      z.sine = std::sin(oscillator.value[CubicOscillator::frequency] * t);
      for (std::size_t k = 0; k < 2; ++k) {
        z.dx[k] = start[2 + k];
        z.dv[k] = start[4 + k];
      }
      series.expand(t, z);
      const auto out = series.at(h);
      std::vector<double> numbers{out.moved, out.v, out.cosine, out.sine};
      numbers.insert(numbers.end(), out.dx, std::end(out.dx));
      numbers.insert(numbers.end(), out.dv, std::end(out.dv));
      return numbers;
    };
    // Sums of 17 terms, each itself a sum of up to 17 terms of order one: some tens of units in the last place.
    const auto agree = [](const std::vector<double>& a, const std::vector<double>& b) {
      double most = 0.0;
      for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - b[k]) / (1.0 + std::abs(a[k])));
      return most < 5e-15;
    };
    const std::vector<double> found = end(best), more = end(best_all);
    REQUIRE(agree(found, end(generic)));
    REQUIRE(agree(more, end(generic_all)));
    REQUIRE(agree(found, {more[0], more[1], more[2], more[3], more[4], more[5], more[14], more[15]}));
    // The last coefficients carry the cancellation of their sums of products.
    CHECK(generic.last() == Approx(best.last()).epsilon(1e-10));
    CHECK(generic.before() == Approx(best.before()).epsilon(1e-10));
  }
}

TEST_CASE("the error of the series falls in proportion to the tolerance") {
  const HybridSystem system = make_oscillator("cantilever", "linear");
  const Vector p = parameters(system, {{"r", 50.0}, {"xi", 0.4}}), x0 = vector({0.5, -0.6});
  const FlowTask task{0.2, 8.0, Sensitivity::state};
  const Segment exact = carry_one(system, 0, p, task, x0, {.tolerance = 1e-16});
  std::size_t before = 0;
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    const Segment one = carry_one(system, 0, p, task, x0, {.tolerance = tolerance});
    INFO("tolerance " << tolerance);
    // Up to two dozen steps, each within the tolerance. The motion amplifies the errors little.
    CHECK((one.x1 - exact.x1).norm() < 20.0 * tolerance);
    CHECK((one.Phi - exact.Phi).norm() < 50.0 * tolerance);
    CHECK(one.evaluations >= before);
    before = one.evaluations;
  }
}

TEST_CASE("a short flight of the cantilever off a barrier keeps its accuracy down to speeds of 1e-9") {
  // A mass leaves the barrier at x = -r downwards. It returns with the same speed after 2 v/a (1 + O(v^2)), a = r + beta r^3 +
  // xi.
  const HybridSystem system = make_oscillator("cantilever", "newton");
  const Vector p = parameters(system, {{"r", -0.5}, {"xi", 0.08}, {"b", 0.0}, {"eta", 0.554}});
  const double a = 0.5 + p[beta] * 0.125 + 0.08;
  for (double speed = 1e-2; speed > 5e-10; speed /= 10.0) {
    const Segment flight = carry_one(system, 0, p, {0.0, 3.0, Sensitivity::state}, vector({-0.5, -speed}));
    INFO("speed " << speed);
    REQUIRE(flight.end == FlowEnd::event);
    REQUIRE(flight.x1[0] == -0.5);
    REQUIRE(flight.t1 == Approx(2.0 * speed / a).epsilon(10.0 * speed * speed + 1e-13));
    REQUIRE(flight.x1[1] == Approx(speed).epsilon(10.0 * speed * speed + 1e-13));
  }
}

TEST_CASE("an escape over a softening spring ends the segment as failed") {
  const HybridSystem system = make_oscillator("cantilever", "linear");
  const Vector p = parameters(system, {{"beta", -1.0}, {"r", 1e300}});
  const Segment one = carry_one(system, 0, p, {0.0, 100.0, Sensitivity::state}, vector({3.0, 1.0}), {.max_steps = 2000});
  REQUIRE(one.end == FlowEnd::failed);
}

TEST_CASE("the flow accepts a run of zero length and passes the barrier without events") {
  const HybridSystem system = make_oscillator("cantilever", "newton");
  const Vector p = parameters(system, {{"r", 0.079}});
  const Segment none = carry_one(system, 0, p, {1.0, 1.0, Sensitivity::state_and_parameters}, vector({0.0, 1.0}));
  REQUIRE(none.end == FlowEnd::time);
  REQUIRE(none.x1 == vector({0.0, 1.0}));
  REQUIRE(none.Phi == Matrix::Identity(2, 2));
  REQUIRE(none.Psi.isZero(0.0));
  REQUIRE(none.Psi.cols() == p.size());
  const Segment through = carry_one(system, 0, p, {0.0, 0.5, Sensitivity::none, false}, vector({0.0, 1.0}));
  REQUIRE(through.end == FlowEnd::time);
  REQUIRE(through.x1[0] > 0.079);
  REQUIRE(carry_one(system, 0, p, {0.0, 0.5, Sensitivity::none}, vector({0.0, 1.0})).end == FlowEnd::event);
}
