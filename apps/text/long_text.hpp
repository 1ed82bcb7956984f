// SPDX-License-Identifier: GPL-3.0-or-later
// Long texts, passed on piece by piece while they are produced.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace graze::apps {

/// Receives the pieces of a text, one at a time and in order. An exception from the sink ends the production of the text.
using TextSink = std::function<void(std::string_view piece)>;
/// A text that passes its pieces to a sink.
using LongText = std::function<void(const TextSink& sink)>;

/// The whole text.
inline std::string whole_text(const LongText& text) {
  std::string all;
  text([&all](std::string_view piece) { all += piece; });
  return all;
}

}  // namespace graze::apps
