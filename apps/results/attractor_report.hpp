// SPDX-License-Identifier: GPL-3.0-or-later
// What is said of attractors and their exponents: as JSON, as text.
#pragma once

#include <graze/apps/problem/problem.hpp>
#include <graze/apps/results/orbit_report.hpp>

#include <graze/floquet/attractor/attractor.hpp>

#include <string>
#include <vector>

namespace graze::apps {

/// An exponent for people: "-infinity" where the motion forgets a direction at once, "unknown" where there is none.
std::string exponent_text(double value, int digits);
/// A standard error for people: "unknown" where the average was too short for one.
std::string error_text(double value, int digits);

/// Empty: not applicable.
std::optional<double> liouville_residual(const LyapunovSpectrum& spectrum);

/// "time_average" in graze.lyapunov/1; "attractor" in graze.lyapunov/1, graze.sweep/1 and graze.attractors/1, which is read back
/// without `time_average`.
const Columns<LyapunovSpectrum>& spectrum_columns();
const Columns<Attractor>& attractor_columns();
/// The exponents that stand beside it.
Columns<Attractor> exponents_columns();

template <>
struct JsonForm<AttractorType>
    : ChoiceForm<AttractorType, attractor_type_name, AttractorType::undecided, AttractorType::periodic, AttractorType::chaotic> {
};
template <>
struct JsonForm<ConservativeMotion>
    : ChoiceForm<ConservativeMotion, conservative_motion_name, ConservativeMotion::unknown, ConservativeMotion::neutral,
                 ConservativeMotion::island, ConservativeMotion::chaotic_sea> {};
template <> struct JsonForm<LyapunovSpectrum> : RecordForm<LyapunovSpectrum, spectrum_columns> {};
template <> struct JsonForm<Attractor> : RecordForm<Attractor, attractor_columns> {
  static Attractor value(const Json& json) {
    Attractor attractor;
    attractor.termination = Termination::time;
    read(attractor_columns(), json, attractor);
    return attractor;
  }
};

/// "z = 2/3", "z = ∞/1" of an orbit that sticks, "chaotic", "undecided".
std::string attractor_name(const Attractor& attractor);

/// All that `graze lyapunov` prints of an attractor, where orbits of up to `max_period` were looked for.
std::string attractor_text(const Problem& problem, const Attractor& attractor, int max_period);

}  // namespace graze::apps
