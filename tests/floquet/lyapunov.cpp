// SPDX-License-Identifier: GPL-3.0-or-later
// Exponents by time average: against the multipliers on periodic orbits, against Liouville's identity in chaos. Their standard
// errors are compared with the scatter of independent runs.
#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/attractor/settle.hpp>
#include <graze/floquet/exponents/lyapunov.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/numerics/batch_means.hpp>
#include <graze/lib/numerics/log_product.hpp>

#include "support/checks.hpp"
#include "support/system_texts.hpp"
#include "support/two_mass_oscillator.hpp"

#include <catch2/catch.hpp>

#include <limits>
#include <numeric>
#include <random>

using namespace graze;
using namespace graze::support;

TEST_CASE("batch means: the error of a correlated series follows from its correlation time") {
  // x_{k+1} = a x_k + noise: variance 1 / (1 - a^2), integrated correlation time (1 + a) / (2 (1 - a)).
  const double a = 0.9;
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  BatchMeans means;
  double x = 0.0;
  constexpr int count = 400000;
  for (int k = 0; k < count; ++k) means.add(x = a * x + noise(random));
  const double tau = 0.5 * (1.0 + a) / (1.0 - a), error = std::sqrt(2.0 * tau / (1.0 - a * a) / count);
  // 32 to 64 batches estimate their spread with a relative error of 1 / sqrt(64 ... 128); the test allows three times that.
  CHECK(means.standard_error() == Approx(error).epsilon(0.35));
  CHECK(means.correlation_time() == Approx(tau).epsilon(0.75));
  CHECK(std::abs(means.mean()) < 4.0 * error);
}

TEST_CASE("batch means: for alternating terms the edge effect is reported") {
  BatchMeans means;
  for (int k = 0; k < 125; ++k) means.add(k % 2 ? -2.0 : 2.0);
  CHECK(means.mean() == Approx(2.0 / 125.0));
  CHECK(means.edge() == Approx(2.0 / 125.0).epsilon(0.01));
}

TEST_CASE("sixteen motions that stay together at a stable orbit are no evidence of chaos") {
  // With this linear stop the norm of a tangent vector alternates by a factor of seventy from period to period. The exponent
  // of the orbit is -2.7e-5, and an average over 125 periods of each motion ends on the larger norm.
  const HybridSystem system = make_oscillator("linear", "linear");
  const Vector p = parameters(
      system, {{"b", 0.011211269796007485}, {"k_S", 5338.038392993008}, {"eta", 1.0253945205925283}, {"r", 0.823360803917355}});
  const Attractor attractor = find_attractor(system, p, vector({-0.3109646792801404, 0.0}));
  CHECK(attractor.type == AttractorType::periodic);
  CHECK(attractor.period == 2);
  CHECK(attractor.impacts == 2);
  CHECK(attractor.exponents[0] == Approx(-2.7256e-5).epsilon(1e-4));  // known to five digits
}

TEST_CASE("Kaplan and Yorke's dimension") {
  CHECK(kaplan_yorke_dimension({-0.1, -0.2}) == 0.0);
  CHECK(kaplan_yorke_dimension({0.1, -0.2}) == Approx(1.5));
  CHECK(kaplan_yorke_dimension({0.1, -0.05, -0.2}) == Approx(2.25));
  CHECK(kaplan_yorke_dimension({0.1, 0.0}) == 2.0);
  CHECK(kaplan_yorke_dimension({0.1, -std::numeric_limits<double>::infinity()}) == 1.0);
}

