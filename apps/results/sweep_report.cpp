// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/attractor_report.hpp>
#include <graze/apps/results/sweep_report.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/apps/text/write_items.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <tuple>

namespace graze::apps {

const Columns<SweepRow>& row_columns() {
  using R = SweepRow;
  static const Columns<R> list =
      joined<R>({{{"value", "of the parameter", &R::value},
                  {"direction", "direction of the parameter", &R::direction},
                  {"attractor", "attractor at this value", &R::attractor}},
                 of_part<R, Attractor>(exponents_columns(), &R::attractor),
                 {{"periods", "of the exponents' average", [](const R& row) { return row.attractor.time_average.periods; },
                   [](R& row, std::int64_t value) { row.attractor.time_average.periods = value; }},
                  {"end", "state from which the next value starts", &R::end},
                  {"states", "on the attractor, at forcing phase 0", &R::states},
                  {"impact_speeds [speed]", "of the impacts on the way through them", &R::impact_speeds}}});
  return list;
}

RowQuantities measure(const Quantities& quantities, const Problem& problem, const std::string& parameter,
                      const std::vector<SweepRow>& rows, int threads) {
  RowQuantities measured;
  if (quantities.empty()) return measured;
  measured.resize(rows.size());
  const auto index = static_cast<Eigen::Index>(parameter_index(problem.system.parameters, parameter));
  in_parallel_on(threads, rows.size(), [&](std::size_t k) {
    const SweepRow& row = rows[k];
    if (row.states.empty()) return;
    const bool forced = is_forced(problem.system), closes = row.attractor.type == AttractorType::periodic;
    if (!forced && !closes) return;  // its returns do not give its duration
    Vector p = problem.parameters;
    p[index] = row.value;
    MeasuredMotion motion{.states = row.states, .duration = row.attractor.duration, .closes = closes};
    if (forced) {
      motion.duration = static_cast<double>(row.states.size()) * forcing_period(problem.system, p);
    } else {
      motion.states.resize(1);
    }
    measured[k] = measure(quantities, problem.system, p, motion);
  });
  return measured;
}

void write_row(const SweepRow& row, JsonText& json, const QuantityValues& values) {
  json.begin_object();
  write_members(row_columns(), row, json);
  if (!values.empty()) {
    json.key("y");
    write_quantities(values, json);
  }
  json.end_object();
}

Json rows_json(const std::vector<SweepRow>& rows, const RowQuantities& measured) {
  Json list = Json::array();
  for (std::size_t k = 0; k < rows.size(); ++k)
    list.push_back(tree_of([&](JsonText& json) { write_row(rows[k], json, measured.empty() ? QuantityValues{} : measured[k]); }));
  return list;
}

std::vector<SweepRow> rows_from(const Json& rows, std::size_t states) {
  std::vector<SweepRow> list = value_of<std::vector<SweepRow>>(rows);
  const auto fits = [&](const Vector& x) { return x.size() == static_cast<Eigen::Index>(states); };
  for (const SweepRow& row : list)
    if (!has_states(row.attractor, states) || !fits(row.end) || !std::all_of(row.states.begin(), row.states.end(), fits))
      throw Json::type_error::create(302, "type must be a row of this system", &rows);
  return list;
}

Json rows_schema() { return list_schema(with_quantities(schema_of(row_columns()))); }

Table sweep_overview(const std::vector<SweepRow>& rows, const std::string& parameter, const RowQuantities& measured) {
  Table table{{"direction", parameter + " from", "to", "attractor", "values", "largest exponent from", "to"}, {}};
  const auto with_values = std::find_if(measured.begin(), measured.end(), [](const auto& values) { return !values.empty(); });
  const QuantityValues names = with_values == measured.end() ? QuantityValues{} : *with_values;
  for (const QuantityValue& one : names) table.columns.insert(table.columns.end(), {one.name + " from", "to"});
  const auto numbers = [](const Attractor& x) {
    return std::tie(x.type, x.termination, x.period, x.impacts, x.isolated_impacts, x.rests);
  };
  const auto alike = [&numbers](const Attractor& a, const Attractor& b) {  // comparing numbers suffices for most rows
    return numbers(a) == numbers(b) || attractor_name(a) == attractor_name(b);
  };
  for (std::size_t i = 0; i < rows.size();) {
    const SweepRow& first = rows[i];
    std::size_t end = i;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (; end < rows.size() && rows[end].direction == first.direction && alike(rows[end].attractor, first.attractor); ++end) {
      if (rows[end].attractor.exponents.empty()) continue;
      low = std::min(low, rows[end].attractor.exponents[0]);
      high = std::max(high, rows[end].attractor.exponents[0]);
    }
    table.rows.push_back({std::string(sweep_direction_name(first.direction)), rounded(first.value, 7),
                          rounded(rows[end - 1].value, 7), attractor_name(first.attractor), std::to_string(end - i),
                          low <= high ? exponent_text(low, 4) : "-", low <= high ? exponent_text(high, 4) : "-"});
    for (std::size_t q = 0; q < names.size(); ++q) {
      low = std::numeric_limits<double>::infinity(), high = -low;
      for (std::size_t k = i; k < end; ++k)
        if (!measured[k].empty())
          for (const double value : measured[k][q].values) {
            low = std::min(low, value);
            high = std::max(high, value);
          }
      for (const double value : {low, high}) table.rows.back().push_back(low <= high ? rounded(value, 7) : "-");
    }
    i = end;
  }
  return table;
}

void samples_csv(const Problem& problem, const std::vector<SweepRow>& rows, const std::string& parameter, int threads,
                 const TextSink& sink, const RowQuantities& measured) {
  static const Columns<SweepRow> columns =
      joined<SweepRow>({row_columns(), of_part<SweepRow, Attractor>(attractor_columns(), &SweepRow::attractor)});
  std::vector<Shown> shown = {{"value", {parameter}}, {"direction"}, {"type", {"attractor"}}, {"period"}, {"impacts"},
                              {"exponents", {}}};
  for (std::size_t i = 1; i <= problem.system.states; ++i) shown.back().heads.push_back(fmt::format("exponent{}", i));
  Table head;
  add_columns(head, shown);
  add_given_headings(head, state_columns(problem));
  const auto with_values = std::find_if(measured.begin(), measured.end(), [](const auto& values) { return !values.empty(); });
  if (with_values != measured.end()) add_columns(head, *with_values);
  sink(csv(head));
  write_items(threads, rows.size(), sink, [&](std::size_t k, std::string& lines) {
    const SweepRow& row = rows[k];
    std::string begin;
    append_cells(begin, columns, shown, row);
    for (std::size_t period = 0; period < row.states.size(); ++period) {
      lines.append(begin, 1);
      JsonForm<Vector>::cells(row.states[period], lines);
      if (!measured.empty()) JsonForm<std::vector<double>>::cells(values_at(measured[k], period), lines);
      lines += '\n';
    }
  });
}

std::vector<ChaoticWindow> chaotic_windows(const std::vector<SweepRow>& rows) {
  std::vector<ChaoticWindow> list;
  bool inside = false;
  for (const SweepRow& row : rows) {
    const Attractor& attractor = row.attractor;
    if (attractor.type != AttractorType::chaotic) {
      inside = false;
      continue;
    }
    if (!inside || list.back().direction != row.direction)
      list.push_back({row.direction, row.value, row.value, 0, -std::numeric_limits<double>::infinity(), 0.0, row.value});
    inside = true;
    ChaoticWindow& window = list.back();
    window.from = std::min(window.from, row.value);
    window.to = std::max(window.to, row.value);
    ++window.values;
    if (attractor.exponents[0] <= window.largest_exponent) continue;
    window.largest_exponent = attractor.exponents[0];
    window.standard_error = attractor.standard_errors[0];
    window.at = row.value;
  }
  return list;
}

const Columns<ChaoticWindow>& window_columns() {
  using W = ChaoticWindow;
  static const Columns<W> list = {
      {"direction", "direction of the parameter", &W::direction},
      {"from", "lowest value of the parameter", &W::from},
      {"to", "highest value of the parameter", &W::to},
      {"values", "number of values", &W::values},
      {"largest_exponent [1/time]", "in the window", &W::largest_exponent},
      {"standard_error [1/time]", "of it", [](const W& window) { return finite(window.standard_error); }},
      {"at", "value of the parameter there", &W::at}};
  return list;
}

Table chaotic_windows_table(const std::vector<ChaoticWindow>& windows, const std::string& parameter) {
  Table table{{"direction", parameter + " from", "to", "values", "largest exponent", "+-", "at"}, {}};
  for (const ChaoticWindow& window : windows)
    table.rows.push_back({std::string(sweep_direction_name(window.direction)), rounded(window.from, 7), rounded(window.to, 7),
                          std::to_string(window.values), rounded(window.largest_exponent, 4),
                          error_text(window.standard_error, 2), rounded(window.at, 7)});
  return table;
}

}  // namespace graze::apps
