// SPDX-License-Identifier: GPL-3.0-or-later
// Exponents of chaotic motions, against independent values (another program: fixed-step extrapolation, its own tangent). The
// regular cases use 20,000 forcing periods. The hidden case continues until its errors are several times smaller than those of
// the reference. It takes minutes:   build/tests/tests_floquet "chaotic exponents to a ten-thousandth"
#include "support/checks.hpp"

#include <graze/floquet/attractor/attractor.hpp>
#include <graze/lib/models/oscillator.hpp>

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::support;

namespace {

struct Reference {
  const char *oscillator, *law;
  std::vector<std::pair<const char*, double>> parameters;
  Vector start;
  double exponent, standard_error;
};

const std::vector<Reference>& references() {
  const std::vector<std::pair<const char*, double>> beam = {{"b", 0.026}, {"r", 0.079}, {"xi", 0.08}, {"eta", 0.554}};
  static const std::vector<Reference> list = {
      {"linear", "hertz", {{"b_H", 0.1}, {"eta", 0.711}}, vector({-0.379, -0.717}), 0.0299, 3e-4},
      {"linear", "hertz", {{"b_H", 0.0}, {"eta", 0.7114}}, vector({0.0, 0.0}), 0.0269, 6e-4},
      {"linear", "newton", {{"k_r", 1.0}, {"eta", 0.711}}, vector({0.0, 0.0}), 0.0299, 4e-4},
      {"cantilever", "hertz", beam, vector({0.0, 0.0}), 0.0156, 3e-4},
      {"cantilever", "newton", beam, vector({0.0, 0.0}), 0.0237, 6e-4},
  };
  return list;
}

Attractor averaged(const Reference& reference, std::int64_t periods) {
  const HybridSystem system = make_oscillator(reference.oscillator, reference.law);
  Vector p = default_parameters(system.parameters);
  for (const auto& [name, value] : reference.parameters)
    p[static_cast<Eigen::Index>(parameter_index(system.parameters, name))] = value;
  AttractorOptions options;
  options.lyapunov.standard_error = 0.0;
  options.lyapunov.max_periods = periods;
  return find_attractor(system, p, reference.start, options);
}

/// Three joint standard errors: by chance one comparison in 370 would fail, but the runs are the same every time.
void compare(const Reference& reference, const Attractor& attractor, double liouville) {
  INFO(reference.oscillator << " " << reference.law << ": " << attractor.exponents.at(0) << " +- "
                            << attractor.standard_errors.at(0) << " against " << reference.exponent);
  CHECK(attractor.type == AttractorType::chaotic);
  CHECK(std::abs(attractor.exponents[0] - reference.exponent) <
        3.0 * std::hypot(attractor.standard_errors[0], reference.standard_error));
  CHECK(attractor.time_average.liouville_residual < liouville);
}

}  // namespace

TEST_CASE("chaotic exponents of the oscillators agree with independent values") {
  for (std::size_t k = 0; k < 3; ++k) compare(references()[k], averaged(references()[k], 20000), 1e-10);
}

TEST_CASE("chaotic exponents of the beam with a Hertz stop agree with independent values") {
  compare(references()[3], averaged(references()[3], 20000), 1e-10);
}

TEST_CASE("chaotic exponents of the beam with a rigid stop agree with independent values") {
  compare(references()[4], averaged(references()[4], 20000), 1e-10);
}

TEST_CASE("chaotic exponents to a ten-thousandth", "[.slow]") {
  for (const Reference& reference : references()) {
    const bool slow = std::string(reference.oscillator) == "cantilever";
    const Attractor attractor = averaged(reference, slow ? 500000 : 1000000);
    INFO(reference.oscillator << " " << reference.law << ": " << attractor.exponents.at(0) << " +- "
                              << attractor.standard_errors.at(0));
    CHECK(attractor.standard_errors[0] < 1.2e-4);
    compare(reference, attractor, 1e-10);  // in a million periods some impact is as slow as 1e-6
  }
}
