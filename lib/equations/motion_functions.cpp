// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/constraints.hpp>
#include <graze/lib/equations/motion_functions.hpp>
#include <graze/lib/equations/nonsmooth.hpp>

#include <algorithm>
#include <stdexcept>

namespace graze::equations {

namespace {

/// A nonsmooth function on the branch of a given sign: s is the sign, h is 1 if it is not negative and 0 otherwise.
Expression branch(Graph& graph, const Node& node, Expression s, Expression h) {
  switch (node.operation) {
  case Operation::abs:
    return graph.multiply(s, node.a);
  case Operation::sign:
    return s;
  case Operation::step:
    return h;
  default: {
    const Expression other = graph.subtract(graph.constant(1.0), h);
    const bool largest = node.operation == Operation::max;
    return graph.add(graph.multiply(largest ? h : other, node.a), graph.multiply(largest ? other : h, node.b));
  }
  }
}

}  // namespace

MotionFunctions::MotionFunctions(Graph& graph, const std::vector<Expression>& of, std::size_t states) : size_(of.size()) {
  // The symbols of the signs are constant in time.
  const auto rate = [&](Expression e) {
    return rate_along(graph, e, [&](std::size_t i) { return i < 3 * states ? graph.state(states + i) : graph.constant(0.0); });
  };
  const auto has_symbol = [&](Expression e, std::size_t from, std::size_t to) {
    const std::vector<std::size_t> on = dependence(graph, e).states;
    return std::any_of(on.begin(), on.end(), [&](std::size_t i) { return i >= from && i < to; });
  };
  std::vector<Expression> outputs;
  for (const Expression e : of) {
    Replacement known;
    for (const Expression part : reachable(graph, e))
      if (const Node n = graph.node(part); n.operation == Operation::rate)
        known.emplace(part.index, rate(graph.substitute(n.a, known)));
    outputs.push_back(graph.substitute(e, known));
    if (has_symbol(outputs.back(), 2 * states, 4 * states)) throw std::invalid_argument("a rate of a rate cannot be used");
  }
  std::vector<Expression> arguments;
  Replacement branches;
  for (const Expression part : reachable(graph, outputs)) {
    const Node n = graph.node(part);
    if (!is_nonsmooth(n.operation)) continue;
    const Expression argument = switching_argument(graph, n);
    if (!dependence(graph, argument).moves()) continue;
    const auto known = std::find(arguments.begin(), arguments.end(), argument);
    const auto i = static_cast<std::size_t>(known - arguments.begin());
    if (known == arguments.end()) arguments.push_back(argument);
    const Expression on_branch = branch(graph, n, graph.state(3 * states + 2 * i), graph.state(3 * states + 2 * i + 1));
    branches[part.index] = graph.substitute(on_branch, branches);
  }
  arguments_ = arguments.size();
  std::vector<Expression> on_branches;
  for (const auto* list : {&outputs, &arguments})
    for (const Expression e : *list) on_branches.push_back(graph.substitute(e, branches));
  for (auto* list : {&outputs, &on_branches}) {
    const std::size_t count = list->size();
    for (std::size_t k = 0; k < count; ++k) {
      list->push_back(rate((*list)[k]));
      second_rates_ = second_rates_ || has_symbol(list->back(), 2 * states, 3 * states);
    }
  }
  tape_ = Tape(graph, outputs);
  on_branches_ = Tape(graph, on_branches);
}

void MotionFunctions::evaluate(const HybridSystem& system, std::size_t mode, double t, const Vector& x, const Vector& p,
                               double* values, double* rates) const {
  run(tape_, system, mode, t, x, p, nullptr, values, rates);
}

void MotionFunctions::evaluate(const HybridSystem& system, std::size_t mode, double t, const Vector& x, const Vector& p,
                               const std::vector<int>& signs, double* values, double* rates) const {
  run(on_branches_, system, mode, t, x, p, &signs, values, rates);
}

void MotionFunctions::run(const Tape& tape, const HybridSystem& system, std::size_t mode, double t, const Vector& x,
                          const Vector& p, const std::vector<int>* signs, double* values, double* rates) const {
  const Mode& field = system.modes[mode];
  const Eigen::Index n = x.size();
  thread_local Vector f, f_dt, symbols;
  thread_local Matrix f_dx;
  thread_local std::vector<double> workspace, out;
  f.resize(n);
  symbols.setZero(3 * n + (signs ? 2 * static_cast<Eigen::Index>(signs->size()) : 0));
  field.field(t, x, p, f);
  symbols.head(n) = x;
  symbols.segment(n, n) = f;
  if (second_rates_) {
    f_dx.resize(n, n);
    field.field_dx(t, x, p, f_dx);
    symbols.segment(2 * n, n) = f_dx * f;
    if (field.field_dt) {
      f_dt.resize(n);
      field.field_dt(t, x, p, f_dt);
      symbols.segment(2 * n, n) += f_dt;
    }
  }
  if (signs)
    for (std::size_t i = 0; i < signs->size(); ++i) {
      symbols[3 * n + 2 * static_cast<Eigen::Index>(i)] = (*signs)[i];
      symbols[3 * n + 2 * static_cast<Eigen::Index>(i) + 1] = (*signs)[i] >= 0 ? 1.0 : 0.0;
    }
  workspace.resize(std::max(workspace.size(), tape.workspace()));
  out.resize(tape.outputs());
  tape.evaluate(t, symbols.data(), p.data(), workspace.data(), out.data());
  const auto middle = out.begin() + static_cast<std::ptrdiff_t>(out.size() / 2);
  std::copy(out.begin(), middle, values);
  std::copy(middle, out.end(), rates);
}

}  // namespace graze::equations
