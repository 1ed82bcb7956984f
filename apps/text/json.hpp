// SPDX-License-Identifier: GPL-3.0-or-later
// JSON as the program writes it: numbers read back to the same double; NaN and infinities are null; a state is [x, v]; a
// complex number is [re, im].
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

/// A member of a result that is a list of objects, too long to be kept as JSON as well. The result has null in its place.
struct LongList {
  std::string name;  ///< of the member; empty: there is no such list
  std::size_t size = 0;
  /// Appends the text of one item, as Json::dump() writes it. Called by several threads.
  std::function<void(std::size_t, std::string&)> item = {};
};

/// Reserves room for `count` members: an object that grows copies all its members.
void reserve_members(Json& object, std::size_t count);

/// On one line, without blanks. In a text that is not UTF-8 (file names need not be), each invalid byte becomes U+FFFD.
std::string flat(const Json& json);
bool is_utf8(const std::string& text);

/// Indented; a value that fits stands on one line.
std::string pretty(const Json& json);
/// The same with the items of the list. The text of long lists is produced on `threads` threads.
void pretty(const Json& json, const LongList& list, int threads, const TextSink& sink);

/// The whole result as one JSON value.
Json with_items(const Json& json, const LongList& list, int threads);

/// The message of an exception of the JSON library, without its number.
std::string plain(const Json::exception& error);

/// The schema of a result, such as "graze.orbit/1"; empty if the result does not name one.
std::string schema_of(const Json& result);

}  // namespace graze::apps
