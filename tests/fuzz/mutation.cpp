// SPDX-License-Identifier: GPL-3.0-or-later
#include "mutation.hpp"

#include <graze/apps/text/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <utility>

namespace graze::fuzz {

namespace {

using apps::Json;

constexpr std::size_t longest_input = 200000;  // bytes: the time is for many inputs and not for long ones

const std::array<const char*, 30> numbers = {"0",
                                             "1",
                                             "-1",
                                             "2",
                                             "3",
                                             "0.5",
                                             "1e-3",
                                             "7",
                                             "64",
                                             "65",
                                             "1000",
                                             "2147483647",
                                             "2147483648",
                                             "-2147483648",
                                             "4294967296",
                                             "9223372036854775807",
                                             "99999999999999999999",
                                             "1e308",
                                             "-1e308",
                                             "1e309",
                                             "1e-308",
                                             "5e-324",
                                             "nan",
                                             "inf",
                                             "-inf",
                                             "-0.0",
                                             "1/0",
                                             "0x10",
                                             "1.",
                                             ".5"};

/// Begin and end of a piece of such characters, searched from a random position; empty at the end: there is none.
template <class Is> std::pair<std::size_t, std::size_t> find_piece(const std::string& text, Dice& dice, Is is) {
  if (text.empty()) return {0, 0};
  std::size_t at = dice.below(text.size());
  while (at < text.size() && !is(text[at])) ++at;
  while (at > 0 && at < text.size() && is(text[at - 1])) --at;
  std::size_t end = at;
  while (end < text.size() && is(text[end])) ++end;
  return {at, end};
}

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '\''; }
bool is_number(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.'; }

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines(1);
  for (const char c : text) {
    lines.back() += c;
    if (c == '\n') lines.emplace_back();
  }
  return lines;
}

void change_lines(std::string& text, Dice& dice) {
  std::vector<std::string> lines = lines_of(text);
  const std::size_t at = dice.below(lines.size()), other = dice.below(lines.size());
  switch (dice.below(3)) {
  case 0:
    std::swap(lines[at], lines[other]);
    break;
  case 1:
    lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(at));
    break;
  default:
    lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(at), std::string(lines[other]));
    break;
  }
  text.clear();
  for (const std::string& line : lines) text += line;
}

/// A bracket or a sign many times: a recursive parser reaches the same depth.
void nest(std::string& text, Dice& dice) {
  const std::array<const char*, 10> pieces = {"(", "[", "{", "-", "sin(", "[[", "{\"a\":", "x^", "{a=", "\""};
  const std::string piece = dice.one_of(pieces);
  const std::array<std::size_t, 4> counts = {3, 40, 300, 50000};
  std::string many;
  for (std::size_t count = dice.one_of(counts); count > 0; --count) many += piece;
  text.insert(dice.below(text.size() + 1), many);
}

void change_text(std::string& text, const std::string& other, Form form, const std::vector<std::string>& words, Dice& dice) {
  const std::size_t at = dice.below(text.size() + 1);
  const std::size_t rest = text.size() - at, length = rest == 0 ? 0 : 1 + dice.below(std::min<std::size_t>(rest, 64));
  switch (dice.below(form == Form::bytes ? 6 : 12)) {
  case 0:
    if (at < text.size()) text[at] = static_cast<char>(dice.below(256));
    break;
  case 1:
    text.insert(at, 1, static_cast<char>(form == Form::bytes ? dice.below(256) : 32 + dice.below(95)));
    break;
  case 2:
    text.erase(at, length);
    break;
  case 3:
    text.insert(dice.below(text.size() + 1), text.substr(at, length));
    break;
  case 4:
    if (!other.empty()) text.replace(at, length, other.substr(dice.below(other.size()), 1 + dice.below(64)));
    break;
  case 5:
    if (dice.one_in(4)) text.resize(at);
    if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << dice.below(8)));
    break;
  case 6:
  case 7: {
    const auto [begin, end] = find_piece(text, dice, is_number);
    text.replace(begin, end - begin, dice.one_of(numbers));
    break;
  }
  case 8: {
    const auto [begin, end] = find_piece(text, dice, is_word);
    const auto [from, to] = find_piece(text, dice, is_word);
    text.replace(begin, end - begin, std::string(text, from, to - from));
    break;
  }
  case 9: {
    const auto [begin, end] = find_piece(text, dice, is_word);
    if (!words.empty()) text.replace(begin, dice.one_in(2) ? end - begin : 0, dice.one_of(words));
    break;
  }
  case 10:
    change_lines(text, dice);
    break;
  default:
    if (dice.one_in(4)) nest(text, dice);
    break;
  }
}

/// A random part of it.
Json& part_of(Json& json, Dice& dice) {
  Json* part = &json;
  while (part->is_structured() && !part->empty() && !dice.one_in(5))
    part = &*std::next(part->begin(), static_cast<std::ptrdiff_t>(dice.below(part->size())));
  return *part;
}

void change_json(Json& json, Dice& dice) {
  Json& part = part_of(json, dice);
  switch (dice.below(7)) {
  case 0: {
    const Json others[] = {nullptr,
                           true,
                           "",
                           "x",
                           Json::array(),
                           Json::object(),
                           0,
                           -1,
                           1,
                           3,
                           2147483648LL,
                           1e308,
                           0.5,
                           Json::array({1, 2}),
                           Json::array({Json::array()}),
                           1000000000,
                           "periodic",
                           "done"};
    part = others[dice.below(std::size(others))];
    break;
  }
  case 1: {
    Json copy = part_of(json, dice);
    part = std::move(copy);
    break;
  }
  case 2:
    if (part.is_array() && !part.empty()) part.erase(part.begin() + static_cast<std::ptrdiff_t>(dice.below(part.size())));
    if (part.is_object() && !part.empty())
      part.erase(std::next(part.begin(), static_cast<std::ptrdiff_t>(dice.below(part.size()))));
    break;
  case 3:
    if (part.is_array() && !part.empty()) part.push_back(Json(part[dice.below(part.size())]));
    break;
  case 4:
    if (part.is_number()) part = part.get<double>() * (dice.one_in(2) ? -1.0 : 1e6);
    break;
  case 5:
    if (part.is_number_integer()) part = part.get<std::int64_t>() + (dice.one_in(2) ? 1 : -1);
    break;
  default:
    if (part.is_array()) part.clear();
    break;
  }
}

}  // namespace

std::uint64_t Dice::roll() {
  std::uint64_t z = state_ += 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31U);
}

std::string mutated(const std::vector<std::string>& seeds, Form form, const std::vector<std::string>& words, Dice& dice) {
  std::string text = dice.one_of(seeds);
  std::size_t changes = 1 + dice.below(dice.one_in(4) ? 8 : 2);
  if (form == Form::json && !dice.one_in(4)) {
    Json json = Json::parse(text, nullptr, false);
    if (!json.is_discarded()) {
      for (; changes > 0; --changes) change_json(json, dice);
      return apps::flat(json);
    }
  }
  for (; changes > 0; --changes) change_text(text, dice.one_of(seeds), form, words, dice);
  if (text.size() > longest_input) text.resize(longest_input);
  return text;
}

}  // namespace graze::fuzz
