// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/signature.hpp>

#include <fmt/format.h>

namespace graze {

int impacts(const HybridSystem& system, const Signature& signature) { return contacts_among(signature.events, system); }

std::optional<std::size_t> first_break(const HybridSystem& system, const std::vector<std::size_t>& events) {
  for (std::size_t k = 0; k < events.size(); ++k)
    if (system.events[events[k]].to != system.events[events[(k + 1) % events.size()]].from) return k;
  return std::nullopt;
}

std::string label(int impacts, int period) { return fmt::format("{}/{}", impacts, period); }

std::string label(int impacts, int isolated, int period) {
  if (isolated >= impacts) return label(impacts, period);
  return isolated > 0 ? fmt::format("{}+∞/{}", isolated, period) : fmt::format("∞/{}", period);
}

}  // namespace graze
