// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/results/verification_report.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

const char* verdict(const OrbitCheck& check) { return !check.applicable() ? "not applicable" : check.passes() ? "ok" : "FAILED"; }

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

/// Narrow enough for the head of a column.
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

Json check_json(const OrbitCheck& check) {
  return {{"name", check.name},
          {"disagreement", check.applicable() ? Json(check.disagreement) : Json(nullptr)},
          {"bound", check.limit},
          {"ok", check.passes()}};
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json hard_json(const HardLimit& hard) {
  Json out = {{"stop", hard_limit_stop_text(hard.stop)}};
  if (hard.stop != HardLimitStop::done) return out;
  out["limit"] = {{"state", to_json(hard.limit.state)},
                  {"multipliers", multipliers_json(hard.limit.multipliers)},
                  {"restitution", number(hard.newton_restitution)}};
  out["steps"] = Json::array();
  for (const StiffnessStep& step : hard.steps)
    out["steps"].push_back({{"k_H", step.k_H},
                            {"state", to_json(step.orbit.state)},
                            {"multipliers", multipliers_json(step.orbit.multipliers)},
                            {"state_difference", step.state_difference},
                            {"multiplier_difference", step.multiplier_difference},
                            {"order", number(step.order)}});
  if (hard.restitution.empty()) return out;
  out["entry_tau"] = hard.entry_time;
  out["restitution"] = Json::array();
  for (const RestitutionPoint& point : hard.restitution)
    out["restitution"].push_back({{"speed", point.speed},
                                  {"computed", number(point.computed)},
                                  {"stiff", number(point.stiff)},
                                  {"closed_form", point.closed_form},
                                  {"extrapolated", number(point.extrapolated)},
                                  {"error", number(point.error)}});
  return out;
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
  constexpr std::size_t shown = 4;  // every fourth tells a reader enough; JSON has all
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
      // A disagreement that is not a number is worse than any.
      const bool worse =
          !worst || (check->applicable() && (!worst->check.applicable() || !(check->ratio() <= worst->check.ratio())));
      if (worse && !(worst && std::isnan(worst->check.disagreement))) worst = Largest{*check, i};
    }
    out.push_back(*worst);
  }
  return out;
}

Json verification_json(const Verification& verification) {
  const VerifiedOrbit& verified = verification.verified;
  const PeriodicOrbit& orbit = verified.orbit;
  Json out = {{"value", verification.value}, {"period", orbit.period},
              {"impacts", orbit.impacts},    {"state", to_json(orbit.state)},
              {"stable", orbit.stable()},    {"admissible", orbit.admissible == Admissibility::admissible}};
  out["multipliers"] = {{"saltation", multipliers_json(orbit.multipliers)},
                        {"finite_difference", multipliers_json(verified.differences)},
                        {"general", multipliers_json(verified.general.multipliers)}};
  out["exponents"] = {{"multipliers", exponents_json(orbit.multipliers)},
                      {"time_average", verified.average.exponents},
                      {"periods", verified.average.periods}};
  out["checks"] = Json::array();
  for (const OrbitCheck& check : verification.checks) out["checks"].push_back(check_json(check));
  if (verification.hard) out["hard_limit"] = hard_json(*verification.hard);
  return out;
}

Json largest_json(const std::vector<Largest>& largest, const std::vector<Verification>& list) {
  Json out = Json::array();
  for (const Largest& worst : largest) {
    Json entry = check_json(worst.check);
    entry["value"] = list[worst.at].value;
    entry["orbit"] = worst.at + 1;
    out.push_back(std::move(entry));
  }
  return out;
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
    Table exponents{{"exponent", "from multipliers", fmt::format("average over {} forcing periods", verified.average.periods)},
                    {}};
    for (std::size_t i = 0; i < verified.average.exponents.size(); ++i)
      exponents.rows.push_back(
          {std::to_string(i + 1), rounded(orbit.multipliers.exponents[i], 13), rounded(verified.average.exponents[i], 13)});
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
