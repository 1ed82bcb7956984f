// SPDX-License-Identifier: GPL-3.0-or-later
// JSON as the program writes it: numbers read back to the same double; NaN and infinities are null; a state is [x, v]; a complex
// number is [re, im].
#pragma once

#include <graze/apps/text/long_text.hpp>
#include <graze/lib/numerics/vector.hpp>

#include <nlohmann/json.hpp>

#include <complex>
#include <functional>
#include <string>
#include <vector>

namespace graze::apps {

using Json = nlohmann::ordered_json;

Json to_json(const Vector& vector);
Vector vector_from(const Json& json);  ///< the inverse
Json to_json(const std::vector<Vector>& vectors);
Json to_json(const std::vector<std::complex<double>>& values);

/// A member of a result that is a list of objects, too long to be kept as JSON, too: the result has null in its place.
struct LongList {
  std::string name;  ///< of the member; empty: there is none
  std::size_t size = 0;
  /// Appends the item's text, as Json::dump() writes it. Called by several threads.
  std::function<void(std::size_t, std::string&)> item = {};
};

/// Room for so many members: an object that grows copies all that it has.
void reserve_members(Json& object, std::size_t count);

/// On one line, without blanks. Of a text that is not UTF-8 (names of files need not be) each wrong byte becomes U+FFFD.
std::string flat(const Json& json);
bool is_utf8(const std::string& text);

/// Indented; what fits stands on one line.
std::string pretty(const Json& json);
/// With the items of the list. The text of long lists is made on so many threads.
void pretty(const Json& json, const LongList& list, int threads, const TextSink& sink);

/// The whole as JSON.
Json with_items(const Json& json, const LongList& list, int threads);

/// What an exception of the JSON library says, without its number.
std::string plain(const Json::exception& error);

/// Of a result: "graze.orbit/1" and the like; empty where it says none.
std::string schema_of(const Json& result);

}  // namespace graze::apps
