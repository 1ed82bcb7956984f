// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/text/column.hpp>
#include <graze/apps/text/number.hpp>

namespace graze::apps {

namespace {

std::string cell_of(const Json& value, int digits) {
  if (value.is_null()) return digits > 0 ? "-" : "";
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_string()) return value;
  if (value.is_number_integer()) return std::to_string(value.get<std::int64_t>());
  if (value.is_array()) return rounded(value_of<std::complex<double>>(value), digits);
  return digits > 0 ? rounded(value.get<double>(), digits) : exact(value);
}

}  // namespace

void add_columns(Table& table, const std::vector<Shown>& shown) {
  for (const Shown& one : shown) table.columns.insert(table.columns.end(), one.heads.begin(), one.heads.end());
}

void add_cells(std::vector<std::string>& row, const Json& value, const Shown& shown) {
  if (!value.is_array()) return row.push_back(cell_of(value, shown.digits));
  Json items = value;
  if (shown.digits == 0 && !value.empty() && value[0].is_array()) {
    items = Json::array();
    for (const Json& number : value) items.insert(items.end(), number.begin(), number.end());
  }
  for (std::size_t i = 0; i < shown.heads.size(); ++i) row.push_back(cell_of(i < items.size() ? items[i] : Json(), shown.digits));
}

}  // namespace graze::apps
