// SPDX-License-Identifier: GPL-3.0-or-later
// MotionFunctions: expressions of a motion (states, their rates x', parameters, time) with their exact rates of change along
// it.
//
// They are independent of the modes: x' is the value of the current field of the motion. With the symbols x_0 ... x_{n-1} for
// the states, x_{n+i} for x_i' and x_{2n+i} for x_i'',
//     dE/dt = E_t + sum over i < 2n of E_{x_i} x_{n+i},        x'' = f_t + f_x f.
//
// abs, sign, max, min and step change their branch where an argument changes its sign. With the signs of all arguments given,
// each expression is smooth; its values and those of the arguments continue smoothly beyond the sign change.
#pragma once

#include <graze/lib/equations/tape.hpp>
#include <graze/lib/system/hybrid_system.hpp>

#include <memory>

namespace graze::equations {

class MotionFunctions {
 public:
  MotionFunctions() = default;
  /// `states`: number of states of the system. @throws std::invalid_argument for a rate of a rate.
  MotionFunctions(Graph& graph, const std::vector<Expression>& of, std::size_t states);

  std::size_t size() const { return size_; }
  /// Writes size() values and their rates of change at a state in a mode of the system.
  void evaluate(const HybridSystem& system, std::size_t mode, double t, const Vector& x, const Vector& p, double* values,
                double* rates) const;

  /// Number of arguments of abs, sign, max, min and step (a - b for max and min). Functions within an argument have their own
  /// arguments earlier in the list.
  std::size_t arguments() const { return arguments_; }
  /// Writes size() + arguments() values and rates, those of the functions first, on the branches given by the signs of the
  /// arguments. Each sign is 1, -1, or 0 if the argument vanishes throughout a stretch.
  void evaluate(const HybridSystem& system, std::size_t mode, double t, const Vector& x, const Vector& p,
                const std::vector<int>& signs, double* values, double* rates) const;

 private:
  /// Fills the symbols and evaluates the tape; `signs` may be null.
  void run(const Tape& tape, const HybridSystem& system, std::size_t mode, double t, const Vector& x, const Vector& p,
           const std::vector<int>* signs, double* values, double* rates) const;

  std::size_t size_ = 0, arguments_ = 0;
  bool second_rates_ = false;  ///< x'' occurs
  Tape tape_;                  ///< the values, then the rates
  Tape on_branches_;           ///< the same and those of the arguments, with two symbols x_{3n+2i}, x_{3n+2i+1} for each sign
};

}  // namespace graze::equations
