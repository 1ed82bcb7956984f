// SPDX-License-Identifier: GPL-3.0-or-later
// Report of attractors and their exponents: as JSON, as text.
#pragma once

#include <graze/apps/problem/problem.hpp>
#include <graze/apps/results/orbit_report.hpp>

#include <graze/floquet/attractor/attractor.hpp>

#include <string>
#include <vector>

namespace graze::apps {

/// An exponent for people: "-infinity" if the motion forgets a direction at once, "unknown" if there is none.
std::string exponent_text(double value, int digits);
/// A standard error for people: "unknown" if the average was too short for an error estimate.
std::string error_text(double value, int digits);

/// The residual of Liouville's identity; nullopt: not applicable.
std::optional<double> liouville_residual(const LyapunovSpectrum& spectrum);

/// "time_average" in graze.lyapunov/1; "attractor" in graze.lyapunov/1, graze.sweep/1 and graze.attractors/1. An attractor is
/// read back without `time_average`.
const Columns<LyapunovSpectrum>& spectrum_columns();
const Columns<Attractor>& attractor_columns();
/// The columns of the exponents that accompany an attractor.
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

/// Whether the state, multipliers and exponents of an attractor that was read have the length `states`; lists may be empty.
bool has_states(const Attractor& attractor, std::size_t states);

/// "z = 2/3"; "z = ∞/1" for an orbit that sticks; "chaotic", "undecided".
std::string attractor_name(const Attractor& attractor);

/// The whole text that `graze lyapunov` prints for an attractor. `max_period`: the longest period searched for orbits.
std::string attractor_text(const Problem& problem, const Attractor& attractor, int max_period);

}  // namespace graze::apps
