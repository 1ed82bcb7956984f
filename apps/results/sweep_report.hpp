// SPDX-License-Identifier: GPL-3.0-or-later
// What is said of a sweep: its rows as JSON (graze.sweep/1, and "rows" of graze.diagram/1) and back, as tables, and the windows
// in which it is chaotic.
#pragma once

#include <graze/apps/problem/problem.hpp>
#include <graze/apps/quantities/quantities.hpp>
#include <graze/apps/results/attractor_report.hpp>
#include <graze/apps/text/table.hpp>

#include <graze/floquet/follow/sweep.hpp>

#include <string>
#include <vector>

namespace graze::apps {

/// Quantities of each row; empty: none. Of an attractor that is not periodic they are those of the motion through the states
/// kept.
using RowQuantities = std::vector<QuantityValues>;
RowQuantities measure(const Quantities& quantities, const Problem& problem, const std::string& parameter,
                      const std::vector<SweepRow>& rows, int threads);

/// Of a row it is read back what a sweep needs to go on from it, and to write it again: of orbits state, label and multipliers,
/// of averages their length.
const Columns<SweepRow>& row_columns();

template <>
struct JsonForm<SweepDirection> : ChoiceForm<SweepDirection, sweep_direction_name, SweepDirection::up, SweepDirection::down> {};
template <> struct JsonForm<SweepRow> : RecordForm<SweepRow, row_columns> {};

void write_row(const SweepRow& row, JsonText& json, const QuantityValues& values = {});
Json rows_json(const std::vector<SweepRow>& rows, const RowQuantities& measured = {});

/// The schema of rows, with their quantities.
Json rows_schema();

/// One line per stretch of rows with the same attractor.
Table sweep_overview(const std::vector<SweepRow>& rows, const std::string& parameter, const RowQuantities& measured = {});

/// As CSV: one line per stroboscopic state; made on so many threads.
void samples_csv(const Problem& problem, const std::vector<SweepRow>& rows, const std::string& parameter, int threads,
                 const TextSink& sink, const RowQuantities& measured = {});

/// Neighbouring values of one direction at which the attractor is chaotic, and the largest exponent there.
struct ChaoticWindow {
  SweepDirection direction = SweepDirection::up;
  double from = 0.0, to = 0.0;  ///< ascending, whichever the direction
  std::size_t values = 0;
  double largest_exponent = 0.0, standard_error = 0.0, at = 0.0;
};

/// In the order of the rows.
std::vector<ChaoticWindow> chaotic_windows(const std::vector<SweepRow>& rows);

const Columns<ChaoticWindow>& window_columns();
template <> struct JsonForm<ChaoticWindow> : RecordForm<ChaoticWindow, window_columns> {};

Table chaotic_windows_table(const std::vector<ChaoticWindow>& windows, const std::string& parameter);

}  // namespace graze::apps
