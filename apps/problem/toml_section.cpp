// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/problem/problem.hpp>
#include <graze/apps/problem/toml_section.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

namespace graze::apps {

namespace {

/// A value as shown in messages.
std::string shown(const toml::node& node) {
  std::ostringstream text;
  node.visit([&](const auto& value) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (toml::is_table<Value>)
      text << "a table";
    else
      text << value;
  });
  std::string line = text.str();  // a message has one line
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line;
}

std::optional<double> as_number(const toml::node& node) {
  if (node.is_number()) return node.value<double>();
  const auto text = node.value_exact<std::string>();
  return text ? parse_number(*text) : std::nullopt;
}

std::optional<Vector> as_state(const toml::node& node) {
  const toml::array* array = node.as_array();
  if (!array || array->size() != 2) return std::nullopt;
  const auto x = as_number(*array->get(0)), v = as_number(*array->get(1));
  return x && v ? std::optional(Vector{{*x, *v}}) : std::nullopt;
}

/// The reason why a text is not TOML, on one line: the parser quotes line ends as they are.
std::string reason(const toml::parse_error& error) {
  std::string text;
  for (const char c : error.description()) text += c == '\n' ? std::string("\\n") : std::string(1, c);
  return text;
}

/// The number of the first line that is not UTF-8.
std::optional<std::size_t> not_utf8(std::string_view text) {
  std::size_t line = 1;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const std::size_t length = byte < 0x80                   ? 1
                               : byte >= 0xC2 && byte < 0xE0 ? 2
                               : byte >= 0xE0 && byte < 0xF0 ? 3
                               : byte >= 0xF0 && byte < 0xF5 ? 4
                                                             : 0;
    if (length == 0 || i + length > text.size()) return line;
    for (std::size_t k = 1; k < length; ++k)
      if ((static_cast<unsigned char>(text[i + k]) & 0xC0) != 0x80) return line;
    line += byte == '\n' ? 1 : 0;
    i += length;
  }
  return std::nullopt;
}

}  // namespace

toml::table parse_toml(std::string_view text, const std::string& file) {
  if (const auto line = not_utf8(text))
    throw std::invalid_argument(
        fmt::format("{}:{}: holds bytes that are not text in UTF-8; save it in that encoding", file, *line));
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    throw equations::EquationError({file, std::string(text)}, place_of(error.source()), "not valid TOML: " + reason(error));
  }
}

equations::Place place_of(const toml::source_region& source) {
  if (!source.begin) return {};
  const bool one_line = source.end.line == source.begin.line && source.end.column > source.begin.column;
  return {source.begin.line, source.begin.column, one_line ? source.end.column - source.begin.column : 1U};
}

std::string toml_position(const std::string& file, const toml::source_region& source) {
  return source.begin ? fmt::format("{}:{}", file, source.begin.line) : file;
}

namespace {

/// "; did you mean A?" with the nearest known name, or "; known are A, B, C". `shown` gives the form of a name.
template <class Shown>
std::string nearest_or_known(std::string_view given, const std::vector<std::string>& known, const Shown& shown) {
  if (const std::string nearest = nearest_name(given, known); !nearest.empty())
    return fmt::format("; did you mean {}?", shown(nearest));
  std::vector<std::string> list;
  for (const std::string& name : known) list.push_back(shown(name));
  return fmt::format("; known are {}", fmt::join(list, ", "));
}

}  // namespace

std::string unknown_key(std::string_view key, std::string_view where, const std::vector<std::string>& known,
                        const std::string& note) {
  return fmt::format("unknown key '{}' in {}{}{}", key, where, note,
                     nearest_or_known(key, known, [](const std::string& name) { return fmt::format("'{}'", name); }));
}

void check_sections(const toml::table& root, const equations::Source& source, const std::vector<std::string>& known) {
  for (const auto& [key, node] : root) {
    const std::string name(key.str());
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    const bool array = node.is_array_of_tables(), section = array || node.is_table();
    const auto shown = [array](const std::string& one) {
      return fmt::format("{0}{1}{2}", array ? "[[" : "[", one, array ? "]]" : "]");
    };
    const std::string given = section ? "section " + shown(name) : fmt::format("key '{}' outside of the sections", name);
    throw equations::EquationError(source, place_of(key.source()),
                                   fmt::format("unknown {}{}", given, nearest_or_known(name, known, shown)));
  }
}

TomlSection::TomlSection(const std::string& file, const toml::table& root, std::string name)
    : file_(file), name_(std::move(name)) {
  const toml::node* node = root.get(name_);
  if (!node) return;
  table_ = node->as_table();
  if (!table_)
    throw std::invalid_argument(
        fmt::format("{}: {} is {}; it must be a section [{}]", toml_position(file_, node->source()), name_, shown(*node), name_));
}

