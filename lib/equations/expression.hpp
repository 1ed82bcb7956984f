// SPDX-License-Identifier: GPL-3.0-or-later
// Expressions in the states x, the parameters p and the time t, as one shared graph.
//
// A Graph owns all nodes; an Expression is an index into it. Equal nodes are stored once. The operands of a node have smaller
// indices than the node, so that the index order is an order of evaluation. The constructors simplify: constants are folded if
// the result is exact in double; 0 + x, 1 x, x^1, x - x and the like are reduced; signs move outwards. The operands of + and *
// are ordered by index, with numbers first in a product and last in a sum. No rule changes the value by more than the sign of a
// zero; 0 x is 0 for every x.
//
// A definition's rate of change, d', is a node `rate` until the field of a mode is known; system_text.cpp then replaces it.
#pragma once

#include <graze/lib/equations/spline.hpp>

#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace graze::equations {

enum class Operation : std::uint8_t {
  constant,
  pi,
  state,
  parameter,
  time,
  add,
  subtract,
  multiply,
  divide,
  negate,
  integer_power,  ///< a^n, n in Node::value
  power,          ///< a^b
  contact_power,  ///< max(a, 0)^e, e in Node::value: a contact law, zero outside the contact
  rate,           ///< d a/dt along the motion
  sin,
  cos,
  tan,
  asin,
  acos,
  atan,
  atan2,
  sinh,
  cosh,
  tanh,
  exp,
  log,
  sqrt,
  hypot,
  spline,  ///< derivative of order Node::value of spline number Node::index at a
  abs,
  sign,  ///< -1, 0, 1
  max,
  min,
  step,  ///< 1 if a >= 0, else 0
};

/// A node of a Graph.
struct Expression {
  std::uint32_t index = 0;
  friend auto operator<=>(const Expression&, const Expression&) = default;  // NOLINT(modernize-use-nullptr): clang-tidy 14
};

struct Node {
  Operation operation = Operation::constant;
  std::uint32_t index = 0;  ///< index of the state, the parameter or the spline
  Expression a = {}, b = {};
  double value = 0.0;
  friend bool operator==(const Node&, const Node&) = default;
};

/// The number of operands: 0, 1 or 2.
int operands(Operation operation);

/// Expression -> expression, for substitution.
using Replacement = std::unordered_map<std::uint32_t, Expression>;

class Graph {
 public:
  Graph();

  Expression constant(double value);
  Expression pi();
  Expression state(std::size_t index);
  Expression parameter(std::size_t index);
  Expression time();
  Expression add(Expression a, Expression b);
  Expression subtract(Expression a, Expression b);
  Expression multiply(Expression a, Expression b);
  Expression divide(Expression a, Expression b);
  Expression negate(Expression a);
  Expression power(Expression a, Expression b);
  Expression integer_power(Expression a, int n);
  Expression contact_power(Expression a, double exponent);
  Expression rate(Expression a);
  Expression spline(std::size_t table, Expression a, int order = 0);
  /// A function of one operand (sin ... sqrt, abs, sign, step) or two (atan2, hypot, max, min).
  Expression function(Operation operation, Expression a, Expression b = {});
  /// The operation of `node` applied to other operands, simplified.
  Expression with_operands(const Node& node, Expression a, Expression b);

  /// Adds a table and returns its number for spline(). @throws std::invalid_argument if the table does not describe a spline.
  std::size_t add_table(Table table);
  const std::vector<Spline>& splines() const { return splines_; }

  const Node& node(Expression e) const { return nodes_[e.index]; }
  std::size_t size() const { return nodes_.size(); }
  bool is_constant(Expression e, double value) const;

  /// The partial derivative in `symbol`, which is a state, a parameter or the time. For a nonsmooth function it is the
  /// derivative on the current branch. @throws std::logic_error if a rate is left in the expression.
  Expression derivative(Expression e, Expression symbol);

  /// The expression with every occurrence of the keys replaced. The inserted expressions are not searched again.
  Expression substitute(Expression e, const Replacement& replacement);
  /// The expression from which a substitution first made this one; nullopt: none did.
  std::optional<Expression> origin(Expression e) const;

 private:
  Expression intern(const Node& node);
  Expression derive(const Node& node, Expression self, Expression symbol, const std::function<Expression(Expression)>& d);

  struct Hash {
    std::size_t operator()(const Node& node) const;
  };
  std::vector<Node> nodes_;
  std::unordered_map<Node, std::uint32_t, Hash> index_;
  std::unordered_map<std::uint64_t, Expression> derivatives_;  // key: expression, symbol
  std::unordered_map<std::uint32_t, Expression> origins_;      // made -> original, which has the smaller index
  std::vector<Spline> splines_;
};

/// All nodes of the roots, operands first.
std::vector<Expression> reachable(const Graph& graph, std::span<const Expression> roots);
inline std::vector<Expression> reachable(const Graph& graph, Expression root) { return reachable(graph, {&root, 1}); }

/// The symbols on which an expression depends.
struct Dependence {
  std::vector<std::size_t> states, parameters;  ///< ascending
  bool time = false;
  bool rate = false;  ///< a rate is left in it
  bool moves() const { return time || rate || !states.empty(); }
};
Dependence dependence(const Graph& graph, std::span<const Expression> roots);
/// b of a/b, a of a^-n; nullopt: e is no quotient.
std::optional<Expression> divisor_of(const Graph& graph, Expression e);
inline Dependence dependence(const Graph& graph, Expression root) { return dependence(graph, {&root, 1}); }

/// The names of states and parameters, for printing.
struct Symbols {
  std::vector<std::string> states, parameters;
};

/// The expression as text that the parser reads back to the same expression (a contact power is written as a power). Texts
/// longer than `limit` bytes are cut and end in "...".
std::string to_text(const Graph& graph, Expression e, const Symbols& symbols, std::size_t limit = 1U << 20U);

/// The name of a function in texts: "sin", "atan2", .... Empty for an operation written with a symbol, such as +.
std::string function_name(Operation operation);

}  // namespace graze::equations
