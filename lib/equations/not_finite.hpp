// SPDX-License-Identifier: GPL-3.0-or-later
// Where an expression of a system's text is not finite: the innermost part at fault, its place and what it is, such as
// "the divisor x is zero".
#pragma once

#include <graze/lib/equations/system_text.hpp>

#include <optional>

namespace graze::equations {

struct NotFinite {
  Place place;
  std::string sentence;  ///< without an end: where it is so is not in it
  bool moves = false;    ///< it depends on the motion, not only on the parameters
};

/// Where the expressions stand.
struct Written {
  const Graph& graph;
  const Symbols& symbols;
  const std::vector<Hazard>& hazards;
};

/// Of one expression; `otherwise` is the place of what is not found among the hazards. nullopt: it is finite.
std::optional<NotFinite> find_not_finite(const Written& written, Expression root, double t, const Vector& x, const Vector& p,
                                         const Place& otherwise);

/// Of a mode's field and guards.
std::optional<NotFinite> find_not_finite(const TextSystem& text, std::size_t mode, double t, const Vector& x, const Vector& p);

/// Of all guards.
std::optional<NotFinite> find_not_finite_guard(const TextSystem& text, double t, const Vector& x, const Vector& p);

/// Of the derivatives of a mode's field in the states, where the field itself is finite.
std::optional<NotFinite> find_not_finite_derivative(const TextSystem& text, std::size_t mode, double t, const Vector& x,
                                                    const Vector& p);

/// A divisor in a mode's field or guards that has different signs at two states.
std::optional<NotFinite> find_pole(const TextSystem& text, std::size_t mode, double t0, const Vector& x0, double t1,
                                   const Vector& x1, const Vector& p);

/// Of the reset of an event.
std::optional<NotFinite> find_not_finite_reset(const TextSystem& text, std::size_t event, double t, const Vector& x,
                                               const Vector& p);

/// The message with its place in the file, and the state: "...: the divisor x is zero at t = 0, x = 0, v = 0".
EquationError not_finite_error(const TextSystem& text, const NotFinite& found, double t, const Vector& x);

}  // namespace graze::equations
