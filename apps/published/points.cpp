// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/published/attractors.hpp>
#include <graze/apps/published/points.hpp>
#include <graze/apps/results/attractor_report.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/number.hpp>

#include <graze/continuation/graph/continuation.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

constexpr double reach = 0.02;  // in eta, within which a printed point is searched for

/// The point of that type nearest to the printed one, on the branches of the orbits on which motions settle around it.
std::optional<SpecialPoint> locate_near(const Published& published, const PublishedPoint& item,
                                        const std::function<bool()>& cancelled) {
  std::optional<SpecialPoint> best;
  for (const double offset : {0.005, -0.005, 0.0}) {
    const Problem problem = problem_of(published, item.system, item.eta + offset);
    AttractorOptions finding;
    finding.lyapunov.cancelled = cancelled;
    const Attractor attractor =
        approach_attractor(problem.system, problem.parameters, start_state(problem, std::nullopt), finding);
    if (!attractor.orbit) continue;
    ContinuationOptions following;
    following.cancelled = cancelled;
    const LocateResult found = locate(problem.system, *attractor.orbit->whole, point_type(item.type), item.eta, reach, following);
    if (found.point && (!best || std::abs(found.point->value - item.eta) < std::abs(best->value - item.eta))) best = found.point;
  }
  return best;
}

/// The orbit of the point's branch at another value of eta.
PeriodicOrbit orbit_at(const Problem& problem, const SpecialPoint& point) {
  return shoot(problem.system, problem.parameters, point.orbit.states, point.orbit.period);
}

bool agree(std::vector<std::complex<double>> computed, const std::vector<std::complex<double>>& printed, int digits) {
  if (computed.size() != printed.size()) return false;
  return std::all_of(printed.begin(), printed.end(), [&](const std::complex<double>& value) {
    const auto found = std::find_if(computed.begin(), computed.end(), [&](const std::complex<double>& mu) {
      return agrees_with_print(mu.real(), 0.0, value.real(), digits) && agrees_with_print(mu.imag(), 0.0, value.imag(), digits);
    });
    if (found == computed.end()) return false;
    computed.erase(found);
    return true;
  });
}

/// Largest distance of a printed multiplier from the nearest computed one.
double distance(const std::vector<std::complex<double>>& computed, const std::vector<std::complex<double>>& printed) {
  double largest = 0.0;
  for (const std::complex<double>& value : printed) {
    double least = HUGE_VAL;
    for (const std::complex<double>& mu : computed) least = std::min(least, std::abs(mu - value));
    largest = std::max(largest, least);
  }
  return largest;
}

std::string text(const std::vector<std::complex<double>>& values, int digits) {
  std::string out;
  for (const std::complex<double>& value : values) out += (out.empty() ? "" : ", ") + rounded(value, digits);
  return out;
}

Comparison compare_value(const Published& published, const PublishedPoint& item, const std::optional<SpecialPoint>& point) {
  Comparison row;
  row.system = item.system;
  row.quantity = item.type;
  row.eta = item.eta;
  row.published = item.eta;
  row.published_text = fmt::format("{:.{}f}", item.eta, item.digits);
  if (!point) {
    row.computed_text = "none";
    add_remark(row.remark, fmt::format("no {} within {} of it", item.type, rounded(reach, 2)));
    return row;
  }
  row.computed = point->value;
  row.uncertainty = point->precision;
  row.computed_text = fmt::format("{:.{}f}", point->value, 12);
  row.verdict = agrees_with_print(point->value, point->precision, item.eta, item.digits) ? Verdict::agrees : Verdict::differs;
  row.details["orbit"] = z_label(point->orbit);
  row.details["state"] = to_json(point->orbit.state);
  row.details["multipliers"] = to_json(point->orbit.multipliers.values);
  if (row.verdict == Verdict::agrees) return row;
  const PeriodicOrbit printed = orbit_at(problem_of(published, item.system, item.eta), *point);
  add_remark(row.remark, fmt::format("it lies {:+.2g} from the printed value, where the orbit's first multiplier is {}",
                                     point->value - item.eta, rounded(printed.multipliers.values.front(), 6)));
  return row;
}

Comparison compare_multipliers(const Published& published, const PublishedPoint& item, const std::optional<SpecialPoint>& point) {
  Comparison row;
  row.system = item.system;
  row.quantity = "multipliers";
  row.eta = item.multipliers_at;
  row.published = to_json(item.multipliers);
  row.published_text = text(item.multipliers, item.digits);
  const Problem problem = problem_of(published, item.system, item.multipliers_at);
  if (!point) {
    row.computed_text = "none";
    add_remark(row.remark, "the point was not found, and so no orbit next to it");
    return row;
  }
  const PeriodicOrbit orbit = orbit_at(problem, *point);
  const std::vector<std::complex<double>>& computed = orbit.multipliers.values;
  row.computed = to_json(computed);
  row.computed_text = fmt::format("{} ({})", text(computed, item.digits), z_label(orbit));
  row.uncertainty = orbit.checks.residual;
  row.verdict = orbit.converged() && agree(computed, item.multipliers, item.digits) ? Verdict::agrees : Verdict::differs;
  if (row.verdict == Verdict::agrees || parameter(problem, "beta") != 0.0) return row;
  // Multipliers of the motion without impact: exp((-b +- i sqrt(1 - b^2)) T).
  const double b = parameter(problem, "b"), T = forcing_period(problem.system, problem.parameters);
  const std::complex<double> free = std::exp(std::complex<double>(-b, std::sqrt(1.0 - b * b)) * T);
  const double off = distance({free, std::conj(free)}, item.multipliers);
  if (off < 0.01 * distance(computed, item.multipliers)) {  // a hundred times nearer than those of the orbit
    add_remark(row.remark,
               fmt::format("the printed ones are those of the motion without impact, exp((-b +- i sqrt(1 - b^2)) T), to "
                           "within {}",
                           rounded(off, 2)));
    const auto end = end_of_impactless(problem);
    if (end && *row.eta > *end)
      add_remark(row.remark, fmt::format("the motion without impact does not exist above eta = {}", rounded(*end, 9)));
  }
  return row;
}

}  // namespace

std::vector<Comparison> compare_point(const Published& published, const PublishedPoint& item,
                                      const std::function<bool()>& cancelled) {
  const std::optional<SpecialPoint> point = locate_near(published, item, cancelled);
  std::vector<Comparison> rows = {compare_value(published, item, point)};
  if (!item.multipliers.empty()) rows.push_back(compare_multipliers(published, item, point));
  return rows;
}

}  // namespace graze::apps
