// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/results/verification_report.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace graze::apps {

namespace {

std::string verdict(const OrbitCheck& check) {
  if (!check.applicable()) return "not applicable: " + check.reason;
  return check.passes() ? "ok" : "FAILED";
}

/// The averaged exponents in the order of the multipliers. The average has the largest first, the orbit of an autonomous system
/// its multiplier 1 last.
std::vector<double> average_by_multiplier(const VerifiedOrbit& verified) {
  const std::vector<double>&exponents = verified.orbit.multipliers.exponents, &average = verified.average.exponents;
  std::vector<std::size_t> order(exponents.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return exponents[a] > exponents[b]; });
  std::vector<double> out(average.size());
  if (order.size() != average.size()) return average;
  for (std::size_t i = 0; i < order.size(); ++i) out[order[i]] = average[i];
  return out;
}

/// Names of all checks that occur, in order.
std::vector<std::string> names_of(const std::vector<Verification>& list) {
  std::vector<std::string> names;
  for (const Verification& verification : list)
    for (const OrbitCheck& check : verification.checks)
      if (std::find(names.begin(), names.end(), check.name) == names.end()) names.push_back(check.name);
  return names;
}

const OrbitCheck* find(const Verification& verification, const std::string& name) {
  for (const OrbitCheck& check : verification.checks)
    if (check.name == name) return &check;
  return nullptr;
}

/// A name short enough for a column heading.
std::string short_name(std::string name) {
  for (const auto& [longer, shorter] : {std::pair{"finite differences", "differences"},
                                        {"multipliers: ", "mu "},
                                        {"hard limit: ", "hard "},
                                        {"GSL: ", "GSL "},
                                        {"Newton's law", "Newton"}}) {
    const std::size_t at = name.find(longer);
    if (at != std::string::npos) name.replace(at, std::string(longer).size(), shorter);
  }
  return name;
}

std::string cell(double value, int digits = 8) { return std::isfinite(value) ? rounded(value, digits) : "-"; }

std::string hard_text(const HardLimit& hard) {
  if (hard.stop != HardLimitStop::done) return fmt::format("hard limit: {}\n", hard_limit_stop_text(hard.stop));
  std::string text = fmt::format("hard limit: orbit at {}{}\n", rounded_state(hard.limit.state),
                                 std::isfinite(hard.newton_restitution)
                                     ? fmt::format(", that of Newton's law with k_r = {}", rounded(hard.newton_restitution))
                                     : std::string());
  Table steps{{"k_H", "state difference", "multiplier difference", "order"}, {}};
  for (const StiffnessStep& step : hard.steps)
    steps.rows.push_back(
        {rounded(step.k_H, 6), cell(step.state_difference, 5), cell(step.multiplier_difference, 5), cell(step.order, 6)});
  text += aligned(steps);
  if (hard.restitution.empty()) return text;
  Table speeds{{"entry speed", "restitution", "at the largest k_H", "extrapolated", "closed form"}, {}};
  constexpr std::size_t shown = 4;  // every fourth is enough for a reader; JSON has all
  for (std::size_t i = shown - 1; i < hard.restitution.size(); i += shown) {
    const RestitutionPoint& point = hard.restitution[i];
    speeds.rows.push_back({cell(point.speed, 6), cell(point.computed), cell(point.stiff), cell(point.extrapolated, 10),
                           cell(point.closed_form, 10)});
  }
  return text + fmt::format("\ncontacts entered at tau = {}\n", rounded(hard.entry_time, 6)) + aligned(speeds);
}

std::string z_of(const PeriodicOrbit& orbit) { return label(orbit.impacts, orbit.isolated_impacts, orbit.period); }

}  // namespace

bool Verification::agrees() const {
  return std::all_of(checks.begin(), checks.end(), [](const OrbitCheck& check) { return check.passes(); });
}

std::vector<Largest> largest_of(const std::vector<Verification>& list) {
  std::vector<Largest> out;
  for (const std::string& name : names_of(list)) {
    std::optional<Largest> worst;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const OrbitCheck* check = find(list[i], name);
      if (check == nullptr) continue;
      // A disagreement that is NaN is worse than any number.
      const bool worse =
          !worst || (check->applicable() && (!worst->check.applicable() || !(check->ratio() <= worst->check.ratio())));
      if (worse && !(worst && std::isnan(worst->check.disagreement))) worst = Largest{*check, i};
    }
    out.push_back(*worst);
  }
  return out;
}

