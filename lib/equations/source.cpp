// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/source.hpp>

#include <fmt/format.h>

#include <algorithm>

namespace graze::equations {

namespace {

/// Of a longer line only the part around the place is shown.
constexpr std::size_t widest_line = 120;

bool continues_character(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

/// The byte at which character number `index` begins; the size of the text if it has fewer.
std::size_t byte_of(std::string_view text, std::size_t index) {
  std::size_t byte = 0;
  for (; byte < text.size(); ++byte)
    if (!continues_character(text[byte]) && index-- == 0) break;
  return byte;
}

std::string_view line_of(std::string_view text, std::size_t number) {
  for (; number > 1; --number) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return {};
    text.remove_prefix(end + 1);
  }
  text = text.substr(0, text.find('\n'));
  return text.ends_with('\r') ? text.substr(0, text.size() - 1) : text;
}

/// The text with a question mark for each control character, which would act on the terminal or end the message.
std::string printable(std::string_view text) {
  std::string out(text);
  std::replace_if(
      out.begin(), out.end(), [](char c) { return (c >= 0 && c < ' ' && c != '\t') || c == '\x7f'; }, '?');
  return out;
}

std::string make_sentence(const Source& source, const Place& place, const std::string& message) {
  if (place.line == 0) return fmt::format("{}: {}", source.file, message);
  return fmt::format("{}:{}:{}: {}", source.file, place.line, place.column, message);
}

std::string make_report(const Source& source, const Place& place, const std::string& message) {
  std::string out = make_sentence(source, place, message);
  if (place.line == 0) return out;
  std::string_view line = line_of(source.text, place.line);
  const std::size_t all = characters(line);
  const std::size_t at = std::min(std::max<std::size_t>(place.column, 1) - 1, all);
  std::size_t first = 0;
  std::string_view before, after;
  if (all > widest_line) {
    first = std::min(at > widest_line / 2 ? at - widest_line / 2 : 0, all - widest_line);
    if (first > 0) before = "...";
    if (first + widest_line < all) after = "...";
    line.remove_prefix(byte_of(line, first));
    line = line.substr(0, byte_of(line, widest_line));
  }
  out += fmt::format("\n{}{}{}\n{}", before, printable(line), after, std::string(before.size(), ' '));
  const std::string_view ahead = line.substr(0, byte_of(line, at - first));
  for (const char c : ahead)
    if (!continues_character(c)) out += c == '\t' ? '\t' : ' ';
  const std::size_t room = std::max<std::size_t>(characters(line) - (at - first), 1);
  out += std::string(std::clamp<std::size_t>(place.length, 1, room), '^');
  return out;
}

}  // namespace

std::size_t characters(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return !continues_character(c); }));
}

Places::Places(const Text& text) : text_(text), lines_{0} {
  characters_.reserve(text.text.size() + 1);
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < text.text.size(); ++i) {
    characters_.push_back(count);
    if (!continues_character(text.text[i])) ++count;
    if (text.text[i] == '\n') lines_.push_back(i + 1);
  }
  characters_.push_back(count);
}

Place Places::operator()(std::size_t offset, std::size_t length) const {
  if (text_.place.line == 0) return {};
  offset = std::min(offset, text_.text.size());
  const auto next = std::upper_bound(lines_.begin(), lines_.end(), offset);
  const auto line = static_cast<std::size_t>(next - lines_.begin()) - 1;
  const std::size_t end_of_line = next == lines_.end() ? text_.text.size() : *next - 1;
  const std::size_t end = std::min(offset + length, end_of_line);
  const std::size_t before = characters_[offset] - characters_[lines_[line]];
  const std::size_t wide = end > offset ? characters_[end] - characters_[offset] : 0;
  return {text_.place.line + line, (line == 0 ? text_.place.column : 1) + before, std::max<std::size_t>(1, wide)};
}

Text quoted_text(const Source& source, const Place& quote, std::string value) {
  Text text{std::move(value), quote};
  const std::string_view line = line_of(source.text, quote.line);
  const std::string_view rest = line.substr(byte_of(line, std::max<std::size_t>(quote.column, 1) - 1));
  if (rest.starts_with("\"\"\"") || rest.starts_with("'''")) {
    if (rest.size() == 3) {
      text.place = {quote.line + 1, 1, 0};
    } else {
      text.place.column += 3;
    }
  } else if (rest.starts_with('"') || rest.starts_with('\'')) {
    text.place.column += 1;
  }
  const std::string_view written = text.text;
  text.place.length = characters(written.substr(0, written.find('\n')));
  return text;
}

EquationError::EquationError(const Source& source, const Place& place, const std::string& message)
    : std::invalid_argument(make_report(source, place, message)), sentence_(make_sentence(source, place, message)),
      place_(place) {}

}  // namespace graze::equations
