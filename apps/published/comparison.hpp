// SPDX-License-Identifier: GPL-3.0-or-later
// Comparison: a published figure beside the computed one, with a verdict and, where they differ, a remark that says what is known
// of why. Nothing is tuned: the verdict looks at the printed digits and at our own error, and at nothing else.
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
  std::optional<double> eta;  ///< of the item; a window's is its lower end
  Json published, computed;
  Json uncertainty;  ///< like `computed`, or null where it has no error
  std::string published_text, computed_text;
  Verdict verdict = Verdict::differs;
  std::string remark;
  Json details = Json::object();  ///< what else was found
};

/// Whether a computed value agrees with one printed to so many decimals: within half a unit of the last one and three standard
/// errors of the computed one.
bool agrees_with_print(double computed, double error, double printed, int digits);

/// Sentences in a row: "a; b". An empty one is none.
void add_remark(std::string& remark, const std::string& sentence);

const Columns<Comparison>& comparison_columns();
template <> struct JsonForm<Verdict> : ChoiceForm<Verdict, verdict_name, Verdict::agrees, Verdict::differs> {};
template <> struct JsonForm<Comparison> : RecordForm<Comparison, comparison_columns> {};

/// For people: figure, system, eta, quantity, published, computed, verdict.
Table comparisons_table(const std::vector<Comparison>& rows);

std::size_t count_of(const std::vector<Comparison>& rows, Verdict verdict);

}  // namespace graze::apps
