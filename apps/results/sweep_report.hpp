// SPDX-License-Identifier: GPL-3.0-or-later
// Report of a sweep: its rows as JSON (graze.sweep/1, and "rows" of graze.diagram/1) and back, as tables, and its chaotic
// windows.
#pragma once

#include <graze/apps/problem/problem.hpp>
#include <graze/apps/quantities/quantities.hpp>
#include <graze/apps/results/attractor_report.hpp>
#include <graze/apps/text/table.hpp>

#include <graze/floquet/follow/sweep.hpp>

#include <string>
#include <vector>

namespace graze::apps {

/// Quantities of each row; empty: none. For an attractor that is not periodic they belong to the motion through the stored
/// states.
using RowQuantities = std::vector<QuantityValues>;
RowQuantities measure(const Quantities& quantities, const Problem& problem, const std::string& parameter,
                      const std::vector<SweepRow>& rows, int threads);

/// Columns of a row. The reader takes only the data needed to continue a sweep from the row and to write it again: state, label
/// and multipliers of orbits, and the length of averages.
const Columns<SweepRow>& row_columns();

template <>
struct JsonForm<SweepDirection> : ChoiceForm<SweepDirection, sweep_direction_name, SweepDirection::up, SweepDirection::down> {};
template <> struct JsonForm<SweepRow> : RecordForm<SweepRow, row_columns> {};

void write_row(const SweepRow& row, JsonText& json, const QuantityValues& values = {});
Json rows_json(const std::vector<SweepRow>& rows, const RowQuantities& measured = {});

/// Reads the rows of a result of a system with `states` states. @throws Json::exception if their vectors have another length.
std::vector<SweepRow> rows_from(const Json& rows, std::size_t states);

/// The schema of rows, with their quantities.
Json rows_schema();

/// One line for each group of consecutive rows with the same attractor.
Table sweep_overview(const std::vector<SweepRow>& rows, const std::string& parameter, const RowQuantities& measured = {});

/// The rows as CSV: one line per stroboscopic state; produced on `threads` threads.
void samples_csv(const Problem& problem, const std::vector<SweepRow>& rows, const std::string& parameter, int threads,
                 const TextSink& sink, const RowQuantities& measured = {});

/// A range of neighbouring values of one direction at which the attractor is chaotic, and the largest exponent there.
struct ChaoticWindow {
  SweepDirection direction = SweepDirection::up;
  double from = 0.0, to = 0.0;  ///< ascending, for either direction
  std::size_t values = 0;
  double largest_exponent = 0.0, standard_error = 0.0, at = 0.0;
};

/// The windows, in the order of the rows.
std::vector<ChaoticWindow> chaotic_windows(const std::vector<SweepRow>& rows);

const Columns<ChaoticWindow>& window_columns();
template <> struct JsonForm<ChaoticWindow> : RecordForm<ChaoticWindow, window_columns> {};

Table chaotic_windows_table(const std::vector<ChaoticWindow>& windows, const std::string& parameter);

}  // namespace graze::apps
