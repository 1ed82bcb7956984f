// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/mechanics.hpp>
#include <graze/lib/equations/motion_functions.hpp>

#include <algorithm>
#include <stdexcept>

namespace graze::equations {

MotionFunctions::MotionFunctions(Graph& graph, std::vector<Expression> of, std::size_t states) : size_(of.size()) {
  const auto rate = [&](Expression e) { return rate_along(graph, e, [&](std::size_t i) { return graph.state(states + i); }); };
  const auto needs = [&](Expression e, std::size_t from) {
    const std::vector<std::size_t> on = dependence(graph, e).states;
    return std::any_of(on.begin(), on.end(), [from](std::size_t i) { return i >= from; });
  };
  std::vector<Expression> outputs;
  for (const Expression e : of) {
    Replacement known;
    for (const Expression part : reachable(graph, e))
      if (const Node n = graph.node(part); n.operation == Operation::rate)
        known.emplace(part.index, rate(graph.substitute(n.a, known)));
    outputs.push_back(graph.substitute(e, known));
    if (needs(outputs.back(), 2 * states)) throw std::invalid_argument("a rate of a rate cannot be used");
  }
  for (std::size_t k = 0; k < size_; ++k) {
    outputs.push_back(rate(outputs[k]));
    second_rates_ = second_rates_ || needs(outputs.back(), 2 * states);
  }
  tape_ = Tape(graph, outputs);
}

void MotionFunctions::evaluate(const HybridSystem& system, std::size_t mode, double t, const Vector& x, const Vector& p,
                               double* values, double* rates) const {
  const Mode& field = system.modes[mode];
  const Eigen::Index n = x.size();
  thread_local Vector f, f_dt, symbols;
  thread_local Matrix f_dx;
  thread_local std::vector<double> workspace, out;
  f.resize(n);
  symbols.setZero(3 * n);
  field.field(t, x, p, f);
  symbols.head(n) = x;
  symbols.segment(n, n) = f;
  if (second_rates_) {
    f_dx.resize(n, n);
    field.field_dx(t, x, p, f_dx);
    symbols.tail(n) = f_dx * f;
    if (field.field_dt) {
      f_dt.resize(n);
      field.field_dt(t, x, p, f_dt);
      symbols.tail(n) += f_dt;
    }
  }
  workspace.resize(std::max(workspace.size(), tape_.workspace()));
  out.resize(2 * size_);
  tape_.evaluate(t, symbols.data(), p.data(), workspace.data(), out.data());
  std::copy_n(out.begin(), size_, values);
  std::copy_n(out.begin() + static_cast<std::ptrdiff_t>(size_), size_, rates);
}

}  // namespace graze::equations
