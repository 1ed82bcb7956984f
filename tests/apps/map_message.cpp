// SPDX-License-Identifier: GPL-3.0-or-later
// Messages between the ranks of a map: each message is read back, and invalid ones are refused.
#include <graze/apps/map/map_message.hpp>

#include <catch2/catch.hpp>

#include <string>

using namespace graze::apps;

TEST_CASE("messages of a map are read back") {
  CHECK(map_message('C', 42) == "C00000042");
  const std::string bytes("12\0x", 4);
  const auto done = map_message('D', 7, bytes), plan = map_message('P', "{}"), failed = map_message('F', "no memory");
  const auto read = message_from(done);
  REQUIRE(read);
  CHECK(read->letter == 'D');
  CHECK(read->number == 7);
  CHECK(read->rest == bytes);
  CHECK(message_from(plan)->rest == "{}");
  CHECK(message_from(failed)->rest == "no memory");
  for (const std::string letter : {"N", "E", "W", "H", "B"}) {
    REQUIRE(message_from(letter));
    CHECK(message_from(letter)->letter == letter[0]);
  }
}

TEST_CASE("an invalid message of a map is refused") {
  for (const std::string wrong :
       {"", "X", "E1", "C", "C1", "C0000001", "C-0000001", "C-0000000", "C+0000001", "C 0000001", "Done", "D0000000x"}) {
    INFO(wrong);
    CHECK_FALSE(message_from(wrong));
  }
}
