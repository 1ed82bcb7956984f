// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/text/number.hpp>
#include <graze/apps/text/table.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace graze::apps {

namespace {

/// Width on the screen in letters: UTF-8 continuation bytes take no room.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string quoted(const std::string& cell) {
  if (cell.find_first_of(",\"\n") == std::string::npos) return cell;
  std::string out = "\"";
  for (const char c : cell) out.append(c == '"' ? 2 : 1, c);
  return out + "\"";
}

std::string joined(const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) line += ',';
    line += quoted(cells[i]);
  }
  return line + "\n";
}

}  // namespace

std::string aligned(const Table& table, int indent) {
  const std::size_t count = table.columns.size();
  std::vector<std::size_t> widths(count);
  std::vector<bool> numeric(count, true);
  for (std::size_t i = 0; i < count; ++i) {
    widths[i] = width(table.columns[i]);
    for (const std::vector<std::string>& row : table.rows) {
      widths[i] = std::max(widths[i], width(row[i]));
      // Complex numbers, missing numbers and empty cells are aligned like numbers.
      const bool complex = row[i].ends_with(" i"), missing = row[i] == "-" || row[i] == "..." || row[i] == "unknown";
      if (!row[i].empty() && !missing && !complex && !parse_number(row[i])) numeric[i] = false;
    }
  }
  std::string text;
  const auto line = [&](const std::vector<std::string>& cells) {
    std::string out(static_cast<std::size_t>(indent), ' ');
    for (std::size_t i = 0; i < count; ++i) {
      const std::string padding(widths[i] - width(cells[i]), ' ');
      out += i ? "  " : "";
      out += numeric[i] ? padding + cells[i] : cells[i] + padding;
    }
    out.erase(out.find_last_not_of(' ') + 1);
    text += out + "\n";
  };
  line(table.columns);
  for (const std::vector<std::string>& row : table.rows) line(row);
  return text;
}

std::string csv(const Table& table) {
  std::string text = joined(table.columns);
  for (const std::vector<std::string>& row : table.rows) text += joined(row);
  return text;
}

Table parse_csv(const std::string& text, const std::string& file) {
  std::vector<std::vector<std::string>> rows(1);
  std::string cell;
  bool inside = false;
  int line = 1;
  const auto end_row = [&] {
    rows.back().push_back(std::move(cell));
    cell.clear();
    const bool blank = rows.back().size() == 1 && rows.back().front().empty();
    if (blank)
      rows.back().clear();
    else if (rows.back().size() != rows.front().size())
      throw std::invalid_argument(fmt::format("{}:{}: {} in a table of {}", file, line, counted(rows.back().size(), "cell"),
                                              counted(rows.front().size(), "column")));
    else
      rows.emplace_back();
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (inside && c == '"' && i + 1 < text.size() && text[i + 1] == '"')
      cell += text[++i];
    else if (c == '"')
      inside = !inside;
    else if (!inside && c == ',') {
      rows.back().push_back(std::move(cell));
      cell.clear();
    } else if (!inside && c == '\n') {
      end_row();
      ++line;
    } else if (inside || c != '\r')
      cell += c;
  }
  end_row();
  rows.pop_back();
  if (inside) throw std::invalid_argument(fmt::format("{}: a quoted cell does not end", file));
  if (rows.empty()) throw std::invalid_argument(fmt::format("{}: the table is empty", file));
  Table table;
  table.columns = rows.front();
  for (const std::string& name : table.columns)
    if (name.find('\n') != std::string::npos)
      throw std::invalid_argument(fmt::format("{}:1: the name of a column goes over several lines; is a quote missing?", file));
  table.rows.assign(rows.begin() + 1, rows.end());
  return table;
}

}  // namespace graze::apps
