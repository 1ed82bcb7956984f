// SPDX-License-Identifier: GPL-3.0-or-later
// Modes and events as expressions: the form of a system between its text and its functions. Internal.
#pragma once

#include <graze/lib/equations/expression.hpp>
#include <graze/lib/equations/source.hpp>
#include <graze/lib/system/hybrid_system.hpp>

#include <optional>

namespace graze::equations {

/// In EventPiece::text: the event is not in the text, but made from mechanics or a surface, or from a nonsmooth function.
inline constexpr std::size_t made_event = static_cast<std::size_t>(-1), split_event = made_event - 1;

/// See Constraint.
struct ConstraintPiece {
  Expression value;
  std::vector<Expression> direction = {};
};

struct ModePiece {
  std::string name;
  std::vector<Expression> field;
  std::vector<Place> equation;  ///< for each state
  Place place;                  ///< of its name
  std::vector<ConstraintPiece> constraints = {};
  /// Not negative in the mode, and watched by no guard: states for which one is negative begin in another mode.
  std::vector<Expression> conditions = {};
};

/// Of an impact: see Accumulation.
struct AccumulationPiece {
  std::size_t sticking_mode = 0;
  std::vector<Expression> map;
  Expression pressing;
};
/// See Alternative: if one of the conditions is not positive, `event` fires instead.
struct AlternativePiece {
  std::vector<Expression> conditions;
  std::size_t event = 0;
};

struct EventPiece {
  std::string name;
  std::size_t text = 0;   ///< number in SystemText::events
  std::size_t count = 0;  ///< as in EventText
  EventKind kind = EventKind::other;
  std::size_t from = 0, to = 0;
  Expression guard;
  std::vector<Expression> map;  ///< x+ of every state
  bool continuous = false;      ///< known by construction
  bool decided = false;         ///< `continuous` is final, also if it is false
  Place when, reset;
  std::optional<AccumulationPiece> accumulation = {};
  std::optional<AlternativePiece> otherwise = {};
  std::optional<Expression> effective_mass = {};
  std::optional<Expression> opening_rate = {};
  std::optional<Expression> restitution = {};  ///< depends on parameters only: the volume changes by its square
};

/// Modes separated by a surface h = 0: a reset that changes h leads to the side on which it ends. For a constraint that only
/// one mode preserves, `below` and `above` are the same mode, the one without it.
struct SurfacePiece {
  Expression h;
  std::size_t below = 0, above = 0;
  std::optional<std::size_t> sliding = {};
  Replacement state_on_surface = {};  ///< a state as a function of the others on h = 0, if known
  bool parts(std::size_t mode) const { return mode == sliding || (below != above && (mode == below || mode == above)); }
};

struct Pieces {
  std::vector<ModePiece> modes;
  std::vector<EventPiece> events;
  std::vector<SurfacePiece> surfaces = {};
};

struct Names;

/// The number of the mode with this name. `who` names it: "the event wall". @throws EquationError
std::size_t mode_number(const Names& names, const Pieces& pieces, const Text& name, const std::string& who);

}  // namespace graze::equations
