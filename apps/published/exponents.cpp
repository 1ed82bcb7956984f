// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/published/exponents.hpp>
#include <graze/apps/results/attractor_report.hpp>
#include <graze/apps/text/number.hpp>

#include <graze/continuation/graph/nearest_special_points.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace graze::apps {

namespace {

/// "(-0.015, -0.089)" with this number of decimals.
std::string pair_text(const std::vector<double>& values, int decimals) {
  std::string text;
  for (const double value : values)
    text += (text.empty() ? "" : ", ") + (std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-infinity");
  return "(" + text + ")";
}

bool agree(const std::vector<double>& computed, const std::vector<double>& errors, const std::vector<double>& printed,
           int digits) {
  if (computed.size() != printed.size()) return false;
  for (std::size_t i = 0; i < computed.size(); ++i)
    if (!agrees_with_print(computed[i], i < errors.size() ? errors[i] : 0.0, printed[i], digits)) return false;
  return true;
}

double gap(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

class ExponentComparison {
 public:
  ExponentComparison(const Published& published, const PublishedExponents& item, const ExponentsOptions& options)
      : item_(item), options_(options), problem_(problem_of(published, item.system, item.eta, item.beta)) {
    finding_.transient = options.transient;
    finding_.lyapunov.cancelled = options.cancelled;
    finding_.lyapunov.standard_error = options.standard_error;
    finding_.lyapunov.max_periods = options.max_periods;
  }

  Comparison compare(std::vector<Start> starts) {
    Comparison row;
    row.figure = item_.figure;
    row.system = item_.system;
    row.quantity = "exponents";
    row.eta = parameter(problem_, "eta");
    row.published = json_of(finite(item_.lambda));
    row.published_text = fmt::format("{} {}", pair_text(item_.lambda, item_.digits), label(item_.attractor));
    row.details["attractor"] = label(item_.attractor);
    row.details["beta"] = parameter(problem_, "beta");
    if (item_.initial) starts.insert(starts.begin(), {"the printed state", *item_.initial});
    starts.push_back({"rest", start_state(problem_, std::nullopt)});
    found_ = attractors_from(problem_, starts, finding_);
    if (found_.empty()) {
      add_remark(row.remark, "no motion could be carried on from any of the starts");
      row.computed_text = "nothing";
      return row;
    }
    for (FoundAttractor& found : found_)
      if (found.attractor.type == AttractorType::periodic || match_level(found.attractor, item_.attractor) == 3)
        average_on_attractor(problem_.system, problem_.parameters, found.attractor, finding_);
    FoundAttractor& meant = choose();
    if (meant.attractor.exponents.empty()) average_on_attractor(problem_.system, problem_.parameters, meant.attractor, finding_);
    row.computed = json_of(finite(meant.attractor.exponents));
    row.uncertainty = json_of(finite(meant.attractor.standard_errors));
    row.computed_text =
        fmt::format("{} {}", pair_text(meant.attractor.exponents, item_.digits + 2), attractor_name(meant.attractor));
    row.verdict = agree(meant.attractor.exponents, meant.attractor.standard_errors, item_.lambda, item_.digits)
                      ? Verdict::agrees
                      : Verdict::differs;
    add_details(row, meant);
    remark_on_motion(row, meant);
    if (row.verdict == Verdict::differs) remark_on_difference(row, meant);
    if (row.verdict == Verdict::differs || meant.attractor.type != AttractorType::periodic) remark_on_rule(row, meant.attractor);
    return row;
  }

 private:
  /// The attractor most like the described one; among equals the one with the nearest exponents.
  FoundAttractor& choose() {
    return *std::min_element(found_.begin(), found_.end(), [&](const FoundAttractor& a, const FoundAttractor& b) {
      const int like_a = match_level(a.attractor, item_.attractor), like_b = match_level(b.attractor, item_.attractor);
      if (like_a != like_b) return like_a > like_b;
      return gap(a.attractor.exponents, item_.lambda) < gap(b.attractor.exponents, item_.lambda);
    });
  }

  void add_details(Comparison& row, const FoundAttractor& meant) const {
    row.details["reached_from"] = meant.origin;
    row.details["computed_attractor"] = json_of(meant.attractor);
    row.details["time_average"] = json_of(meant.attractor.time_average);
    row.details["others"] = Json::array();
    for (const FoundAttractor& other : found_)
      if (&other != &meant)
        row.details["others"].push_back({{"attractor", attractor_name(other.attractor)},
                                         {"reached_from", other.origin},
                                         {"exponents", json_of(finite(other.attractor.exponents))}});
  }

  /// Remarks on the motion found instead of the described one.
  void remark_on_motion(Comparison& row, const FoundAttractor& meant) const {
    const Attractor& attractor = meant.attractor;
    if (is_described(attractor, item_.attractor)) return;
    std::string there = attractor_name(attractor);
    if (attractor.orbit && attractor.impacts > 0)
      there += fmt::format(" (slowest impact {})", rounded(slowest_impact(*attractor.orbit->whole), 2));
    add_remark(row.remark, fmt::format("the motion is {}, not {}", there, label(item_.attractor)));
    if (item_.attractor.type == "impactless") add_remark(row.remark, no_impactless_motion(problem_, *row.eta));
  }

  void remark_on_difference(Comparison& row, const FoundAttractor& meant) const {
    std::vector<double> turned = item_.lambda;
    if (!turned.empty()) turned[0] = -turned[0];
    const Attractor& attractor = meant.attractor;
    if (agree(attractor.exponents, attractor.standard_errors, turned, item_.digits))
      add_remark(row.remark, "the sign of the first exponent is lost in print");
    for (const FoundAttractor& other : found_)
      if (&other != &meant && agree(other.attractor.exponents, other.attractor.standard_errors, item_.lambda, item_.digits))
        add_remark(row.remark,
                   fmt::format("the printed pair is that of {}, reached from {}", attractor_name(other.attractor), other.origin));
    if (attractor.orbit)
      remark_on_branch(row, *attractor.orbit->whole);
    else
      remark_on_average(row, attractor);
  }

  /// Remarks on the required change in eta, and on nearby bifurcations.
  void remark_on_branch(Comparison& row, const PeriodicOrbit& orbit) const {
    NeighbourhoodOptions asking;
    asking.exponent = item_.lambda.front();
    asking.cancelled = options_.cancelled;
    const NearestSpecialPoints near = nearest_special_points(problem_.system, orbit, asking);
    const double eta = *row.eta;
    if (near.value_of_exponent) {
      row.details["eta_for_printed_value"] = *near.value_of_exponent;
      add_remark(row.remark, fmt::format("the printed first exponent is that of eta = {}, {:+.2g} away",
                                         rounded(*near.value_of_exponent, 9), *near.value_of_exponent - eta));
    } else {
      add_remark(row.remark,
                 fmt::format("on its branch no eta within {} has the printed first exponent", rounded(asking.reach, 2)));
    }
    if (const SpecialPoint* point = near.nearest(eta)) {
      row.details["nearest_bifurcation"] = {{"type", point_type_name(point->type)}, {"eta", point->value}};
      add_remark(row.remark, fmt::format("{} at eta = {}, {:+.2g} away", point_type_name(point->type), rounded(point->value, 9),
                                         point->value - eta));
    }
  }

  /// Remarks on the same average from other states, and on Liouville's identity for the printed pair.
  void remark_on_average(Comparison& row, const Attractor& attractor) const {
    if (attractor.exponents.empty()) return;
    const double error = attractor.standard_errors[0];
    add_remark(row.remark, fmt::format("the first exponents are {} of our standard errors apart",
                                       rounded(std::abs(attractor.exponents[0] - item_.lambda[0]) / error, 2)));
    AttractorOptions again = finding_;
    again.transient = 1000;
    again.lyapunov.standard_error = 1e-3;  // a tenth of the time, which is enough to reveal another attractor
    Json others = Json::array();
    double low = attractor.exponents[0], high = low;
    const Vector first = start_state(problem_, std::nullopt);
    for (const double part : {0.25, 0.5, 0.75}) {
      Vector start = first;
      start[0] = part * parameter(problem_, "r");
      const Attractor other = find_attractor(problem_.system, problem_.parameters, start, again);
      if (other.exponents.empty()) continue;
      others.push_back({{"start", to_json(start)},
                        {"attractor", attractor_name(other)},
                        {"exponents", json_of(finite(other.exponents))},
                        {"standard_errors", json_of(finite(other.standard_errors))}});
      low = std::min(low, other.exponents[0]);
      high = std::max(high, other.exponents[0]);
    }
    row.details["from_other_states"] = others;
    add_remark(row.remark,
               fmt::format("from {} further states it is between {} and {}", others.size(), rounded(low, 4), rounded(high, 4)));
    const double printed = std::accumulate(item_.lambda.begin(), item_.lambda.end(), 0.0);
    const double sum = std::accumulate(attractor.exponents.begin(), attractor.exponents.end(), 0.0);
    const bool same = std::abs(printed - sum) <= 1.0000001 * std::pow(10.0, -item_.digits) + 3.0 * error;
    add_remark(row.remark, fmt::format("the printed sum {} {} with ours, {}", rounded(printed, 5), same ? "agrees" : "disagrees",
                                       rounded(sum, 5)));
  }

  /// Remarks on averages stopped as in the source, from several states on the attractor.
  void remark_on_rule(Comparison& row, const Attractor& attractor) const {
    LyapunovOptions rule;
    rule.interval = 15;
    rule.change = 1e-6;
    rule.max_periods = parameter(problem_, "beta") == 0.0 ? 150000 : 7500;
    rule.cancelled = options_.cancelled;
    Vector state = attractor.state;
    Json runs = Json::array();
    double low = HUGE_VAL, high = -HUGE_VAL;
    std::int64_t shortest = rule.max_periods, longest = 0;
    for (int k = 0; k < options_.source_runs; ++k) {
      const LyapunovSpectrum spectrum = lyapunov_spectrum(problem_.system, problem_.parameters, state, rule);
      if (spectrum.stop == LyapunovStop::interrupted || spectrum.stop == LyapunovStop::failed) break;
      state = spectrum.state;
      runs.push_back({{"exponents", json_of(finite(spectrum.exponents))},
                      {"periods", spectrum.periods},
                      {"stop", lyapunov_stop_text(spectrum)}});
      low = std::min(low, spectrum.exponents[0]);
      high = std::max(high, spectrum.exponents[0]);
      shortest = std::min(shortest, spectrum.periods);
      longest = std::max(longest, spectrum.periods);
    }
    row.details["source_rule"] = runs;
    if (runs.empty()) return;
    const std::string ends = high - low < 1e-5 ? fmt::format("at {}", rounded(low, 4))
                                               : fmt::format("between {} and {}", rounded(low, 4), rounded(high, 4));
    add_remark(row.remark, fmt::format("stopped by the source's rule, {} averages end {}, after {} to {} periods", runs.size(),
                                       ends, shortest, longest));
  }

  const PublishedExponents& item_;
  const ExponentsOptions& options_;
  Problem problem_;
  AttractorOptions finding_;
  std::vector<FoundAttractor> found_;
};

}  // namespace

Comparison compare_exponents(const Published& published, const PublishedExponents& item, const std::vector<Start>& starts,
                             const ExponentsOptions& options) {
  return ExponentComparison(published, item, options).compare(starts);
}

}  // namespace graze::apps
