// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures that are drawn in parallel.
#include "graze_program.hpp"

#include <graze/apps/drawing/draw_files.hpp>

#include <catch2/catch.hpp>

#include <filesystem>
#include <sstream>
#include <stdexcept>

using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

Picture picture_named(const std::string& title) {
  Picture picture;
  picture.title = title;
  picture.curves.push_back({.title = "a", .points = {{0.0, 1.0, 0.0}, {1.0, 2.0, 0.0}}});
  return picture;
}

}  // namespace

TEST_CASE("pictures drawn in parallel equal those drawn alone and a failure affects no other") {
  for (const int threads : {1, 3}) {
    const TemporaryFolder folder;
    std::vector<Drawing> drawings;
    for (const char* name : {"one", "two", "three"})
      drawings.push_back({folder.file(name + std::string(".svg")), [name] { return picture_named(name); }});
    drawings.insert(drawings.begin() + 1,
                    {folder.file("none.svg"), []() -> Picture { throw std::invalid_argument("there is nothing to see"); }});
    drawings.push_back({folder.file("nowhere/four.svg"), [] { return picture_named("four"); }});
    std::vector<std::string> complaints;
    std::ostringstream out, err;
    CHECK(draw_into_files(drawings, {out, err, false, threads},
                          [&](const std::string& sentence) { complaints.push_back(sentence); }));
    REQUIRE(complaints.size() == 2);
    CHECK(complaints[0] == folder.file("none.svg") + ": there is nothing to see");
    CHECK_THAT(complaints[1], StartsWith(folder.file("nowhere/four.svg")) && Contains("cannot be written"));
    CHECK(folder.files() == 3);
    for (const char* name : {"one", "two", "three"})
      CHECK(read_file(folder.file(name + std::string(".svg"))) == draw(picture_named(name), "svg"));
  }
}

TEST_CASE("an empty list of pictures is drawn at once") {
  std::ostringstream out, err;
  CHECK(draw_into_files({}, {out, err, false, 2}, [](const std::string& sentence) { FAIL(sentence); }));
}
