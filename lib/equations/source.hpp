// SPDX-License-Identifier: GPL-3.0-or-later
// Places of texts in their file, and EquationError, the error type of all code that reads equations.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace graze::equations {

/// A file: its name for messages, and its whole text.
struct Source {
  std::string file;
  std::string text;
};

/// A range of characters on one line; line 0: unknown place.
struct Place {
  std::size_t line = 0;
  std::size_t column = 0;
  std::size_t length = 0;
};

/// A verbatim part of a source that begins at `place`. It may span lines.
struct Text {
  std::string text;
  Place place = {};
};

/// Finds places in a text, each by a binary search of the lines. The text must outlive it.
class Places {
 public:
  explicit Places(const Text& text);
  /// The place of `length` bytes from byte `offset` on; it ends with the line at the latest.
  Place operator()(std::size_t offset, std::size_t length) const;

 private:
  const Text& text_;
  std::vector<std::size_t> lines_;         // first byte of each line
  std::vector<std::uint32_t> characters_;  // number of characters before each byte
};

/// A string of a TOML file with its opening quotes at `quote`: the content begins after them (after the first line break of a
/// multi-line string). `value` is the string's value.
Text quoted_text(const Source& source, const Place& quote, std::string value);

/// The number of characters of a UTF-8 text: continuation bytes do not count.
std::size_t characters(std::string_view text);

/// A mistake in a text. what() is "FILE:LINE:COLUMN: message", the line of the source, and a caret line under the place.
class EquationError : public std::invalid_argument {
 public:
  EquationError(const Source& source, const Place& place, const std::string& message);
  /// "FILE:LINE:COLUMN: message" alone.
  const std::string& sentence() const { return sentence_; }
  const Place& place() const { return place_; }

 private:
  std::string sentence_;
  Place place_;
};

}  // namespace graze::equations
