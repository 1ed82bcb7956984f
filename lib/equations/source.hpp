// SPDX-License-Identifier: GPL-3.0-or-later
// Where a text stands in its file, and the one error of everything that reads equations.
//
// Lines and columns are counted from 1, columns in characters (UTF-8 code points), not bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace graze::equations {

/// A file that was read: its name as messages show it, and its whole text.
struct Source {
  std::string file;
  std::string text;
};

/// A stretch of characters on one line; line 0: the place is not known.
struct Place {
  std::size_t line = 0;
  std::size_t column = 0;
  std::size_t length = 0;
};

/// A piece of text that stands in a source, verbatim, from `place` on. It may span lines.
struct Text {
  std::string text;
  Place place = {};
};

/// Finds places in a text, each in the time of a look-up. The text must outlive it.
class Places {
 public:
  explicit Places(const Text& text);
  /// The place of `length` bytes that begin at byte `offset`; it ends with the line at the latest.
  Place operator()(std::size_t offset, std::size_t length) const;

 private:
  const Text& text_;
  std::vector<std::size_t> lines_;         // the bytes at which lines begin
  std::vector<std::uint32_t> characters_;  // before each byte
};

/// A string of a TOML file whose opening quotes stand at `quote`: its content begins behind them (behind the first line break
/// of a multi-line string). `value` is the string's value.
Text quoted_text(const Source& source, const Place& quote, std::string value);

/// The number of characters of valid UTF-8; each byte that is part of none counts as one.
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
