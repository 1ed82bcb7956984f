// SPDX-License-Identifier: GPL-3.0-or-later
// Parser: text to expressions. The grammar, weakest binding first:
//     expression  a + b, a - b;  a * b, a / b;  -a, +a;  a^b (from the right; -x^2 is -(x^2), 2^-x is allowed)
//     operand     number, name, name', name(expression, ...), (expression)
//     name        a letter or _, then letters, digits and _; Latin, Greek and Cyrillic letters with accents count
//     block       name' = expression, separated by line breaks or ;   (resets: name = expression)
// A line break inside parentheses, or after or before an operator, does not end an equation. # begins a comment. Every mistake
// is an EquationError with the place of the token at fault. Depth and length are limited, and the work grows linearly with the
// length.
#pragma once

#include <graze/lib/equations/expression.hpp>
#include <graze/lib/equations/source.hpp>

#include <functional>
#include <map>
#include <optional>

namespace graze::equations {

/// Largest nesting of parentheses, functions, signs and powers: more is a mistake, or an attack on the stack.
inline constexpr std::size_t max_nesting = 200;
/// Largest size of one text in bytes.
inline constexpr std::size_t longest_text = 1U << 20U;

/// A node that can fail at some values, with its place: a division (place of the divisor), a power, a function, a rate.
struct Hazard {
  Expression node;
  Place place;
};

/// The place of the first hazard with this node, or with the one from which substitutions made it. A quotient that no text holds,
/// such as the derivative of one, has the place of the first with its divisor.
std::optional<Place> known_place(const Graph& graph, const std::vector<Hazard>& hazards, Expression node);

/// The meaning of names in an expression.
struct Scope {
  /// Meaning of a name; nullopt: no such name.
  std::function<std::optional<Expression>(std::string_view)> find;
  /// Number of a spline's table; nullopt: no such table.
  std::function<std::optional<std::size_t>(std::string_view)> table = {};
  /// For suggestions.
  std::vector<std::string> names = {}, tables = {};
  /// Message for a name that exists but is not allowed here: "the state x cannot be used"; empty: the name is unknown.
  std::function<std::string(std::string_view)> refusal = {};
  /// True if name' is allowed.
  bool rates = true;
};

/// The scope of these names and tables (numbers of splines). It refers to both maps.
Scope scope_of(const std::map<std::string, Expression, std::less<>>& names,
               const std::map<std::string, std::size_t, std::less<>>& tables);

/// The expression of the whole text. `where` completes the messages: "in the equation of v".
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

/// A name with its meaning. Definitions may refer to each other in any order.
struct Definition {
  Text name;
  Text value;
};

/// Reads definitions; `scope` contains all other names, `kind` is "definition" or "parameter". The results are in the order of
/// the definitions. A cycle is refused, with the chain of its names.
std::vector<Expression> parse_definitions(Graph& graph, const Source& source, std::span<const Definition> definitions,
                                          const Scope& scope, std::string_view kind, std::vector<Hazard>* hazards = nullptr);

/// "; did you mean 'eta'?" with the nearest candidate (nearest_name); empty if none is near.
std::string suggestion(std::string_view name, const std::vector<std::string>& candidates);
/// The same, or "; choose one of ..." if none is near and they are few.
std::string suggestion_or_list(std::string_view name, const std::vector<std::string>& candidates);

/// True if the text contains names other than functions, t and pi.
bool has_names(const Source& source, const Text& text, std::string_view where);

/// True if the text is a name by the grammar above.
bool is_name(std::string_view text);
/// Functions, t and pi: names of a file must not shadow them.
const std::vector<std::string>& reserved_names();

}  // namespace graze::equations
