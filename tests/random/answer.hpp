// SPDX-License-Identifier: GPL-3.0-or-later
// The answer of the program as plain data: the checked part of graze.branch/1.
#pragma once

#include <array>
#include <complex>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace graze::reference {

using State = std::vector<double>;

struct AnswerPoint {
  double value = 0.0;
  std::vector<State> states;  ///< at phase 0 after 0 ... n - 1 periods
  int impacts = 0;
  bool sticking = false;
  std::vector<std::complex<double>> multipliers;  ///< empty: not given
  std::optional<bool> stable;
};

struct AnswerSpecial {
  std::string label, type, status;
  double value = 0.0, precision = 0.0;
  std::array<double, 2> interval{};
  int after_point = 0, period = 0, impacts = 0;
  std::vector<State> states;
  std::vector<std::complex<double>> multipliers;
  std::string kind, scenario, criticality;  ///< empty: not given
  std::array<int, 2> change{};              ///< impacts before and after a grazing
};

struct AnswerBranch {
  int id = 0, parent = 0;  ///< parent 0: none
  std::string parent_label;
  int period = 0;
  std::string stop;
  double stop_value = 0.0;
  std::vector<AnswerPoint> points;
  std::vector<AnswerSpecial> special_points;
};

struct Answer {
  std::string failure;       ///< reason if there is no answer; otherwise empty
  bool interrupted = false;  ///< its time was used up
  std::vector<AnswerBranch> branches;
};

/// Reads the JSON of the program.
Answer parse_answer(const std::string& json);

}  // namespace graze::reference
