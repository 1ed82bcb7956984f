// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/text/json_layout.hpp>

#include <algorithm>

namespace graze::apps {

namespace {

class Layout {
 public:
  Layout(std::string_view flat, std::string& out) : flat_(flat), out_(out) {}

  /// Lays out the next value.
  void value(std::size_t indent) {
    const char first = flat_[at_];
    if (first != '[' && first != '{') {
      const std::size_t end = first == '"' ? behind_text(at_) : flat_.find_first_of(",]}", at_);
      return take(std::min(end, flat_.size()) - at_);
    }
    const char last = first == '[' ? ']' : '}';
    if (flat_[at_ + 1] == last) return take(2);
    // Arrays of numbers stay on one line, however long: a list of 5 multipliers is read as one item.
    std::size_t end = first == '[' ? behind_scalars(at_) : none;
    if (end == none && indent > 0 && indent < json_line_width) end = behind_bracket(at_, json_line_width - indent);
    if (end != none) return take(end - at_);
    take(1);
    while (flat_[at_] != last) {
      out_.append(1, '\n').append(indent + 2, ' ');
      if (first == '{') {
        take(behind_text(at_) + 1 - at_);
        out_ += ' ';
      }
      value(indent + 2);
      if (flat_[at_] == ',') take(1);
    }
    out_.append(1, '\n').append(indent, ' ');
    take(1);
  }

 private:
  static constexpr std::size_t none = std::string_view::npos;

  void take(std::size_t size) {
    out_.append(flat_, at_, size);
    at_ += size;
  }
  /// The position after a quoted text that begins at `at`.
  std::size_t behind_text(std::size_t at) const {
    for (++at; flat_[at] != '"'; ++at)
      if (flat_[at] == '\\') ++at;
    return at + 1;
  }
  /// The position after an array of scalars; none: it contains arrays or objects.
  std::size_t behind_scalars(std::size_t at) const {
    for (++at; flat_[at] != ']';) {
      if (flat_[at] == '[' || flat_[at] == '{') return none;
      at = flat_[at] == '"' ? behind_text(at) : at + 1;
    }
    return at + 1;
  }
  /// The position after an array or an object; none: it is longer than `longest`.
  std::size_t behind_bracket(std::size_t at, std::size_t longest) const {
    const std::size_t end = std::min(flat_.size(), at + longest);
    for (std::size_t open = 0; at < end;) {
      const char c = flat_[at];
      at = c == '"' ? behind_text(at) : at + 1;
      if (c == '[' || c == '{') ++open;
      if ((c == ']' || c == '}') && --open == 0) return at;
    }
    return none;
  }

  std::string_view flat_;
  std::string& out_;
  std::size_t at_ = 0;
};

}  // namespace

void lay_out(std::string_view flat, std::size_t indent, std::string& out) { Layout(flat, out).value(indent); }

}  // namespace graze::apps
