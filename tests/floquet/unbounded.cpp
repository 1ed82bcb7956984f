// SPDX-License-Identifier: GPL-3.0-or-later
// Results of settling and searching for motions that grow without bound or cannot be computed.
#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/attractor/search.hpp>
#include <graze/floquet/attractor/settle.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/checks.hpp"

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::support;

namespace {}  // namespace

TEST_CASE("undamped resonance is reported as growth and not as an unsettled transient") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const auto far = parameters(system, {{"b", 0.0}, {"eta", 1.0}, {"r", 1e9}});
  CHECK(settle(system, far, Vector::Zero(2), {.periods = 100}).termination == Termination::resonance);
  CHECK(find_attractor(system, far, Vector::Zero(2), {.transient = 100}).termination == Termination::resonance);
  // The barrier is reached long before, or damping limits the amplitude.
  for (const auto& p :
       {parameters(system, {{"b", 0.0}, {"eta", 1.0}, {"r", 5.0}}), parameters(system, {{"b", 1e-3}, {"eta", 1.0}, {"r", 1e9}})})
    CHECK(settle(system, p, Vector::Zero(2), {.periods = 100}).termination == Termination::time);
}

TEST_CASE("escape from a softening spring is reported as such") {
  const HybridSystem system = make_oscillator("cantilever", "hertz");
  const Vector p = parameters(system, {{"b", 0.05}, {"beta", -1.0}, {"xi", 2.0}, {"eta", 0.8}, {"r", 0.5}});
  CHECK(settle(system, p, Vector::Zero(2)).termination == Termination::escape);
  CHECK(find_attractor(system, p, Vector::Zero(2)).termination == Termination::escape);
}

TEST_CASE("a search in which no motion lasts a period ends at once") {
  const HybridSystem system = make_oscillator("cantilever", "newton");
  const SearchResult result = search_orbits(system, parameters(system, {{"b", 6e6}}), 1);
  CHECK(result.ended == Termination::integration_failed);
  CHECK(result.starts == 0);
  CHECK(search_orbits(system, parameters(system, {{"b", 0.05}, {"eta", 1.3}}), 1, {.patience = 20}).ended == Termination::time);
}

TEST_CASE("starts in a search may take a multiple of the steps of motions from rest") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector usual = parameters(system, {}),
               stiff = parameters(system, {{"k_H", 3e5}, {"r", -1.41}, {"eta", 0.065}, {"xi", 1.9}});
  CHECK(search_box(system, usual).max_steps == 2000);
  CHECK(search_box(system, stiff).max_steps > 10000);  // pressed for most of a long period
}
