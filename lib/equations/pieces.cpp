// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/names.hpp>
#include <graze/lib/equations/pieces.hpp>

#include <fmt/format.h>

namespace graze::equations {

std::size_t mode_number(const Names& names, const Pieces& pieces, const Text& name, const std::string& who) {
  std::vector<std::string> known;
  for (std::size_t i = 0; i < pieces.modes.size(); ++i) {
    if (pieces.modes[i].name == name.text) return i;
    known.push_back(pieces.modes[i].name);
  }
  names.refuse(name.place, fmt::format("{} names an unknown mode '{}'{}", who, name.text, suggestion_or_list(name.text, known)));
}

}  // namespace graze::equations
