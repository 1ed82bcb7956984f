// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/attractor_report.hpp>
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

/// Values of the member "unbounded", for a motion that grows without bound.
constexpr std::array growths = {std::pair{Termination::escape, "escape"}, std::pair{Termination::resonance, "resonance"}};

std::string growth_of(const Attractor& attractor) {
  for (const auto& [termination, name] : growths)
    if (attractor.termination == termination) return name;
  return {};
}

/// The member "returns" is false for an autonomous motion that does not return.
bool stays_away(const Attractor& attractor) { return attractor.termination == Termination::no_return; }

}  // namespace

std::string exponent_text(double value, int digits) {
  return std::isfinite(value) ? rounded(value, digits) : std::isnan(value) ? "unknown" : value < 0.0 ? "-infinity" : "infinity";
}

std::string error_text(double value, int digits) { return std::isfinite(value) ? rounded(value, digits) : "unknown"; }

std::optional<double> liouville_residual(const LyapunovSpectrum& spectrum) {
  return spectrum.liouville_residual < 0.0 ? std::nullopt : std::optional(spectrum.liouville_residual);
}

const Columns<LyapunovSpectrum>& spectrum_columns() {
  using S = LyapunovSpectrum;
  static const Columns<S> list = {
      {"exponents [1/time]", "largest first; null: -infinity", [](const S& s) { return finite(s.exponents); }},
      {"standard_errors [1/time]", "of each; null: too short an average", [](const S& s) { return finite(s.standard_errors); }},
      {"correlation_times [periods]", "of each one's growth", [](const S& s) { return finite(s.correlation_times); }},
      {"kaplan_yorke", "dimension", &S::kaplan_yorke},
      {"liouville_residual", "largest disagreement with Liouville's identity, per period; null: not applicable",
       liouville_residual},
      {"periods", "of the average", &S::periods},
      {"impacts", "on the way", &S::impacts},
      {"converged", "the errors are below their bounds", &S::converged},
      {"stop", "why the average ended", [](const S& s) { return std::string(lyapunov_stop_text(s)); }},
      {"duration [time]", "of the average, of an autonomous motion", &S::duration,
       only([](const S& s) { return s.duration > 0.0; })}};
  return list;
}

namespace {

/// The columns of an attractor's orbit, if it has one.
Columns<Attractor> orbit_part() {
  using A = Attractor;
  Columns<A> list =
      joined<A>({sticking_columns<A>(),
                 {{"rests", "the mass is held at its stop all the time", &A::rests, only(&A::rests)},
                  {"duration [time]", "of an autonomous orbit", &A::duration, only([](const A& a) { return a.duration > 0.0; })},
                  {"multipliers", "of the orbit", &A::multipliers, only([](const A&) { return true; })}}});
  for (Column<A>& one : list) one = one.where([holds = one.applies](const A& a) { return !a.multipliers.empty() && holds(a); });
  return list;
}

}  // namespace

const Columns<Attractor>& attractor_columns() {
  using A = Attractor;
  const auto if_periodic = [](const A& attractor, int count) {
    return attractor.period > 0 ? std::optional(count) : std::nullopt;
  };
  const auto conservative = [](const A& attractor) { return attractor.conservative; };
  static const Columns<A> list =
      joined<A>({{{"type", "type of attractor", &A::type},
                  {"period", "of an orbit, else null", [=](const A& a) { return if_periodic(a, a.period); },
                   [](A& a, std::optional<int> value) { a.period = value.value_or(0); }},
                  {"impacts", "of an orbit, else null", [=](const A& a) { return if_periodic(a, a.impacts); },
                   [](A& a, std::optional<int> value) { a.impacts = a.isolated_impacts = value.value_or(0); }},
                  {"state", "on it, at forcing phase 0", &A::state}},
                 orbit_part(),
                 {{"conservative", "nothing dissipates along the motion", &A::conservative, only(conservative)},
                  {"motion", "type of motion without dissipation", &A::motion, only(conservative)},
                  {"unbounded", "how it grows without bound", growth_of,
                   [](A& a, const std::string& value) {
                     for (const auto& [termination, name] : growths)
                       if (value == name) a.termination = termination;
                   },
                   only([](const A& a) { return !growth_of(a).empty(); })},
                  {"returns", "false: an autonomous motion does not come back", [](const A& a) { return !stays_away(a); },
                   [](A& a, bool value) {
                     if (!value) a.termination = Termination::no_return;
                   },
                   only(stays_away)}}});
  return list;
}

Columns<Attractor> exponents_columns() {
  using A = Attractor;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return {{"exponents [1/time]", "largest first; null: -infinity", [](const A& a) { return finite(a.exponents); },
           [=](A& a, const MaybeNumbers& values) { a.exponents = numbers(values, -infinity); }},
          {"standard_errors [1/time]", "of each; 0: from multipliers", [](const A& a) { return finite(a.standard_errors); },
           [=](A& a, const MaybeNumbers& values) { a.standard_errors = numbers(values, -infinity); }}};
}

bool has_states(const Attractor& attractor, std::size_t states) {
  const auto as_many = [&](std::size_t size) { return size == 0 || size == states; };
  return attractor.state.size() == static_cast<Eigen::Index>(states) && as_many(attractor.multipliers.size()) &&
         as_many(attractor.exponents.size()) && as_many(attractor.standard_errors.size());
}

std::string attractor_name(const Attractor& attractor) {
  if (attractor.motion == ConservativeMotion::neutral)
    return "neutral " + (attractor.rests ? std::string("rest") : z_label(attractor.impacts, attractor.period));
  if (attractor.motion != ConservativeMotion::unknown) return std::string(conservative_motion_name(attractor.motion));
  if (const std::string growth = growth_of(attractor); !growth.empty()) return fmt::format("unbounded ({})", growth);
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
  text += fmt::format("  averaged over {} {}: {}\n", average.periods, periods_name(problem), lyapunov_stop_text(average));
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
