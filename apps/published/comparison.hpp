// SPDX-License-Identifier: GPL-3.0-or-later
// Comparison: a published figure beside the computed one, with a verdict and, if they differ, a remark on the known reasons.
// Nothing is tuned: the verdict depends only on the printed digits and the error of the computed value.
#pragma once

#include <graze/apps/text/column.hpp>

#include <optional>
#include <string>
#include <vector>

namespace graze::apps {

enum class Verdict { differs, agrees };

/// "differs", "agrees".
const char* verdict_name(Verdict verdict);

/// One row of graze.reproduce/1.
struct Comparison {
  std::string figure, system;
  std::string quantity;       ///< "PD" or another special point, "multipliers", "exponents", "window"
  std::optional<double> eta;  ///< of the item; for a window its lower end
  Json published, computed;
  Json uncertainty;  ///< like `computed`, or null if there is no error
  std::string published_text, computed_text;
  Verdict verdict = Verdict::differs;
  std::string remark;
  Json details = Json::object();  ///< further findings
};

/// Whether a computed value agrees with one printed to `digits` decimals: within half a unit of the last decimal plus three
/// standard errors of the computed value.
bool agrees_with_print(double computed, double error, double printed, int digits);

/// Appends a sentence to a remark: "a; b". An empty sentence changes nothing.
void add_remark(std::string& remark, const std::string& sentence);

const Columns<Comparison>& comparison_columns();
template <> struct JsonForm<Verdict> : ChoiceForm<Verdict, verdict_name, Verdict::agrees, Verdict::differs> {};
template <> struct JsonForm<Comparison> : RecordForm<Comparison, comparison_columns> {};

/// A table for people: figure, system, eta, quantity, published, computed, verdict.
Table comparisons_table(const std::vector<Comparison>& rows);

std::size_t count_of(const std::vector<Comparison>& rows, Verdict verdict);

}  // namespace graze::apps
