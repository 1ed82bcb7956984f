// SPDX-License-Identifier: GPL-3.0-or-later
// What is said of attractors and their exponents: as JSON, as text.
#pragma once

#include <graze/apps/problem/problem.hpp>
#include <graze/apps/text/json.hpp>
#include <graze/apps/text/json_text.hpp>

#include <graze/floquet/attractor/attractor.hpp>

#include <string>
#include <vector>

namespace graze::apps {

/// Numbers as JSON has them: null where they are not finite.
Json numbers_json(const std::vector<double>& values);
/// Exponents read back: null is -infinity.
std::vector<double> numbers_of(const Json& json);

/// An exponent for people: "-infinity" where the motion forgets a direction at once, "unknown" where there is none.
std::string exponent_text(double value, int digits);
/// A standard error for people: "unknown" where the average was too short for one.
std::string error_text(double value, int digits);

Json spectrum_json(const LyapunovSpectrum& spectrum);

/// "attractor" in graze.lyapunov/1, graze.sweep/1 and graze.attractors/1.
Json attractor_json(const Attractor& attractor);
void write_attractor(const Attractor& attractor, JsonText& json);
/// What of it stands there, read back.
Attractor attractor_of(const Json& json);

/// "z = 2/3", "z = ∞/1" of an orbit that sticks, "chaotic", "undecided".
std::string attractor_name(const Attractor& attractor);

/// All that `graze lyapunov` prints of an attractor, where orbits of up to `max_period` were looked for.
std::string attractor_text(const Problem& problem, const Attractor& attractor, int max_period);

}  // namespace graze::apps
