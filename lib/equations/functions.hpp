// SPDX-License-Identifier: GPL-3.0-or-later
// Expressions as the functions of (t, x, p) of a HybridSystem, with their derivatives. Each function runs a tape on a workspace
// of the calling thread.
#pragma once

#include <graze/lib/equations/tape.hpp>
#include <graze/lib/system/hybrid_system.hpp>

namespace graze::equations {

VectorFunction vector_function(const Graph& graph, const std::vector<Expression>& f);
ScalarFunction scalar_function(const Graph& graph, Expression f);
/// df/dx, df/dp: rows are the entries of f. df/dp may be empty: zero.
MatrixFunction derivative_in_states(Graph& graph, const std::vector<Expression>& f);
MatrixFunction derivative_in_parameters(Graph& graph, const std::vector<Expression>& f);
/// df/dt; empty: zero.
VectorFunction derivative_in_time(Graph& graph, const std::vector<Expression>& f);
/// Gradients of a scalar; those in p and t may be empty: zero.
VectorFunction gradient_in_states(Graph& graph, Expression f);
VectorFunction gradient_in_parameters(Graph& graph, Expression f);
ScalarFunction scalar_derivative_in_time(Graph& graph, Expression f);

/// Values of several expressions at one point.
std::vector<double> values(const Graph& graph, std::span<const Expression> of, double t, const Vector& x, const Vector& p);

}  // namespace graze::equations
