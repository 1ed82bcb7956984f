// SPDX-License-Identifier: GPL-3.0-or-later
// Attractors of many points side by side, against those of each point alone.
#include "support/checks.hpp"
#include "support/each_attractor.hpp"

#include <graze/floquet/attractor/attractor_decision.hpp>
#include <graze/lib/models/oscillator.hpp>

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::support;

namespace {

AttractorOptions quick() {
  AttractorOptions options;
  options.recurrence = 1e-4;
  options.periods_on_orbit = 0;
  options.lyapunov.standard_error = 3e-3;
  options.lyapunov.max_periods = 5000;
  options.lyapunov.min_periods = 200;
  return options;
}

std::vector<AverageStart> points(const HybridSystem& system) {
  std::vector<AverageStart> starts;
  for (const double eta : {0.68, 0.7, 0.711, 0.73, 0.745, 0.78, 0.82, 0.9, 0.93, 0.95})
    for (const double r : {1.3, 2.0}) starts.push_back({parameters(system, {{"eta", eta}, {"r", r}}), vector({0.0, 0.0})});
  return starts;
}

std::vector<AverageStart> cantilevers(const HybridSystem& system) {
  std::vector<AverageStart> starts;
  for (const double eta : {0.4, 0.45, 0.5, 0.53, 0.554, 0.58, 0.62, 0.7, 0.8})
    for (const double r : {0.06, 0.079})
      starts.push_back({parameters(system, {{"b", 0.026}, {"xi", 0.08}, {"eta", eta}, {"r", r}}), vector({0.0, 0.0})});
  return starts;
}

}  // namespace

TEST_CASE("attractors side by side agree with those of single motions") {
  const auto [model, law] =
      GENERATE(table<const char*, const char*>({{"linear", "newton"}, {"linear", "hertz"}, {"cantilever", "newton"}}));
  const HybridSystem system = make_oscillator(model, law);
  const std::vector<AverageStart> starts = model == std::string("linear") ? points(system) : cantilevers(system);
  const std::vector<Attractor> each = find_each_attractor(system, starts, quick());
  REQUIRE(each.size() == starts.size());
  int chaotic = 0, periodic = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const Attractor alone = find_attractor(system, starts[i].p, starts[i].state, quick());
    INFO("eta = " << starts[i].p[oscillator_parameter::eta] << ", r = " << starts[i].p[oscillator_parameter::r]);
    CHECK(each[i].type == alone.type);
    if (alone.type == AttractorType::periodic) {
      ++periodic;
      CHECK(each[i].period == alone.period);
      CHECK(each[i].impacts == alone.impacts);
      for (std::size_t k = 0; k < 2; ++k) CHECK(each[i].exponents[k] == Approx(alone.exponents[k]).margin(1e-9));
    } else if (alone.type == AttractorType::chaotic) {
      ++chaotic;
      CHECK(std::abs(each[i].exponents[0] - alone.exponents[0]) <
            5.0 * std::hypot(each[i].standard_errors[0], alone.standard_errors[0]));
      CHECK(each[i].time_average.liouville_residual < 1e-10);
    }
  }
  CHECK(periodic > 8);
  CHECK(chaotic > 1);
}

TEST_CASE("attractors of systems that the lanes do not support are found one by one") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"b", 1.1}, {"r", 0.4}, {"eta", 0.6}});  // overdamped
  const std::vector<Attractor> each = find_each_attractor(system, {{p, vector({0.0, 0.0})}}, quick());
  REQUIRE(each.size() == 1);
  const Attractor alone = find_attractor(system, p, vector({0.0, 0.0}), quick());
  CHECK(each[0].type == alone.type);
  CHECK(each[0].state == alone.state);
}

