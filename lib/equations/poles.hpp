// SPDX-License-Identifier: GPL-3.0-or-later
// Quotients whose divisor may pass through zero during a motion. Where a bounded function (max, min, sign, step, atan, tanh)
// takes such a quotient, the motion is finite at the pole, but the function jumps. nonsmooth.hpp makes an event of it. Internal.
#pragma once

#include <graze/lib/equations/polynomial.hpp>

namespace graze::equations {

/// atan, atan2 and tanh: smooth functions that are finite, and jump, at a pole of an operand.
bool jumps_at_poles(Operation operation);

/// numerator / divisor^power. tan(a) is sin(a)/cos(a).
struct Quotient {
  Expression numerator, divisor;
  int power = 1;
};
/// e as a quotient, if it is one whose divisor depends on the motion and may change its sign: a divisor that bounds keep from
/// zero, or that is an even power, has no such pole.
std::optional<Quotient> as_quotient(Graph& graph, Expression e, const std::vector<ParameterInfo>& parameters);

/// The divisors of all quotients in the roots, each once up to its sign. Not `inside_bounded`: without those in atan, atan2 and
/// tanh.
std::vector<Expression> vanishing_divisors(Graph& graph, std::span<const Expression> roots,
                                           const std::vector<ParameterInfo>& parameters, bool inside_bounded);

/// 1: both are equal; -1: one is the negative of the other; 0: neither.
int same_up_to_sign(Graph& graph, Expression a, Expression b);

/// A divisor and its sign, 1 or -1.
struct SignedDivisor {
  Expression divisor;
  int sign = 1;
};
/// e = numerator / denominator, with the product of powers of the absolute values of the divisors as denominator, so that nothing
/// in the numerator's sums, products and quotients is divided by them: it has the sign of e and is finite where they vanish. A
/// divisor may contain quotients by the earlier ones.
struct RegularFraction {
  Expression numerator, denominator;
};
RegularFraction without_quotients(Graph& graph, Expression e, const std::vector<SignedDivisor>& divisors,
                                  const std::vector<ParameterInfo>& parameters);

}  // namespace graze::equations