const Columns<OrbitCheck>& verified_columns() {
  using C = OrbitCheck;
  static const Columns<C> list = {
      {"name", "of the check", &C::name},
      {"disagreement", "null: not applicable",
       [](const C& check) { return check.applicable() ? std::optional(check.disagreement) : std::nullopt; }},
      {"bound", "largest allowed disagreement", &C::limit},
      {"ok", "it has not failed", &C::passes},
      {"reason", "why it is not applicable", &C::reason, only([](const C& check) { return !check.applicable(); })}};
  return list;
}

const Columns<StiffnessStep>& step_columns() {
  using S = StiffnessStep;
  static const Columns<S> list = {{"k_H", "contact stiffness", &S::k_H},
                                  {"state", "of the orbit, at forcing phase 0", [](const S& step) { return step.orbit.state; }},
                                  {"multipliers", "of the orbit", [](const S& step) { return step.orbit.multipliers; }},
                                  {"state_difference", "from the limit, relative to 1 + |x|", &S::state_difference},
                                  {"multiplier_difference", "from the limit, relative to 1 + |mu_1|", &S::multiplier_difference},
                                  {"order", "log10 of the state difference a decade softer over this one; null: of the first",
                                   [](const S& step) { return finite(step.order); }}};
  return list;
}

const Columns<RestitutionPoint>& restitution_columns() {
  using P = RestitutionPoint;
  static const Columns<P> list = {
      {"speed [speed]", "of entry", &P::speed},
      {"computed", "at the problem's own k_H; null: the contact does not end", [](const P& p) { return finite(p.computed); }},
      {"stiff", "at the largest k_H", [](const P& p) { return finite(p.stiff); }},
      {"closed_form", "of a contact that is infinitely stiff", &P::closed_form},
      {"extrapolated", "from all k_H", [](const P& p) { return finite(p.extrapolated); }},
      {"error", "of the extrapolation", [](const P& p) { return finite(p.error); }}};
  return list;
}

const Columns<HardLimit>& hard_limit_columns() {
  using H = HardLimit;
  const auto is_done = [](const H& hard) { return hard.stop == HardLimitStop::done; };
  const auto has_restitution = [=](const H& hard) { return is_done(hard) && !hard.restitution.empty(); };
  static const Columns<H> list = {
      {"stop", "how its computation ended", [](const H& hard) { return std::string(hard_limit_stop_text(hard.stop)); }},
      object<H>(
          "limit", "the orbit at a rigid stop",
          {{"state", "at forcing phase 0", [](const H& hard) { return hard.limit.state; }},
           {"multipliers", "of the orbit", [](const H& hard) { return hard.limit.multipliers; }},
           {"restitution", "of its impacts; null: they differ", [](const H& hard) { return finite(hard.newton_restitution); }}})
          .where(is_done),
      {"steps", "orbits of growing stiffness, softest first", &H::steps, only(is_done)},
      {"entry_tau [time]", "time at which the contacts below begin", &H::entry_time, only(has_restitution)},
      {"restitution", "by entry speed", &H::restitution, only(has_restitution)}};
  return list;
}

const Columns<Verification>& verification_columns() {
  using V = Verification;
  static const Columns<V> list = {
      {"value", "of the parameter", &V::value},
      {"period", "forcing periods, or returns of an autonomous orbit", [](const V& v) { return v.verified.orbit.period; }},
      {"impacts", "number of impacts", [](const V& v) { return v.verified.orbit.impacts; }},
      {"state", "at forcing phase 0", [](const V& v) { return v.verified.orbit.state; }},
      {"stable", "no multiplier lies outside the unit circle", [](const V& v) { return v.verified.orbit.stable(); }},
      {"admissible", "it does not pass through a barrier",
       [](const V& v) { return v.verified.orbit.admissible == Admissibility::admissible; }},
      object<V>("multipliers", "in three ways",
                {{"saltation", "by saltation matrices", [](const V& v) { return v.verified.orbit.multipliers; }},
                 {"finite_difference", "by differences of the return map", [](const V& v) { return v.verified.differences; }},
                 {"general", "by the general integrator", [](const V& v) { return v.verified.general.multipliers; }}}),
      object<V>(
          "exponents", "in two ways",
          {{"multipliers [1/time]", "from multipliers; null: -infinity",
            [](const V& v) { return exponents_of(v.verified.orbit.multipliers); }},
           {"time_average [1/time]", "null: -infinity", [](const V& v) { return finite(average_by_multiplier(v.verified)); }},
           {"periods", "of the average", [](const V& v) { return v.verified.average.periods; }}}),
      {"checks", "each of them", &V::checks},
      {"hard_limit", "the stop made rigid", &V::hard, only([](const V& v) { return v.hard.has_value(); })}};
  return list;
}

