// SPDX-License-Identifier: GPL-3.0-or-later
// The one-degree-of-freedom impact oscillator, dimensionless, ' = d/dtau, state (x, x'):
//     x'' + 2 b x' + x + beta x^3 + F(x, x') = xi cos(eta tau),    one barrier at x = r, F from a contact law.
// beta = 0 is the linear oscillator, beta = 36/35 the cantilever with its first nonlinear term (Serweta et al. 2014).
//
// The family is a system written as text (equations/system_text.hpp): one mass, one stop.
#pragma once

#include <graze/lib/equations/system_text.hpp>
#include <graze/lib/models/contact_law.hpp>

namespace graze {

/// Positions of the oscillator's own parameters; those of the contact law start at `law`.
namespace oscillator_parameter {
enum Index : std::size_t { b, beta, xi, eta, r, law };
}

/// b, beta, xi, eta, r with their ranges and meanings.
const std::vector<ParameterInfo>& oscillator_parameters();

/// A named oscillator: the linear one and the cantilever differ in the default of beta.
struct OscillatorKind {
  std::string name;
  std::string formula;
  double beta = 0.0;
};
const std::vector<OscillatorKind>& oscillator_kinds();
const OscillatorKind& oscillator_kind(std::string_view name);

/// The oscillator with a contact law, named "<kind>-<law>", with its expressions. Modes: "free", and "contact" or "held".
/// @throws equations::EquationError if the text of the law is invalid.
equations::TextSystem read_oscillator(const OscillatorKind& kind, const ContactLaw& law);
/// The same with the parameters `added`, and with expressions (`tied`) in place of some of its own parameters. A tied name that
/// is no parameter of the oscillator or the law is added and can be read through TextSystem::tied.
equations::TextSystem read_oscillator(const OscillatorKind& kind, const ContactLaw& law, const std::vector<ParameterInfo>& added,
                                      const std::vector<equations::Definition>& tied);
/// The system alone.
HybridSystem make_oscillator(const OscillatorKind& kind, const ContactLaw& law);
inline HybridSystem make_oscillator(std::string_view kind, std::string_view law) {
  return make_oscillator(oscillator_kind(kind), contact_law(law));
}

/// Acceleration at the barrier of a mass at rest there: xi cos(eta t) - r - beta r^3; > 0 presses it against the barrier.
double barrier_acceleration(double t, const Vector& p);

/// The steady motion without barrier and without beta x^3, as a state at forcing phase 0:
///     x = xi (1 - eta^2) / D,   x' = 2 b eta^2 xi / D,   D = (1 - eta^2)^2 + (2 b eta)^2.
/// For beta = 0 it is the impactless orbit, while its amplitude xi / sqrt(D) stays below r.
Vector steady_response(const Vector& p);

}  // namespace graze
