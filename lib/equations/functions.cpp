// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/functions.hpp>

#include <memory>

namespace graze::equations {

namespace {

/// Evaluates the tape and returns the workspace, from which Tape::output reads the outputs.
const double* run(const Tape& tape, double t, const Vector& x, const Vector& p) {
  thread_local std::vector<double> scratch;
  if (scratch.size() < tape.workspace()) scratch.resize(tape.workspace());
  for (const Tape::Part part : {Tape::of_parameters, Tape::of_time, Tape::of_states})
    tape.run(part, t, x.data(), p.data(), scratch.data());
  return scratch.data();
}

/// The nonzero derivatives, with their places in a matrix.
struct Sparse {
  std::shared_ptr<const Tape> tape;
  std::vector<std::pair<Eigen::Index, Eigen::Index>> places;
};

template <class SymbolsOf, class Make>
Sparse sparse(Graph& graph, const std::vector<Expression>& f, const SymbolsOf& symbols_of, const Make& make) {
  Sparse out;
  std::vector<Expression> entries;
  const Expression zero = graph.constant(0.0);
  for (std::size_t row = 0; row < f.size(); ++row) {
    for (const std::size_t column : symbols_of(dependence(graph, f[row]))) {
      const Expression entry = graph.derivative(f[row], make(column));
      if (entry == zero) continue;
      entries.push_back(entry);
      out.places.emplace_back(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column));
    }
  }
  out.tape = std::make_shared<const Tape>(graph, entries);
  return out;
}

Sparse in_states(Graph& graph, const std::vector<Expression>& f) {
  return sparse(
      graph, f, [](const Dependence& on) { return on.states; }, [&](std::size_t i) { return graph.state(i); });
}
Sparse in_parameters(Graph& graph, const std::vector<Expression>& f) {
  return sparse(
      graph, f, [](const Dependence& on) { return on.parameters; }, [&](std::size_t i) { return graph.parameter(i); });
}
Sparse in_time(Graph& graph, const std::vector<Expression>& f) {
  return sparse(
      graph, f, [](const Dependence& on) { return std::vector<std::size_t>(on.time ? 1 : 0, 0); },
      [&](std::size_t) { return graph.time(); });
}

MatrixFunction matrix(const Sparse& sparse) {
  return [sparse](double t, const Vector& x, const Vector& p, Matrix& out) {
    const double* values = run(*sparse.tape, t, x, p);
    out.setZero();
    for (std::size_t i = 0; i < sparse.places.size(); ++i)
      out(sparse.places[i].first, sparse.places[i].second) = sparse.tape->output(i, values);
  };
}

/// The only row of the matrix (`row`), or its only column.
VectorFunction line(const Sparse& sparse, bool row) {
  return [sparse, row](double t, const Vector& x, const Vector& p, Vector& out) {
    const double* values = run(*sparse.tape, t, x, p);
    out.setZero();
    for (std::size_t i = 0; i < sparse.places.size(); ++i)
      out[row ? sparse.places[i].second : sparse.places[i].first] = sparse.tape->output(i, values);
  };
}

}  // namespace

VectorFunction vector_function(const Graph& graph, const std::vector<Expression>& f) {
  const auto tape = std::make_shared<const Tape>(graph, f);
  return [tape](double t, const Vector& x, const Vector& p, Vector& out) {
    const double* values = run(*tape, t, x, p);
    for (std::size_t i = 0; i < tape->outputs(); ++i) out[static_cast<Eigen::Index>(i)] = tape->output(i, values);
  };
}

ScalarFunction scalar_function(const Graph& graph, Expression f) {
  const auto tape = std::make_shared<const Tape>(graph, std::span(&f, 1));
  return [tape](double t, const Vector& x, const Vector& p) { return tape->output(0, run(*tape, t, x, p)); };
}

MatrixFunction derivative_in_states(Graph& graph, const std::vector<Expression>& f) { return matrix(in_states(graph, f)); }

MatrixFunction derivative_in_parameters(Graph& graph, const std::vector<Expression>& f) {
  const Sparse entries = in_parameters(graph, f);
  return entries.places.empty() ? MatrixFunction{} : matrix(entries);
}

VectorFunction derivative_in_time(Graph& graph, const std::vector<Expression>& f) {
  const Sparse entries = in_time(graph, f);
  return entries.places.empty() ? VectorFunction{} : line(entries, false);
}

VectorFunction gradient_in_states(Graph& graph, Expression f) { return line(in_states(graph, {f}), true); }

VectorFunction gradient_in_parameters(Graph& graph, Expression f) {
  const Sparse entries = in_parameters(graph, {f});
  return entries.places.empty() ? VectorFunction{} : line(entries, true);
}

ScalarFunction scalar_derivative_in_time(Graph& graph, Expression f) {
  const Expression dt = graph.derivative(f, graph.time());
  return graph.is_constant(dt, 0.0) ? ScalarFunction{} : scalar_function(graph, dt);
}

std::vector<double> values(const Graph& graph, std::span<const Expression> of, double t, const Vector& x, const Vector& p) {
  const Tape tape(graph, of);
  const double* all = run(tape, t, x, p);
  std::vector<double> out(of.size());
  for (std::size_t i = 0; i < of.size(); ++i) out[i] = tape.output(i, all);
  return out;
}

}  // namespace graze::equations
