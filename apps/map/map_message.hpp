// SPDX-License-Identifier: GPL-3.0-or-later
// MapMessage: a message between the ranks of a parameter map. It consists of a letter, the number of a chunk in eight digits
// (only C and D), and bytes.
//     from rank 0:  P the plan;  C compute this chunk;  N no more chunks;  E end
//     to rank 0:    W wants a chunk;  D finished chunk;  H still alive;  F failed, with the reason;  B goodbye (last message)
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace graze::apps {

struct MapMessage {
  char letter = 0;
  int number = -1;        ///< of the chunk, for C and D
  std::string_view rest;  ///< the plan, the bytes of a chunk, or the reason of a failure; a view of the parsed text
};

std::string map_message(char letter, std::string_view rest = {});
std::string map_message(char letter, int number, std::string_view rest = {});

/// Parses a message. nullopt: the text is not a message.
std::optional<MapMessage> message_from(std::string_view text);

}  // namespace graze::apps
