// SPDX-License-Identifier: GPL-3.0-or-later
// Tape: several expressions as one straight-line program on a number type (double, long double, or a SIMD pack).
//
// Common parts are computed once, unused parts are omitted, integer powers are products, and sine and cosine of the same
// argument are computed together. The program has three parts: instructions that depend on p only, on (t, p), and also on x. A
// caller that evaluates it many times at the same p (or t) may run the earlier parts once. A Tape is constant; the numbers are
// in a workspace of the caller, so that any number of threads may share one tape.
#pragma once

#include <graze/lib/equations/expression.hpp>

#include <array>
#include <cmath>
#include <numbers>

namespace graze::equations {

class Tape {
 public:
  enum Part : std::size_t { of_parameters, of_time, of_states, parts };

  Tape() = default;
  /// The graph may be changed or destroyed afterwards. @throws std::invalid_argument if a rate is left in an output.
  Tape(const Graph& graph, std::span<const Expression> outputs);

  std::size_t outputs() const { return outputs_.size(); }
  /// Size of the workspace, in numbers.
  std::size_t workspace() const { return leaves_.size() + instructions_.size(); }
  /// Number of instructions of one part.
  std::size_t length(Part part) const { return begin_[part + 1] - begin_[part]; }

  /// Evaluates one part; the workspace must contain the results of the earlier parts.
  template <class Number> void run(Part part, Number t, const Number* x, const Number* p, Number* workspace) const;
  template <class Number> const Number& output(std::size_t i, const Number* workspace) const { return workspace[outputs_[i]]; }

  /// Evaluates all parts and writes outputs() numbers.
  template <class Number> void evaluate(Number t, const Number* x, const Number* p, Number* workspace, Number* out) const {
    for (const Part part : {of_parameters, of_time, of_states}) run(part, t, x, p, workspace);
    for (std::size_t i = 0; i < outputs_.size(); ++i) out[i] = workspace[outputs_[i]];
  }

 private:
  struct Instruction {
    Operation operation = Operation::constant;
    bool with_cosine = false;  ///< a sine whose cosine is stored in the next number
    std::uint32_t a = 0, b = 0, index = 0;
    double value = 0.0;
  };
  /// A number copied into the workspace. Order: pi, constants, parameters, the time, states.
  struct Leaf {
    std::uint32_t index = 0;
    double value = 0.0;
  };
  std::vector<Leaf> leaves_;
  std::size_t constants_ = 0, parameters_ = 0, times_ = 0;  ///< end of each kind in `leaves_`
  bool has_pi_ = false;                                     ///< then pi is the first leaf
  std::vector<Instruction> instructions_;                   ///< their results follow the leaves
  std::array<std::size_t, parts + 1> begin_{};
  std::vector<std::uint32_t> outputs_;
  std::vector<Spline> splines_;
};

/// a^n by products; n of any sign.
template <class Number> Number integer_power(Number a, int n) {
  if (n < 0) return Number(1) / integer_power(a, -n);
  Number result = n % 2 == 1 ? a : Number(1);
  bool is_one = n % 2 == 0;
  for (n /= 2; n > 0; n /= 2) {
    a = a * a;
    if (n % 2 == 0) continue;
    result = is_one ? a : result * a;
    is_one = false;
  }
  return result;
}

/// max(a, 0)^e. The exponents of contact laws are half integers: a root and products.
template <class Number> Number contact_power(Number a, double e) {
  using std::pow;
  using std::sqrt;
  if (!(a > Number(0))) return Number(0);
  const double twice = 2.0 * e;
  if (twice == std::nearbyint(twice) && twice > 0.0 && twice <= 9.0)
    return integer_power(Number(sqrt(a)), static_cast<int>(twice));
  return pow(a, Number(e));
}

template <class Number> void Tape::run(Part part, Number t, const Number* x, const Number* p, Number* workspace) const {
  using std::abs, std::acos, std::asin, std::atan, std::atan2, std::cos, std::cosh, std::exp, std::hypot, std::log, std::pow,
      std::sin, std::sinh, std::sqrt, std::tan, std::tanh;
  if (part == of_parameters) {
    for (std::size_t i = 0; i < constants_; ++i) workspace[i] = Number(leaves_[i].value);
    if (has_pi_) workspace[0] = std::numbers::pi_v<Number>;
    for (std::size_t i = constants_; i < parameters_; ++i) workspace[i] = p[leaves_[i].index];
  } else if (part == of_time) {
    for (std::size_t i = parameters_; i < times_; ++i) workspace[i] = t;
  } else {
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): x is null only for expressions without states
    for (std::size_t i = times_; i < leaves_.size(); ++i) workspace[i] = x[leaves_[i].index];
  }
  Number* const results = workspace + leaves_.size();
  for (std::size_t i = begin_[part]; i < begin_[part + 1]; ++i) {
    const Instruction& q = instructions_[i];
    Number& out = results[i];
    switch (q.operation) {
    case Operation::add:
      out = workspace[q.a] + workspace[q.b];
      break;
    case Operation::subtract:
      out = workspace[q.a] - workspace[q.b];
      break;
    case Operation::multiply:
      out = workspace[q.a] * workspace[q.b];
      break;
    case Operation::divide:
      out = workspace[q.a] / workspace[q.b];
      break;
    case Operation::negate:
      out = -workspace[q.a];
      break;
    case Operation::integer_power:
      out = equations::integer_power(workspace[q.a], static_cast<int>(q.value));
      break;
    case Operation::power:
      out = pow(workspace[q.a], workspace[q.b]);
      break;
    case Operation::contact_power:
      out = equations::contact_power(workspace[q.a], q.value);
      break;
    case Operation::sin: {
      const Number a = workspace[q.a];
      out = sin(a);
      if (q.with_cosine) results[++i] = cos(a);
      break;
    }
    case Operation::cos:
      out = cos(workspace[q.a]);
      break;
    case Operation::tan:
      out = tan(workspace[q.a]);
      break;
    case Operation::asin:
      out = asin(workspace[q.a]);
      break;
    case Operation::acos:
      out = acos(workspace[q.a]);
      break;
    case Operation::atan:
      out = atan(workspace[q.a]);
      break;
    case Operation::atan2:
      out = atan2(workspace[q.a], workspace[q.b]);
      break;
    case Operation::sinh:
      out = sinh(workspace[q.a]);
      break;
    case Operation::cosh:
      out = cosh(workspace[q.a]);
      break;
    case Operation::tanh:
      out = tanh(workspace[q.a]);
      break;
    case Operation::exp:
      out = exp(workspace[q.a]);
      break;
    case Operation::log:
      out = log(workspace[q.a]);
      break;
    case Operation::sqrt:
      out = sqrt(workspace[q.a]);
      break;
    case Operation::hypot:
      out = hypot(workspace[q.a], workspace[q.b]);
      break;
    case Operation::spline:
      out = splines_[q.index].value(static_cast<int>(q.value), workspace[q.a]);
      break;
    case Operation::abs:
      out = abs(workspace[q.a]);
      break;
    case Operation::sign:
      out = workspace[q.a] > Number(0) ? Number(1) : workspace[q.a] < Number(0) ? Number(-1) : Number(0);
      break;
    case Operation::max:
      out = workspace[q.a] < workspace[q.b] ? workspace[q.b] : workspace[q.a];
      break;
    case Operation::min:
      out = workspace[q.b] < workspace[q.a] ? workspace[q.b] : workspace[q.a];
      break;
    case Operation::step:
      out = workspace[q.a] >= Number(0) ? Number(1) : Number(0);
      break;
    default:  // leaves
      break;
    }
  }
}

}  // namespace graze::equations
