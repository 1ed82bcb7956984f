// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/published/comparison.hpp>
#include <graze/apps/text/number.hpp>

#include <algorithm>
#include <cmath>

namespace graze::apps {

const char* verdict_name(Verdict verdict) { return verdict == Verdict::agrees ? "agrees" : "differs"; }

bool agrees_with_print(double computed, double error, double printed, int digits) {
  // A value halfway between two printed ones may be rounded either way.
  const double half_unit = 0.5 * std::pow(10.0, -digits), rounding = 1e-9 * half_unit;
  return std::abs(computed - printed) <= half_unit + rounding + 3.0 * error;
}

void add_remark(std::string& remark, const std::string& sentence) {
  if (!sentence.empty()) remark += (remark.empty() ? "" : "; ") + sentence;
}

const Columns<Comparison>& comparison_columns() {
  using C = Comparison;
  static const Columns<C> list = {{"figure", "published figure", &C::figure},
                                  {"system", "id of the system", &C::system},
                                  {"eta", "forcing frequency; of a window its lower end", &C::eta},
                                  {"quantity", "compared quantity", &C::quantity},
                                  {"published", "value", &C::published},
                                  {"computed", "value", &C::computed},
                                  {"uncertainty", "of the computed value; null: it has none", &C::uncertainty},
                                  {"verdict", "whether they agree", &C::verdict},
                                  {"remark", "cause of a difference, if known", &C::remark},
                                  {"published_text", "for people", &C::published_text},
                                  {"computed_text", "for people", &C::computed_text},
                                  {"details", "further results", &C::details}};
  return list;
}

Table comparisons_table(const std::vector<Comparison>& rows) {
  Table table{{"figure", "system", "eta", "quantity", "published", "computed", "verdict"}, {}};
  for (const Comparison& row : rows)
    table.rows.push_back({row.figure, row.system, row.eta ? rounded(*row.eta, 7) : "", row.quantity, row.published_text,
                          row.computed_text, verdict_name(row.verdict)});
  return table;
}

std::size_t count_of(const std::vector<Comparison>& rows, Verdict verdict) {
  return static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [&](const Comparison& row) { return row.verdict == verdict; }));
}

}  // namespace graze::apps
