// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/json_layout.hpp>

#include <algorithm>
#include <vector>

namespace graze::apps {

namespace {

/// The place behind a text in quotes that begins at `at`.
std::size_t behind_text(std::string_view flat, std::size_t at) {
  for (++at; flat[at] != '"'; ++at)
    if (flat[at] == '\\') ++at;
  return at + 1;
}

/// An array or an object.
struct Bracket {
  std::size_t end = 0;   ///< where it closes
  std::size_t next = 0;  ///< number of the first that opens behind that
  bool nested = false;   ///< has others inside
};

/// In the order in which they open.
std::vector<Bracket> brackets_in(std::string_view flat) {
  std::vector<Bracket> list;
  std::vector<std::size_t> open;
  for (std::size_t at = 0; at < flat.size();) {
    switch (flat[at]) {
    case '"':
      at = behind_text(flat, at);
      continue;
    case '[':
    case '{':
      if (!open.empty()) list[open.back()].nested = true;
      open.push_back(list.size());
      list.emplace_back();
      break;
    case ']':
    case '}':
      list[open.back()].end = at;
      list[open.back()].next = list.size();
      open.pop_back();
      break;
    default:
      break;
    }
    ++at;
  }
  return list;
}

class Layout {
 public:
  Layout(std::string_view flat, std::string& out) : flat_(flat), out_(out), brackets_(brackets_in(flat)) {}

  /// The value that comes next.
  void value(std::size_t indent) {
    const char first = flat_[at_];
    if (first != '[' && first != '{') {
      const std::size_t end = first == '"' ? behind_text(flat_, at_) : flat_.find_first_of(",]}", at_);
      return take(std::min(end, flat_.size()) - at_);
    }
    const Bracket& bracket = brackets_[next_];
    const std::size_t size = bracket.end + 1 - at_;
    // Arrays of numbers stay on one line however long: a list of 5 multipliers is one thing to the eye.
    const bool scalars = first == '[' && !bracket.nested;
    if (size == 2 || scalars || (indent + size <= json_line_width && indent > 0)) {
      take(size);
      next_ = bracket.next;
      return;
    }
    ++next_;
    take(1);
    while (at_ < bracket.end) {
      out_.append(1, '\n').append(indent + 2, ' ');
      if (first == '{') {
        take(behind_text(flat_, at_) + 1 - at_);
        out_ += ' ';
      }
      value(indent + 2);
      if (at_ < bracket.end) take(1);
    }
    out_.append(1, '\n').append(indent, ' ');
    take(1);
  }

 private:
  void take(std::size_t size) {
    out_.append(flat_, at_, size);
    at_ += size;
  }

  std::string_view flat_;
  std::string& out_;
  std::vector<Bracket> brackets_;
  std::size_t at_ = 0, next_ = 0;
};

}  // namespace

void lay_out(std::string_view flat, std::size_t indent, std::string& out) { Layout(flat, out).value(indent); }

}  // namespace graze::apps