TEST_CASE("on a stable orbit the time average agrees with the multipliers") {
  for (const auto& [law, eta, b_H] :
       {std::tuple{"hertz", 0.925, 0.1}, {"hertz", 0.85, 0.1}, {"newton", 0.9, 0.0}, {"hertz", 0.744, 0.0}}) {
    const HybridSystem system = make_oscillator("linear", law);
    Vector p = default_parameters(system.parameters);
    p[oscillator_parameter::eta] = eta;
    if (std::string(law) == "hertz") p[oscillator_parameter::law + 1] = b_H;
    const Settled settled = settle(system, p, Vector::Zero(2), {.periods = 3000});
    REQUIRE(settled.suspected_period > 0);
    const PeriodicOrbit orbit = shoot(system, p, settled.state, settled.suspected_period);
    REQUIRE(orbit.stable());
    for (const int interval : {1, 15}) {
      LyapunovOptions options;
      options.interval = interval;
      options.standard_error = 0.0;
      options.max_periods = 6000;
      const LyapunovSpectrum spectrum = lyapunov_spectrum(system, p, orbit.state, options);
      INFO(law << " " << eta << ", orthonormalised every " << interval);
      CHECK(spectrum.stop == LyapunovStop::budget);
      // The frame needs some periods to align with its directions: an error of O(1) over the time of averaging.
      for (std::size_t i = 0; i < 2; ++i) CHECK(spectrum.exponents[i] == Approx(orbit.multipliers.exponents[i]).margin(2e-4));
      CHECK(spectrum.exponents[0] + spectrum.exponents[1] ==
            Approx(orbit.multipliers.exponents[0] + orbit.multipliers.exponents[1]).margin(1e-11));
      CHECK(spectrum.liouville_residual >= 0.0);
      CHECK(spectrum.liouville_residual < 1e-10);
      CHECK(spectrum.kaplan_yorke == 0.0);
      CHECK(spectrum.impacts == spectrum.periods * orbit.impacts / orbit.period);
    }
  }
}

TEST_CASE("in chaos the sum obeys Liouville and standard errors agree with the scatter of independent runs") {
  const HybridSystem system = make_oscillator("linear", "newton");
  Vector p = default_parameters(system.parameters);
  p[oscillator_parameter::eta] = 0.711;
  std::vector<double> firsts, errors;
  for (int run = 0; run < 12; ++run) {
    const Settled start = settle(system, p, Vector{{0.1 * run, 0.3}}, {.periods = 500});
    const LyapunovSpectrum spectrum = lyapunov_spectrum(system, p, start.state, {.standard_error = 1.5e-3});
    CHECK(spectrum.stop == LyapunovStop::standard_error);
    CHECK(spectrum.exponents[0] > 0.0);
    CHECK(spectrum.exponents[0] + spectrum.exponents[1] == Approx(-2.0 * p[oscillator_parameter::b]).margin(1e-10));
    CHECK(spectrum.liouville_residual < 1e-10);
    CHECK(spectrum.kaplan_yorke > 1.0);
    CHECK(spectrum.kaplan_yorke < 2.0);
    firsts.push_back(spectrum.exponents[0]);
    errors.push_back(spectrum.standard_errors[0]);
  }
  const double mean = std::accumulate(firsts.begin(), firsts.end(), 0.0) / 12.0;
  double scatter = 0.0, stated = 0.0;
  for (std::size_t i = 0; i < 12; ++i) {
    scatter += (firsts[i] - mean) * (firsts[i] - mean) / 11.0;
    stated += errors[i] * errors[i] / 12.0;
  }
  // chi-squared with 11 degrees of freedom: between 0.24 and 2.4 in 99 of 100 cases.
  CHECK(scatter / stated > 0.2);
  CHECK(scatter / stated < 2.8);
}

TEST_CASE("four states: the spectrum sums to the trace") {
  const HybridSystem system = two_mass_oscillator();
  const Vector p = parameters(system, {{"xi", 2.0}, {"eta", 0.7}, {"k_r", 0.7}});
  const LyapunovSpectrum spectrum =
      lyapunov_spectrum(system, p, vector({0.2, 1.0, 0.1, 0.3}), {.standard_error = 0.0, .max_periods = 500});
  REQUIRE(spectrum.exponents.size() == 4);
  CHECK(spectrum.liouville_residual >= 0.0);
  CHECK(spectrum.liouville_residual < 1e-10);
  CHECK(std::is_sorted(spectrum.exponents.rbegin(), spectrum.exponents.rend()));
}

TEST_CASE("a lost direction has the exponent minus infinity") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"k_r", 0.0}, {"eta", 0.9}, {"r", 1.0}});
  const Settled start = settle(system, p, Vector::Zero(2), {.periods = 100});
  const LyapunovSpectrum spectrum = lyapunov_spectrum(system, p, start.state, {.min_periods = 100, .max_periods = 1000});
  CHECK(spectrum.exponents[1] == -std::numeric_limits<double>::infinity());
  CHECK(spectrum.liouville_residual == -1.0);
}

