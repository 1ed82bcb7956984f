// SPDX-License-Identifier: GPL-3.0-or-later
// Modes and events as expressions: what a system is between its text and its functions. Internal.
#pragma once

#include <graze/lib/equations/expression.hpp>
#include <graze/lib/equations/source.hpp>
#include <graze/lib/system/hybrid_system.hpp>

#include <optional>

namespace graze::equations {

/// In EventPiece::text: an event that no text gives, made from a nonsmooth function.
inline constexpr std::size_t made_event = static_cast<std::size_t>(-1);

/// See Constraint.
struct ConstraintPiece {
  Expression value;
  std::vector<Expression> direction = {};
};

struct ModePiece {
  std::string name;
  std::vector<Expression> field;
  std::vector<Place> equation;  ///< of each state
  Place place;                  ///< of its name
  std::vector<ConstraintPiece> constraints = {};
};

/// Of an impact: see Accumulation.
struct AccumulationPiece {
  std::size_t sticking_mode = 0;
  std::vector<Expression> map;
  Expression pressing;
};
/// See Alternative: where one of the conditions is not positive, `event` fires instead.
struct AlternativePiece {
  std::vector<Expression> conditions;
  std::size_t event = 0;
};

struct EventPiece {
  std::string name;
  std::size_t text = 0;   ///< number in SystemText::events
  std::size_t count = 0;  ///< as SystemText has it
  EventKind kind = EventKind::other;
  std::size_t from = 0, to = 0;
  Expression guard;
  std::vector<Expression> map;  ///< x+ of every state
  bool continuous = false;      ///< known from its making
  bool decided = false;         ///< it is known that it is not, too
  Place when, reset;
  std::optional<AccumulationPiece> accumulation = {};
  std::optional<AlternativePiece> otherwise = {};
  std::optional<Expression> effective_mass = {};
  std::optional<Expression> opening_rate = {};
  std::optional<Expression> restitution = {};  ///< of the parameters: the volume changes by its square
};

/// Modes that a surface h = 0 parts, so that a reset which changes h leads to the side where it ends. A constraint that only one
/// mode keeps has the same mode on both sides, that without it.
struct SurfacePiece {
  Expression h;
  std::size_t below = 0, above = 0;
  std::optional<std::size_t> sliding = {};
  Replacement on_it = {};  ///< a state as a function of the others where h = 0, if it is known
  bool parts(std::size_t mode) const { return mode == sliding || (below != above && (mode == below || mode == above)); }
};

struct Pieces {
  std::vector<ModePiece> modes;
  std::vector<EventPiece> events;
  std::vector<SurfacePiece> surfaces = {};
};

}  // namespace graze::equations
