// SPDX-License-Identifier: GPL-3.0-or-later
// MapMessage: what the ranks of a parameter map tell each other: a letter, for a chunk its number in eight digits, and bytes.
// From rank 0: P the plan, C a chunk to compute, N no more of them, E end. To it: W wants a chunk to go on with, D a finished
// one, H still here, F failed, B bye (the last one).
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace graze::apps {

struct MapMessage {
  char letter = 0;
  int number = -1;        ///< of the chunk, for C and D
  std::string_view rest;  ///< the plan, a chunk's bytes, or why it failed; of the text that was read
};

std::string map_message(char letter, std::string_view rest = {});
std::string map_message(char letter, int number, std::string_view rest = {});

/// nullopt: the text is no message.
std::optional<MapMessage> message_from(std::string_view text);

}  // namespace graze::apps
