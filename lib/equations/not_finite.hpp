// SPDX-License-Identifier: GPL-3.0-or-later
// Diagnosis of an expression of a system's text that is not finite: the innermost part at fault, its place and the reason, such
// as "the divisor x is zero".
#pragma once

#include <graze/lib/equations/system_text.hpp>

#include <optional>

namespace graze::equations {

struct NotFinite {
  Place place;
  std::string sentence;  ///< reason, without the place or state at which it occurs
  bool moves = false;    ///< the part depends on the motion, not only on the parameters
};

/// The graph of the expressions, with names and places for messages.
struct Written {
  const Graph& graph;
  const Symbols& symbols;
  const std::vector<Hazard>& hazards;
};

/// Diagnosis of one expression; `otherwise` is the place if the part is not among the hazards. nullopt: it is finite.
std::optional<NotFinite> find_not_finite(const Written& written, Expression root, double t, const Vector& x, const Vector& p,
                                         const Place& otherwise);

/// Diagnosis of a mode's field and guards.
std::optional<NotFinite> find_not_finite(const TextSystem& text, std::size_t mode, double t, const Vector& x, const Vector& p);

/// Diagnosis of all guards.
std::optional<NotFinite> find_not_finite_guard(const TextSystem& text, double t, const Vector& x, const Vector& p);

/// Diagnosis of the derivatives of a mode's field in the states, for a finite field.
std::optional<NotFinite> find_not_finite_derivative(const TextSystem& text, std::size_t mode, double t, const Vector& x,
                                                    const Vector& p);

/// A divisor in a mode's field or guards that has different signs at two states. `adjacent`: the states are so close that a
/// divisor that is halved between them goes to zero too.
std::optional<NotFinite> find_pole(const TextSystem& text, std::size_t mode, double t0, const Vector& x0, double t1,
                                   const Vector& x1, const Vector& p, bool adjacent);

/// Diagnosis of the reset of an event.
std::optional<NotFinite> find_not_finite_reset(const TextSystem& text, std::size_t event, double t, const Vector& x,
                                               const Vector& p);

/// The message with its place in the file, and the state: "...: the divisor x is zero at t = 0, x = 0, v = 0".
EquationError not_finite_error(const TextSystem& text, const NotFinite& found, double t, const Vector& x);

}  // namespace graze::equations