TomlSection::TomlSection(const std::string& file, std::string name, const toml::table& table)
    : file_(file), name_(std::move(name)), table_(&table) {}

std::optional<std::string> TomlSection::text(const std::string& key) {
  const toml::node* node = find(key);
  if (!node) return std::nullopt;
  auto value = node->value_exact<std::string>();
  if (!value) throw wrong_type(key, *node, "text in quotes");
  return value;
}

std::optional<double> TomlSection::number(const std::string& key) {
  const toml::node* node = find(key);
  if (!node) return std::nullopt;
  const std::optional<double> value = as_number(*node);
  if (!value) throw wrong_type(key, *node, "a number (0.05, or in quotes \"36/35\", \"2*pi\")");
  return value;
}

std::optional<int> TomlSection::count(const std::string& key, int least, int most) {
  const toml::node* node = find(key);
  if (!node) return std::nullopt;
  const auto value = node->value_exact<std::int64_t>();
  if (!value || *value < least || *value > most) {
    const bool limited = most < std::numeric_limits<int>::max() || (value && *value > most);
    throw wrong_type(key, *node, fmt::format("a whole number >= {}{}", least, limited ? fmt::format(" and <= {}", most) : ""));
  }
  return static_cast<int>(*value);
}

std::optional<Vector> TomlSection::state(const std::string& key) {
  const toml::node* node = find(key);
  if (!node) return std::nullopt;
  if (auto state = as_state(*node)) return state;
  throw wrong_type(key, *node, "two numbers [x, v]");
}

std::vector<Vector> TomlSection::states(const std::string& key) {
  std::vector<Vector> list;
  const toml::node* node = find(key);
  if (!node) return list;
  const toml::array* array = node->as_array();
  for (std::size_t i = 0; array && i < array->size(); ++i)
    if (const auto state = as_state(*array->get(i))) list.push_back(*state);
  if (!array || list.size() < array->size()) throw wrong_type(key, *node, "pairs of numbers [[x, v], ...]");
  return list;
}

TomlSection TomlSection::table(const std::string& key) {
  find(key);
  static const toml::table none;
  return {file_, table_ ? *table_ : none, key};
}

std::vector<TomlSection> TomlSection::tables(const std::string& key) {
  std::vector<TomlSection> list;
  const toml::node* node = find(key);
  if (!node) return list;
  const toml::array* array = node->as_array();
  for (std::size_t i = 0; array && i < array->size(); ++i)
    if (const toml::table* table = array->get(i)->as_table()) list.emplace_back(file_, key, *table);
  if (!array || list.size() < array->size())
    throw std::invalid_argument(fmt::format("{}: {} must be a list of tables", toml_position(file_, node->source()), key));
  return list;
}

std::vector<std::string> TomlSection::keys() const {
  std::vector<std::string> list;
  if (table_)
    for (const auto& [key, node] : *table_) list.emplace_back(key.str());
  return list;
}

std::optional<std::vector<double>> TomlSection::numbers(const std::string& key) {
  const toml::node* node = find(key);
  if (!node) return std::nullopt;
  std::vector<double> list;
  const toml::array* array = node->as_array();
  for (std::size_t i = 0; array && i < array->size(); ++i)
    if (const auto value = as_number(*array->get(i))) list.push_back(*value);
  if (!array || list.size() < array->size()) throw wrong_type(key, *node, "numbers in square brackets");
  return list;
}

void TomlSection::finish(const std::string& contact) const {
  if (!table_) return;
  for (const auto& [key, node] : *table_)
    if (std::find(known_.begin(), known_.end(), key.str()) == known_.end())
      throw std::invalid_argument(fmt::format(
          "{}: {}", toml_position(file_, node.source()),
          unknown_key(key.str(), fmt::format("[{}]", name_), known_, contact.empty() ? "" : owner_of(key.str(), contact))));
}

std::string TomlSection::where(std::string_view key) const {
  if (has(key)) return toml_position(file_, table_->get(key)->source());
  return table_ ? toml_position(file_, table_->source()) : file_;
}

std::invalid_argument TomlSection::lacks(const std::string& key, const std::string& wanted) const {
  return std::invalid_argument(fmt::format("{}: [{}] lacks {}: {}", where(), name_, key, wanted));
}

const toml::node* TomlSection::find(const std::string& key) {
  known_.push_back(key);
  return table_ ? table_->get(key) : nullptr;
}

std::invalid_argument TomlSection::wrong_type(const std::string& key, const toml::node& node, const std::string& wanted) const {
  return std::invalid_argument(
      fmt::format("{}: {} = {} in [{}] must be {}", toml_position(file_, node.source()), key, shown(node), name_, wanted));
}

}  // namespace graze::apps
