// SPDX-License-Identifier: GPL-3.0-or-later
// The names of a system's text and their meanings: states, parameters with their values, definitions, tables. Internal.
//
// A text becomes a system in three steps, each with a form of its own: Names, then modes and events as expressions (Pieces), then
// the functions of a HybridSystem.
#pragma once

#include <graze/lib/equations/parse.hpp>
#include <graze/lib/equations/system_text.hpp>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace graze::equations {

struct Names {
  const SystemText& text;
  Graph& graph;
  std::vector<Text> states = {};               ///< as in the text: SystemText::state_texts
  Symbols symbols = {};                        ///< names of the states and of the free parameters
  std::vector<ParameterInfo> parameters = {};  ///< the free ones
  std::vector<TiedParameter> tied = {};
  Vector defaults = {};              ///< of the free parameters
  std::optional<Vector> start = {};  ///< at t = 0
  /// By name: "state", "parameter", "definition" or "output".
  std::map<std::string, std::string, std::less<>> kinds = {};
  std::map<std::string, Expression, std::less<>> meanings = {};
  std::map<std::string, std::size_t, std::less<>> tables = {};  ///< numbers of the graph's splines
  std::vector<Hazard> hazards = {};

  [[noreturn]] void refuse(const Place& place, const std::string& message) const {
    throw EquationError(text.source, place, message);
  }
  bool is_parameter(std::string_view name) const;
  std::optional<std::size_t> state_number(std::string_view name) const;
  /// The value at the default parameters.
  double value_of(Expression e) const;
  /// The names known so far; declared names that are not known yet are refused. Refers to this object.
  Scope scope(bool with_time) const;
  /// Names of parameters only.
  Scope parameter_scope() const;
};

/// Reads all names but the outputs' meanings. @throws EquationError
Names read_names(const SystemText& text, Graph& graph);

/// The functions of an expression of parameters only.
std::function<double(const Vector& p)> function_of_parameters(const Graph& graph, Expression e);
std::function<void(const Vector& p, Vector& out)> gradient_of_parameters(Graph& graph, Expression e);

}  // namespace graze::equations
