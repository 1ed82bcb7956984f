// SPDX-License-Identifier: GPL-3.0-or-later
// ContactLaw: the contact law at the barrier x = r of the built-in oscillators, as the stop of a system written as text.
//
// To add a law, add one line to contact_laws(). Its derivative checks, its name on the command line and its help follow from
// that list. A law outside the list can be passed to make_oscillator directly.
#pragma once

#include <graze/lib/system/parameters.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace graze {

struct ContactLaw {
  std::string name;                       ///< as in problem files, for example "hertz"
  std::string formula;                    ///< as one line of text
  bool hard = false;                      ///< true: x <= r always
  std::vector<ParameterInfo> parameters;  ///< of the law, in addition to the oscillator's
  std::string stop;                       ///< StopText::law: "newton", "hertz", "linear" or "force"
  std::vector<std::string> values;        ///< StopText::values, expressions of all parameters
};

/// All laws, in the order of listing.
const std::vector<ContactLaw>& contact_laws();

/// The law called `name`. @throws std::invalid_argument with the nearest valid name.
const ContactLaw& contact_law(std::string_view name);

}  // namespace graze
