// SPDX-License-Identifier: GPL-3.0-or-later
// ContactLaw: the door where a new law enters. A law says what it is called, which parameters it has, and attaches its
// modes and events to a free oscillator x'' + 2 b x' + x + beta x^3 = xi cos(eta t) with a barrier at x = r.
//
// To add a law: one file in lib/contact/ and one line in contact_laws(). Its derivative checks, its name on the command
// line and its help come from that list.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace graze {

struct ContactLaw {
  std::string name;                       ///< as in problem files, for example "hertz"
  std::string formula;                    ///< one line
  bool hard = false;                      ///< true: x <= r always
  std::vector<ParameterInfo> parameters;  ///< its own, beside the oscillator's
  /// Adds modes, events and initial_mode to a system that holds the oscillator's parameters, the law's, and one mode, "free".
  void (*attach)(HybridSystem& free_system) = nullptr;
};

/// All laws, in the order in which they are listed to users.
const std::vector<ContactLaw>& contact_laws();

/// The law called `name`. @throws std::invalid_argument with the nearest valid name.
const ContactLaw& contact_law(std::string_view name);

}  // namespace graze