TEST_CASE("attractors side by side can be cancelled and refuse a start inside the barrier") {
  const HybridSystem system = make_oscillator("linear", "newton");
  AttractorOptions options = quick();
  options.lyapunov.cancelled = [] { return true; };
  for (const Attractor& attractor : find_each_attractor(system, points(system), options)) {
    CHECK(attractor.termination == Termination::interrupted);
    CHECK(attractor.type == AttractorType::undecided);
  }
  std::vector<AverageStart> starts = points(system);
  starts[3].state = vector({2.5, 0.0});
  CHECK_THROWS_AS(find_each_attractor(system, starts, quick()), std::invalid_argument);
  CHECK(find_each_attractor(system, {}, quick()).empty());
}

TEST_CASE("an attractor does not depend on the others for averages over one motion or several") {
  const char* law = GENERATE("newton", "hertz");
  const int motions = GENERATE(1, 16);
  const HybridSystem system = make_oscillator("linear", law);
  AttractorOptions options = quick();
  options.transient = 50;
  options.lyapunov.motions = motions;
  options.lyapunov.max_periods = 20000;
  // Chaos, transients that end on orbits, and orbits.
  std::vector<AverageStart> starts;
  for (const double eta : {0.7, 0.7095, 0.711, 0.73, 0.7396, 0.745, 0.75, 0.78, 0.95})
    starts.push_back({parameters(system, {{"eta", eta}, {"r", 2.0}}), vector({1.4292500922535618, 0.8555925090162767})});
  const std::vector<Attractor> together = find_each_attractor(system, starts, options);
  int chaotic = 0, periodic = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    INFO(law << ", eta = " << starts[i].p[oscillator_parameter::eta]);
    const Attractor alone = find_each_attractor(system, {starts[i]}, options).front();
    CHECK(together[i].type == alone.type);
    CHECK(together[i].period == alone.period);
    CHECK(together[i].state == alone.state);
    CHECK(together[i].exponents == alone.exponents);
    CHECK(together[i].time_average.periods == alone.time_average.periods);
    CHECK(together[i].time_average.others == alone.time_average.others);
    chaotic += alone.type == AttractorType::chaotic ? 1 : 0;
    periodic += alone.type == AttractorType::periodic ? 1 : 0;
  }
  CHECK(chaotic > 1);
  CHECK(periodic > 1);
}

TEST_CASE("chaos found by a short average needs confirmation unless another limit ended it") {
  AttractorOptions options = quick();
  Attractor attractor;
  attractor.type = AttractorType::chaotic;
  attractor.time_average.stop = LyapunovStop::standard_error;
  const auto after = [&](std::int64_t periods) {
    attractor.time_average.periods = periods;
    return needs_confirmation(options, attractor);
  };
  CHECK(after(200000));
  options.confirmed_below = 500;
  CHECK(after(200));
  CHECK(after(499));
  CHECK_FALSE(after(500));
  attractor.time_average.stop = LyapunovStop::budget;
  CHECK_FALSE(after(200));
}

TEST_CASE("a motion that settles during its average is recognised before the average ends") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  AttractorOptions options = quick();
  options.transient = 0;
  options.lyapunov.standard_error = 0.0;
  options.lyapunov.max_periods = 200000;
  int cancel_checks = 0;  // once in 32 periods of an average
  options.lyapunov.cancelled = [&cancel_checks] {
    ++cancel_checks;
    return false;
  };
  const AverageStart start{parameters(system, {{"eta", 0.93}, {"r", 2.0}, {"b_H", 0.1}}), vector({0.0, 0.0})};
  const Attractor attractor = find_each_attractor(system, {start}, options).front();
  CHECK(attractor.type == AttractorType::periodic);
  CHECK(attractor.impacts == 1);
  CHECK(cancel_checks < 200);
}

TEST_CASE("the length of a transient must not be negative") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"eta", 0.9}, {"r", 2.0}});
  AttractorOptions options;
  options.transient = -1;
  CHECK_THROWS_WITH(approach_attractor(system, p, vector({0.0, 0.0}), options), Catch::Contains("the transient is -1 periods"));
  options.transient = 0;
  const Attractor immediate = approach_attractor(system, p, vector({0.0, 0.0}), options);
  CHECK(immediate.termination == Termination::time);
  CHECK(immediate.state == vector({0.0, 0.0}));
}