TEST_CASE("a held mass loses only its own exponents, whatever the order of the masses (fixed)") {
  // x hits its wall. y rests on a seat or is held by friction and does not act on x.
  const auto exponents = [](const std::vector<std::string>& masses, bool seat) {
    SystemWriter writer;
    writer.system.name = "held";
    writer.forcing("eta").parameter("eta", "3.4");
    std::vector<std::string> speeds, forces;
    for (const std::string& mass : masses) {
      speeds.push_back(mass == "x" ? "v" : "w");
      forces.push_back(mass == "x" ? "cos(eta*t) - 0.05*v - 1.1*x + 0.1" : seat ? "3 + 0.1*x" : "0.01*x");
    }
    const std::size_t n = masses.size();
    std::vector<std::vector<std::string>> mass(n, std::vector<std::string>(n, "0"));
    const auto none = mass;
    for (std::size_t i = 0; i < n; ++i) mass[i][i] = "1";
    writer.mechanics(masses, speeds, {mass, none, none, forces}).stop("wall", "-x", "newton", {"0.8"});
    if (n > 1) seat ? writer.stop("seat", "1 - y", "newton", {"0.4"}) : writer.friction("floor", "w", "1", "0.3", "0.3");
    const HybridSystem system = equations::make_system(writer.system).system;
    Vector start = Vector::Constant(static_cast<Eigen::Index>(2 * n), 0.2);
    for (std::size_t i = 0; i < n; ++i)
      if (masses[i] == "x") start[static_cast<Eigen::Index>(i)] = -0.1;
    const Vector p = default_parameters(system.parameters);
    const Settled settled = settle(system, p, start, {.periods = 100});
    REQUIRE(settled.termination == Termination::time);
    return lyapunov_spectrum(system, p, settled.state, {.aligning = 200, .standard_error = 0.0, .max_periods = 4000}).exponents;
  };
  const std::vector<double> alone = exponents({"x"}, true);
  REQUIRE(alone[0] > 0.2);
  constexpr double minus_infinity = -std::numeric_limits<double>::infinity();
  for (const std::vector<std::string>& masses : {std::vector<std::string>{"x", "y"}, {"y", "x"}}) {
    INFO(masses[0] << " first");
    const std::vector<double> resting = exponents(masses, true), stuck = exponents(masses, false);
    CHECK(std::abs(resting[0] - alone[0]) < 0.03);  // chaos over 4000 periods: standard errors of 0.005
    CHECK(std::abs(resting[1] - alone[1]) < 0.03);
    CHECK(resting[2] == minus_infinity);
    CHECK(resting[3] == minus_infinity);
    CHECK(std::abs(stuck[0] - alone[0]) < 0.03);
    CHECK(std::abs(stuck[1]) < 1e-12);
    CHECK(std::abs(stuck[2] - alone[1]) < 0.03);
    CHECK(stuck[3] == minus_infinity);
  }
}

TEST_CASE("the stopping rule of the source works and misuse of exponents is refused in one sentence") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = default_parameters(system.parameters);
  const Settled start = settle(system, p, Vector::Zero(2), {.periods = 500});
  const LyapunovSpectrum spectrum = lyapunov_spectrum(system, p, start.state, {.interval = 15, .change = 1e-6});
  CHECK(spectrum.stop == LyapunovStop::change);
  CHECK(spectrum.periods % 15 == 0);
  CHECK_THROWS_WITH(lyapunov_spectrum(system, p, start.state, {.interval = 0}), Catch::Contains("interval is 0"));
  CHECK_THROWS_WITH(lyapunov_spectrum(system, p, start.state, {.interval = 5, .max_periods = 3}),
                    Catch::Contains("max_periods is 3"));
  int cancel_checks = 0;
  LyapunovOptions options;
  options.cancelled = [&] { return ++cancel_checks > 3; };
  CHECK(lyapunov_spectrum(system, p, start.state, options).stop == LyapunovStop::interrupted);
}

