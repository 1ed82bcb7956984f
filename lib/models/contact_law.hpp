// SPDX-License-Identifier: GPL-3.0-or-later
// ContactLaw: the law of the barrier at x = r of the built-in oscillators, as the stop of a system written as text.
//
// To add a law: one line in contact_laws(). Its derivative checks, its name on the command line and its help come from that list.
// A law that is in no list can be given to make_oscillator as it is.
#pragma once

#include <graze/lib/system/parameters.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace graze {

struct ContactLaw {
  std::string name;                       ///< as in problem files, for example "hertz"
  std::string formula;                    ///< one line
  bool hard = false;                      ///< true: x <= r always
  std::vector<ParameterInfo> parameters;  ///< its own, beside the oscillator's
  std::string stop;                       ///< StopText::law: "newton", "hertz", "linear" or "force"
  std::vector<std::string> values;        ///< StopText::values, expressions of all parameters
};

/// All laws, in the order in which they are listed to users.
const std::vector<ContactLaw>& contact_laws();

/// The law called `name`. @throws std::invalid_argument with the nearest valid name.
const ContactLaw& contact_law(std::string_view name);

}  // namespace graze
