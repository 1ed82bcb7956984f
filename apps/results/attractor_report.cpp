// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/attractor_report.hpp>
#include <graze/apps/results/branch_reading.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/apps/text/table.hpp>

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace graze::apps {

namespace {

Json number_json(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

/// Member "unbounded" of a motion that grows without bound.
constexpr std::array growths = {std::pair{Termination::escape, "escape"}, std::pair{Termination::resonance, "resonance"}};

/// Member "returns" of an autonomous motion that does not return: false.
bool stays_away(const Attractor& attractor) { return attractor.termination == Termination::no_return; }

}  // namespace

std::string exponent_text(double value, int digits) {
  return std::isfinite(value) ? rounded(value, digits) : std::isnan(value) ? "unknown" : value < 0.0 ? "-infinity" : "infinity";
}

std::string error_text(double value, int digits) { return std::isfinite(value) ? rounded(value, digits) : "unknown"; }

Json numbers_json(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(number_json(value));
  return list;
}

std::vector<double> numbers_of(const Json& json) {
  std::vector<double> list;
  for (const Json& item : json) list.push_back(item.is_null() ? -std::numeric_limits<double>::infinity() : item.get<double>());
  return list;
}

Json spectrum_json(const LyapunovSpectrum& spectrum) {
  Json json = {{"exponents", numbers_json(spectrum.exponents)},
               {"standard_errors", numbers_json(spectrum.standard_errors)},
               {"correlation_times", numbers_json(spectrum.correlation_times)},
               {"kaplan_yorke", spectrum.kaplan_yorke},
               {"liouville_residual", spectrum.liouville_residual < 0.0 ? Json(nullptr) : Json(spectrum.liouville_residual)},
               {"periods", spectrum.periods},
               {"impacts", spectrum.impacts},
               {"converged", spectrum.converged()},
               {"stop", lyapunov_stop_text(spectrum.stop)}};
  if (spectrum.duration > 0.0) json["duration"] = spectrum.duration;
  return json;
}

void write_attractor(const Attractor& attractor, JsonText& json) {
  const auto if_periodic = [&](int count) { return attractor.period > 0 ? std::optional(count) : std::nullopt; };
  json.begin_object();
  json.member("type", attractor_type_name(attractor.type));
  json.member("period", if_periodic(attractor.period));
  json.member("impacts", if_periodic(attractor.impacts));
  json.member("state", attractor.state);
  if (!attractor.multipliers.empty()) {
    write_sticking(attractor.impacts, attractor.isolated_impacts, json);
    if (attractor.rests) json.member("rests", true);
    if (attractor.duration > 0.0) json.member("duration", attractor.duration);
    json.member("multipliers", attractor.multipliers);
  }
  if (attractor.conservative) {
    json.member("conservative", true);
    json.member("motion", conservative_motion_name(attractor.motion));
  }
  for (const auto& [termination, name] : growths)
    if (attractor.termination == termination) json.member("unbounded", name);
  if (stays_away(attractor)) json.member("returns", false);
  json.end_object();
}

Json attractor_json(const Attractor& attractor) {
  return tree_of([&](JsonText& json) { write_attractor(attractor, json); });
}

Attractor attractor_of(const Json& json) {
  Attractor out;
  for (const AttractorType type : {AttractorType::periodic, AttractorType::chaotic})
    if (json.at("type") == attractor_type_name(type)) out.type = type;
  if (json.at("period").is_number()) out.period = json["period"];
  if (json.at("impacts").is_number()) out.impacts = json["impacts"];
  out.state = vector_from(json.at("state"));
  out.termination = Termination::time;
  for (const auto& [termination, name] : growths)
    if (json.value("unbounded", "") == name) out.termination = termination;
  if (!json.value("returns", true)) out.termination = Termination::no_return;
  out.isolated_impacts = json.value("isolated_impacts", out.impacts);
  out.rests = json.value("rests", false);
  out.duration = json.value("duration", 0.0);
  out.conservative = json.value("conservative", false);
  using enum ConservativeMotion;
  for (const ConservativeMotion motion : {neutral, island, chaotic_sea})
    if (json.value("motion", "") == conservative_motion_name(motion)) out.motion = motion;
  if (json.contains("multipliers")) out.multipliers = multipliers_from(json["multipliers"]).values;
  return out;
}

std::string attractor_name(const Attractor& attractor) {
  if (attractor.motion == ConservativeMotion::neutral)
    return "neutral " + (attractor.rests ? std::string("rest") : z_label(attractor.impacts, attractor.period));
  if (attractor.motion != ConservativeMotion::unknown) return std::string(conservative_motion_name(attractor.motion));
  for (const auto& [termination, name] : growths)
    if (attractor.termination == termination) return fmt::format("unbounded ({})", name);
  if (stays_away(attractor)) return "no return";
  if (attractor.type != AttractorType::periodic) return std::string(attractor_type_name(attractor.type));
  if (attractor.rests) return "at rest";
  return z_label(attractor.impacts, attractor.isolated_impacts, attractor.period);
}

namespace {

const char* conservative_text(ConservativeMotion motion) {
  switch (motion) {
  case ConservativeMotion::unknown:
    break;
  case ConservativeMotion::neutral:
    return "the orbit is elliptic, and motions beside it stay beside it";
  case ConservativeMotion::island:
    return "the motion is quasi-periodic: its tangent has grown no faster than by shear";
  case ConservativeMotion::chaotic_sea:
    return "the tangent of the motion has grown by more than shear makes it";
  }
  return "the average is too short to tell an island from the chaotic sea";
}

}  // namespace

std::string attractor_text(const Problem& problem, const Attractor& attractor, int max_period) {
  std::string text;
  const bool forced = is_forced(problem.system);
  if (attractor.conservative) {
    text = fmt::format("{}: nothing dissipates here (Liouville's sum is zero), so there is no attractor; {}\n",
                       attractor_name(attractor), conservative_text(attractor.motion));
  } else if (attractor.rests) {
    text = "at rest: " + rest_text(attractor.exponents) + "\n";
  } else if (attractor.type == AttractorType::periodic) {
    text = fmt::format("periodic, {}: exponents ln|mu| / {} of its multipliers{}\n", attractor_name(attractor),
                       forced ? "(nT)" : "T",
                       forced ? ""
                              : fmt::format(", T = {}, the time of {}", rounded(attractor.duration, 12),
                                            counted_periods(problem, attractor.period)));
  } else if (attractor.type == AttractorType::chaotic) {
    text = fmt::format("chaotic: the first exponent is positive by {} standard errors\n",
                       rounded(attractor.exponents[0] / attractor.standard_errors[0], 3));
  } else {
    text = fmt::format("undecided: no stable orbit of up to {} {} (--max-period) is reached, nor is the first exponent "
                       "positive by several standard errors\n",
                       max_period, periods_name(problem));
  }
  text += fmt::format("  state {}   {}\n\n", forced ? "at forcing phase 0" : "behind a return",
                      state_text(problem, attractor.state, 12));
  const bool periodic = attractor.type == AttractorType::periodic;
  Table table{{"exponent", "value"}, {}};
  if (!periodic) table.columns.push_back("standard error");
  if (periodic) table.columns.insert(table.columns.end(), {"time average", "standard error"});
  const LyapunovSpectrum& average = attractor.time_average;
  for (std::size_t i = 0; i < attractor.exponents.size(); ++i) {
    std::vector<std::string> row = {std::to_string(i + 1), exponent_text(attractor.exponents[i], periodic ? 12 : 6)};
    if (periodic) row.push_back(i < average.exponents.size() ? exponent_text(average.exponents[i], 6) : "-");
    row.push_back(i < average.standard_errors.size() ? error_text(average.standard_errors[i], 2) : "-");
    table.rows.push_back(std::move(row));
  }
  text += aligned(table);
  if (average.periods == 0) return text;
  if (!periodic) text += fmt::format("  Kaplan-Yorke dimension {}\n", rounded(kaplan_yorke_dimension(attractor.exponents), 6));
  if (average.liouville_residual >= 0.0)
    text += fmt::format("  Liouville residual {} per period (bound 1e-10, {})\n", rounded(average.liouville_residual, 2),
                        average.liouville_residual < 1e-10 ? "ok" : "FAILED");
  text += fmt::format("  averaged over {} {}: {}\n", average.periods, periods_name(problem), lyapunov_stop_text(average.stop));
  if (periodic && !average.exponents.empty()) {
    constexpr double too_many = 5.0, rounding = 1e-13;
    const double difference = std::abs(average.exponents[0] - attractor.exponents[0]);
    const double apart = difference / average.standard_errors[0];
    if (std::isfinite(apart) && apart > too_many && difference > rounding)
      text += fmt::format("  it differs from the orbit's first exponent by {} standard errors: part of it was the way there\n",
                          rounded(apart, 3));
  }
  return text;
}

}  // namespace graze::apps