TEST_CASE("an attractor is periodic if an orbit is proved and chaotic only if its exponent exceeds its error") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  Vector p = default_parameters(system.parameters);
  p[oscillator_parameter::law + 1] = 0.1;
  // 0.7433 and 0.9195 lie 2e-5 and 4e-5 beyond their period doublings: in 1000 periods the motion does not settle to 1e-6.
  for (const auto& [eta, period, impacts] :
       {std::tuple{0.925, 1, 1}, {0.85, 2, 1}, {0.7433, 4, 4}, {0.9195, 2, 2}, {0.66, 1, 0}}) {
    p[oscillator_parameter::eta] = eta;
    const Attractor attractor = find_attractor(system, p, Vector::Zero(2));
    INFO(eta);
    REQUIRE(attractor.type == AttractorType::periodic);
    CHECK(attractor.period == period);
    CHECK(attractor.impacts == impacts);
    REQUIRE(attractor.orbit);
    CHECK(attractor.exponents == attractor.orbit->multipliers.exponents);
    // The shortcut leads to the orbit of plain simulation.
    const Settled plain = settle(system, p, Vector::Zero(2), {.periods = 40000});
    double nearest = 1.0;
    for (const Vector& state : attractor.orbit->states) nearest = std::min(nearest, (state - plain.state).norm());
    CHECK(nearest < 1e-6);
  }
  p[oscillator_parameter::eta] = 0.72;
  const Attractor chaos = find_attractor(system, p, Vector::Zero(2));
  CHECK(chaos.type == AttractorType::chaotic);
  CHECK(chaos.exponents[0] > 5.0 * chaos.standard_errors[0]);
  CHECK_FALSE(chaos.orbit);
  // A budget that is used up is reported.
  AttractorOptions little;
  little.lyapunov.max_periods = 50;
  const Attractor undecided = find_attractor(system, p, Vector::Zero(2), little);
  CHECK(undecided.time_average.stop == LyapunovStop::budget);
  CHECK(undecided.time_average.periods == 50);
}

TEST_CASE("an average that is interrupted at the check of its ends reports this and keeps its exponents") {
  // Chaos so weak that the ends are checked: tangents grow little enough in 128 periods.
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"b", 0.05}, {"eta", 0.7347}, {"r", 2.0}, {"k_H", 100.0}, {"b_H", 0.1}});
  AttractorOptions options;
  options.lyapunov.motions = 16;
  options.lyapunov.standard_error = 0.0;
  options.lyapunov.max_periods = 20000;
  int cancel_checks = 0;
  options.lyapunov.cancelled = [&] { return ++cancel_checks < 0; };
  const LyapunovSpectrum average = lyapunov_spectrum(system, p, vector({-0.379, -0.717}), options.lyapunov);
  REQUIRE(average.stop == LyapunovStop::budget);
  const int in_average = cancel_checks;
  cancel_checks = 0;
  options.lyapunov.cancelled = [&] { return ++cancel_checks > in_average; };
  Attractor attractor;
  attractor.termination = Termination::time;
  attractor.state = vector({-0.379, -0.717});
  average_on_attractor(system, p, attractor, options);
  CHECK(cancel_checks == in_average + 1);
  CHECK(attractor.time_average.stop == LyapunovStop::interrupted);
  CHECK(attractor.exponents == average.exponents);
}

TEST_CASE("an average that reaches an orbit gives the same result after any interruption") {
  // Fixed: an interrupted average analysed its motions as if it had ended, and took an orbit found there for the attractor.
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"eta", 0.7095}, {"r", 2.0}});
  const auto find = [&](int last, int& cancel_checks) {
    AttractorOptions options;
    options.lyapunov.max_periods = 20000;
    options.lyapunov.cancelled = [&cancel_checks, last] { return ++cancel_checks > last; };
    Attractor attractor;
    attractor.termination = Termination::time;
    attractor.state = vector({1.4292500922535618, 0.8555925090162767});  // in transient chaos
    average_on_attractor(system, p, attractor, options);
    return attractor;
  };
  int all = 0;
  const Attractor whole = find(std::numeric_limits<int>::max(), all);
  REQUIRE(whole.type == AttractorType::periodic);
  REQUIRE(whole.time_average.periods > 10000);
  REQUIRE(all > 20);
  int interrupted = 0;
  for (int last = 0; last < all; ++last) {
    int cancel_checks = 0;
    const Attractor part = find(last, cancel_checks);
    const bool broken_off = part.time_average.stop == LyapunovStop::interrupted;
    interrupted += broken_off ? 1 : 0;
    CHECK(broken_off == (part.type != AttractorType::periodic));
    if (!broken_off) CHECK(part.time_average.periods == whole.time_average.periods);
  }
  CHECK(interrupted > 15);
}

TEST_CASE("products of many factors have the logarithm of their sum") {
  LogProduct product;
  double sum = 0.0;
  for (int i = 1; i < 2000; ++i) {
    const double factor = (i % 2 == 0 ? -1.0 : 1.0) * std::pow(10.0, 40.0 * std::sin(0.01 * i));
    product.multiply(factor);
    sum += std::log(std::abs(factor));
  }
  CHECK(product.value() == Approx(sum).epsilon(1e-12));
  product.multiply(0.0);
  CHECK(product.value() == -std::numeric_limits<double>::infinity());
  product.multiply(std::numeric_limits<double>::quiet_NaN());
  CHECK(std::isnan(product.value()));
}
