// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/published/comparison.hpp>
#include <graze/apps/text/number.hpp>

#include <algorithm>
#include <cmath>

namespace graze::apps {

const char* verdict_name(Verdict verdict) { return verdict == Verdict::agrees ? "agrees" : "differs"; }

Verdict verdict_from(const Json& name) { return name == verdict_name(Verdict::agrees) ? Verdict::agrees : Verdict::differs; }

bool agrees_with_print(double computed, double error, double printed, int digits) {
  // A value in the middle between two printed ones may be rounded either way.
  const double half_unit = 0.5 * std::pow(10.0, -digits), rounding = 1e-9 * half_unit;
  return std::abs(computed - printed) <= half_unit + rounding + 3.0 * error;
}

void add_remark(std::string& remark, const std::string& sentence) {
  if (!sentence.empty()) remark += (remark.empty() ? "" : "; ") + sentence;
}

Json comparison_json(const Comparison& row) {
  return {{"figure", row.figure},
          {"system", row.system},
          {"eta", row.eta ? Json(*row.eta) : Json(nullptr)},
          {"quantity", row.quantity},
          {"published", row.published},
          {"computed", row.computed},
          {"uncertainty", row.uncertainty},
          {"verdict", verdict_name(row.verdict)},
          {"remark", row.remark},
          {"published_text", row.published_text},
          {"computed_text", row.computed_text},
          {"details", row.details}};
}

Comparison comparison_from(const Json& json) {
  Comparison row;
  row.figure = json.at("figure");
  row.system = json.at("system");
  row.quantity = json.at("quantity");
  if (json.at("eta").is_number()) row.eta = json["eta"].get<double>();
  row.published = json.at("published");
  row.computed = json.at("computed");
  row.uncertainty = json.at("uncertainty");
  row.published_text = json.at("published_text");
  row.computed_text = json.at("computed_text");
  row.verdict = verdict_from(json.at("verdict"));
  row.remark = json.at("remark");
  row.details = json.at("details");
  return row;
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
