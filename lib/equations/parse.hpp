// SPDX-License-Identifier: GPL-3.0-or-later
// Text to expressions. The grammar, weakest first:
//     expression  a + b, a - b;  a * b, a / b;  -a, +a;  a^b (from the right; -x^2 is -(x^2), 2^-x is allowed)
//     operand     number, name, name', name(expression, ...), (expression)
//     name        a letter or _, then letters, digits and _; Latin, Greek and Cyrillic letters with accents count
//     block       name' = expression, parted by line breaks or ;   (resets: name = expression)
// A line break inside parentheses, behind an operator or before one does not end an equation. # begins a comment.
// Every mistake is an EquationError with the place of the token at fault. Depth and length are limited, and the work grows
// linearly with the length.
#pragma once

#include <graze/lib/equations/expression.hpp>
#include <graze/lib/equations/source.hpp>

#include <functional>
#include <optional>

namespace graze::equations {

/// Parentheses, functions, signs and powers inside one another: deeper is a mistake, or an attack on the stack.
inline constexpr std::size_t deepest_nesting = 200;
/// Bytes of one text.
inline constexpr std::size_t longest_text = 1U << 20U;

/// Where the parser met what can go wrong: a division (place of the divisor), a power, a function, a rate.
struct Hazard {
  Expression node;
  Place place;
};

/// Of the first hazard with this node.
std::optional<Place> known_place(const std::vector<Hazard>& hazards, Expression node);

/// What a name stands for where an expression is read.
struct Scope {
  /// nullopt: no such name.
  std::function<std::optional<Expression>(std::string_view)> find;
  /// Of a spline's table; nullopt: no such table.
  std::function<std::optional<std::size_t>(std::string_view)> table = {};
  /// For suggestions.
  std::vector<std::string> names = {}, tables = {};
  /// What is said of a name that exists but has no place here: "the state x cannot be used"; empty: it is unknown.
  std::function<std::string(std::string_view)> refusal = {};
  /// Whether name' may be written.
  bool rates = true;
};

/// The expression that is the whole text. `where` completes the messages: "in the equation of v".
Expression parse_expression(Graph& graph, const Source& source, const Text& text, const Scope& scope, std::string_view where,
                            std::vector<Hazard>* hazards = nullptr);

/// One "name' = expression" (primed) or "name = expression".
struct Assignment {
  std::string name;
  bool primed = false;
  Place place;     ///< of the name
  Place equation;  ///< of the expression
  Expression value;
};

/// The assignments of a block, in order. `where_of` gives the `where` of an assignment to the name.
std::vector<Assignment> parse_block(Graph& graph, const Source& source, const Text& text, const Scope& scope,
                                    const std::function<std::string(std::string_view name)>& where_of,
                                    std::string_view where_of_block, std::vector<Hazard>* hazards = nullptr);

/// A name's meaning: any number of these may refer to each other in any order.
struct Definition {
  Text name;
  Text value;
};

/// Reads definitions; `scope` knows all other names, `kind` is "definition" or "parameter". The results stand in the order of
/// the definitions. A cycle is refused with the chain of its names.
std::vector<Expression> parse_definitions(Graph& graph, const Source& source, std::span<const Definition> definitions,
                                          const Scope& scope, std::string_view kind, std::vector<Hazard>* hazards = nullptr);

/// "; did you mean 'eta'?" with the nearest candidate; empty where none is near. (Of one letter any other is near.)
std::string suggestion(std::string_view name, const std::vector<std::string>& candidates);

/// Whether the text names anything but functions, t and pi.
bool has_names(const Source& source, const Text& text, std::string_view where);

/// Whether the text is a name by the grammar above.
bool is_name(std::string_view text);
/// Functions, t and pi: no name of a file may shadow them.
const std::vector<std::string>& reserved_names();

}  // namespace graze::equations
