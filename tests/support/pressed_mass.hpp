// SPDX-License-Identifier: GPL-3.0-or-later
// Two coupled masses, x and y. The constant force P presses x to a rigid stop; A cos(w t) drives y.
#pragma once

#include "support/system_texts.hpp"

#include <string>

namespace graze::support {

inline SystemWriter pressed_to(const std::string& gap) {
  SystemWriter writer;
  writer.system.name = "pressed";
  writer.forcing("w").parameter("w", "0.8").parameter("A", "0.3").parameter("P", "2");
  writer.mechanics(
      {"x", "y"}, {"v", "u"},
      {{{"1", "0"}, {"0", "1"}}, {{"0.2", "-0.1"}, {"-0.1", "0.1"}}, {{"2", "-1"}, {"-1", "1"}}, {"P", "A*cos(w*t)"}});
  writer.stop("wall", gap, "newton", {"0.5"});
  return writer;
}

}  // namespace graze::support