Columns<Largest> largest_columns(const std::vector<Verification>& list) {
  return joined<Largest>({of_part(verified_columns(), &Largest::check),
                          {{"value", "of the parameter", [&list](const Largest& worst) { return list[worst.at].value; }},
                           {"orbit", "its number, from 1", [](const Largest& worst) { return worst.at + 1; }}}});
}

std::string verification_text(const Verification& verification) {
  const VerifiedOrbit& verified = verification.verified;
  const PeriodicOrbit& orbit = verified.orbit;
  std::string text =
      fmt::format("orbit {} at {}, {}\n", z_label(orbit), rounded_state(orbit.state), orbit.stable() ? "stable" : "unstable");
  Table values{{"multiplier", "saltation, product form", "finite differences", "general integrator (GSL)"}, {}};
  for (std::size_t i = 0; i < orbit.multipliers.values.size(); ++i) {
    const auto entry = [i](const FloquetMultipliers& list) { return i < list.values.size() ? rounded(list.values[i], 15) : "-"; };
    values.rows.push_back(
        {std::to_string(i + 1), entry(orbit.multipliers), entry(verified.differences), entry(verified.general.multipliers)});
  }
  text += aligned(values) + "\n";
  if (verified.average.periods > 0) {
    const bool counts_returns = orbit.multipliers.section == Section::autonomous;
    Table exponents{{"exponent", "from multipliers",
                     fmt::format("average over {} {}", verified.average.periods, counts_returns ? "returns" : "forcing periods")},
                    {}};
    const std::vector<double> average = average_by_multiplier(verified);
    for (std::size_t i = 0; i < average.size(); ++i)
      exponents.rows.push_back({std::to_string(i + 1), rounded(orbit.multipliers.exponents[i], 13), rounded(average[i], 13)});
    text += aligned(exponents) + "\n";
  }
  Table checks{{"check", "disagreement", "bound", "verdict"}, {}};
  for (const OrbitCheck& check : verification.checks)
    checks.rows.push_back(
        {check.name, check.applicable() ? rounded(check.disagreement, 3) : "-", rounded(check.limit, 3), verdict(check)});
  text += aligned(checks);
  return verification.hard ? text + "\n" + hard_text(*verification.hard) : text;
}

std::string range_text(const std::vector<Verification>& list, const std::string& parameter) {
  const std::vector<std::string> names = names_of(list);
  const std::vector<Largest> largest = largest_of(list);
  const auto disagreement = [](const OrbitCheck* check) {
    return check != nullptr && check->applicable() ? fmt::format("{:.1e}{}", check->disagreement, check->passes() ? "" : "!")
                                                   : "-";
  };
  Table rows{{parameter, "z", "stable"}, {}};
  for (const std::string& name : names) rows.columns.push_back(short_name(name));
  for (const Verification& verification : list) {
    std::vector<std::string> cells = {rounded(verification.value, 9), z_of(verification.verified.orbit),
                                      verification.verified.orbit.stable() ? "yes" : "no"};
    for (const std::string& name : names) cells.push_back(disagreement(find(verification, name)));
    rows.rows.push_back(std::move(cells));
  }
  std::vector<std::string> last = {"largest", "", ""};
  for (const Largest& worst : largest) last.push_back(disagreement(&worst.check));
  rows.rows.push_back(std::move(last));
  Table verdicts{{"check", "largest disagreement", "bound", parameter, "verdict"}, {}};
  for (const Largest& worst : largest)
    verdicts.rows.push_back({worst.check.name, worst.check.applicable() ? rounded(worst.check.disagreement, 3) : "-",
                             rounded(worst.check.limit, 3), worst.check.applicable() ? rounded(list[worst.at].value, 9) : "-",
                             verdict(worst.check)});
  return aligned(rows) + "\nthe largest in units of its bound (which may depend on the orbit)\n" + aligned(verdicts);
}

Table checks_table(const std::vector<Verification>& list, const std::string& parameter) {
  Table table{{"orbit", parameter, "check", "disagreement", "bound", "ok"}, {}};
  for (std::size_t i = 0; i < list.size(); ++i)
    for (const OrbitCheck& check : list[i].checks)
      table.rows.push_back({std::to_string(i + 1), exact(list[i].value), check.name,
                            check.applicable() ? exact(check.disagreement) : "", exact(check.limit),
                            check.passes() ? "yes" : "no"});
  return table;
}

}  // namespace graze::apps
