// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/map/map_message.hpp>

#include <fmt/format.h>

namespace graze::apps {

namespace {

constexpr std::size_t digits = 8;  // of the number of a chunk

constexpr std::string_view unnumbered = "PF", numbered = "CD", single = "NEWHB";

}  // namespace

std::string map_message(char letter, std::string_view rest) { return fmt::format("{}{}", letter, rest); }

std::string map_message(char letter, int number, std::string_view rest) {
  return fmt::format("{}{:0{}}{}", letter, number, digits, rest);
}

std::optional<MapMessage> message_from(std::string_view text) {
  if (text.empty()) return std::nullopt;
  MapMessage message{text.front(), -1, text.substr(1)};
  if (unnumbered.find(message.letter) != std::string_view::npos) return message;
  if (single.find(message.letter) != std::string_view::npos) return message.rest.empty() ? std::optional(message) : std::nullopt;
  if (numbered.find(message.letter) == std::string_view::npos || message.rest.size() < digits) return std::nullopt;
  message.number = 0;
  for (const char c : message.rest.substr(0, digits)) {
    if (c < '0' || c > '9') return std::nullopt;
    message.number = 10 * message.number + (c - '0');
  }
  message.rest.remove_prefix(digits);
  return message;
}

}  // namespace graze::apps
