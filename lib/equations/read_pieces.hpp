// SPDX-License-Identifier: GPL-3.0-or-later
// Reads the modes and events of a text, from its equations, mechanics and surfaces. Internal.
#pragma once

#include <graze/lib/equations/names.hpp>
#include <graze/lib/equations/pieces.hpp>

#include <optional>
#include <vector>

namespace graze::equations {

/// Replaces rates by expressions of a mode's field. Refers to its arguments.
class Rates {
 public:
  Rates(const Names& names, const ModePiece& mode)
      : names_(names), mode_(mode), field_(mode.field.size()), in_progress_(mode.field.size(), false) {}

  Expression resolve(Expression e);
  /// The rate of a state. @throws EquationError if it depends on itself.
  Expression field(std::size_t state);

 private:
  const Names& names_;
  const ModePiece& mode_;
  std::vector<std::optional<Expression>> field_;
  std::vector<char> in_progress_;
};

/// The modes and events of the text, without rates. @throws EquationError
Pieces read_pieces(Names& names);

}  // namespace graze::equations
