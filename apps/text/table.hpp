// SPDX-License-Identifier: GPL-3.0-or-later
// Table: named columns of text cells, printed aligned for people or as CSV for programs.
#pragma once

#include <string>
#include <vector>

namespace graze::apps {

struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

/// Columns padded to their widest cell; numbers right-aligned, text left-aligned; `indent` blanks before each line.
std::string aligned(const Table& table, int indent = 2);

/// RFC 4180, with a header line.
std::string csv(const Table& table);

/// Reads a text that csv() has written. @throws std::invalid_argument naming line and reason.
Table parse_csv(const std::string& text, const std::string& file);

}  // namespace graze::apps
