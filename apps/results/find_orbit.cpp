// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/problem/ending.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr int default_settle = 1000, default_returns = 200;  // forcing periods, returns

std::string shown(const Vector& state) { return rounded_state(state, 9); }

std::string periods(int n) { return counted(static_cast<std::size_t>(n), "forcing period"); }

/// Advice on parameters whose sizes are beyond computation.
std::string extreme_parameter(const Problem& problem) {
  Eigen::Index farthest = -1;
  const auto orders = [&](Eigen::Index k) { return std::abs(std::log(std::abs(problem.parameters[k]))); };
  for (Eigen::Index k = 0; k < problem.parameters.size(); ++k)
    if (problem.parameters[k] != 0.0 && (farthest < 0 || orders(k) > orders(farthest))) farthest = k;
  if (farthest < 0) return "give other parameters";
  return fmt::format(
      "of the parameters, {} = {} is farthest from 1 in size: give it, or the units of length and time, another size",
      problem.system.parameters[static_cast<std::size_t>(farthest)].name, rounded(problem.parameters[farthest], 9));
}

/// The settled motion in words.
std::string attractor(const Settled& settled, const std::optional<PeriodicOrbit>& orbit) {
  if (settled.suspected_period == 0)
    return fmt::format("the motion is at {} after {} and repeats after no period up to {}", shown(settled.state),
                       periods(settled.periods), SettleOptions{}.max_period);
  return fmt::format("the motion settled at {} repeats after {}{}", shown(settled.state), periods(settled.suspected_period),
                     orbit ? fmt::format(" ({}, {})", z_label(*orbit), orbit->stable() ? "stable" : "unstable") : "");
}

}  // namespace

void add_problem_options(CLI::App& app, StartOptions& options) {
  begin_group(app, "Problem");
  add_text(app, "PROBLEM", options.file, "FILE", "problem file (TOML), such as data/problems/hertz-damped.toml", Need::required);
  add_texts(app, "--set", options.settings, "NAME=VALUE",
            "override a parameter; repeatable, the last one holds; numbers, fractions (36/35) and pi");
}

void add_start_options(CLI::App& app, StartOptions& options) {
  add_problem_options(app, options);
  add_state(app, "--start", options.start, "initial state at forcing phase 0 (default: the file's, else at rest)");
  add_count(app, "--settle", options.settle, 0,
            "forcing periods of transient (default: the file's, else 1000), or returns without forcing (200)");
}

void add_orbit_options(CLI::App& app, OrbitOptions& options) {
  add_start_options(app, options.start);
  add_count(app, "--period", options.period, 1,
            "orbit of N forcing periods, or returns without forcing (default: the file's, else 1)", longest_period);
  add_flag(app, "--search", options.search, "find orbits by global search instead of settling");
  add_count(app, "--seed", options.seed, 0, "of the global search (default 1)");
}

Problem open_problem(const StartOptions& options, const Console& console, const std::vector<std::string>& varied) {
  Problem problem = load_problem(options.file);
  apply_settings(problem, options.settings);
  if (!problem.defaulted.empty()) {
    std::string list;
    for (const std::string& name : problem.defaulted)
      list += fmt::format("{}{} = {}", list.empty() ? "" : ", ", name, rounded(parameter(problem, name), 9));
    console.note(fmt::format("{} does not give {}: these are defaults; give others in its [parameters] or by --set NAME=VALUE",
                             options.file, list));
  }
  if (problem.converted_from) {
    const ConvertedFrom& from = *problem.converted_from;
    std::string list;
    for (const std::string& name : from.obtained)
      list += fmt::format("{}{} = {}", list.empty() ? "" : ", ", name, exact(parameter(problem, name)));
    console.note(fmt::format("{}: {} excitation, tau = {} t, x = X / {}: {}", options.file, from.excitation, exact(from.alpha),
                             exact(from.length), list));
  }
  choose_quantities(problem, varied);
  return problem;
}

Vector start_state(const Problem& problem, const StartOptions& options) {
  return start_state(problem, options.start ? std::optional(state_of(problem, *options.start)) : std::nullopt);
}

int settle_of(const Problem& problem, const StartOptions& options) {
  if (options.settle) return *options.settle;
  return problem.settle.value_or(is_forced(problem.system) ? default_settle : default_returns);
}

int period_of(const Problem& problem, const OrbitOptions& options) {
  return options.period ? *options.period : problem.period.value_or(1);
}

Json options_json(const Problem& problem, const StartOptions& options) {
  return {{"problem", options.file},
          {"set", options.settings},
          {"start", to_json(start_state(problem, options))},
          {"settle", settle_of(problem, options)}};
}

Json options_json(const Problem& problem, const OrbitOptions& options) {
  Json json = options_json(problem, options.start);
  json["period"] = period_of(problem, options);
  json["search"] = options.search;
  json["seed"] = options.seed;
  return json;
}

namespace {

/// The transient of a start, with progress.
SettleOptions settling(const Problem& problem, const StartOptions& options, Progress& progress) {
  SettleOptions out;
  out.periods = settle_of(problem, options);
  out.cancelled = [&problem, &progress, wanted = out.periods, done = 0]() mutable {
    progress.update(static_cast<double>(done) / std::max(1, wanted),
                    [&] { return fmt::format("{} of {}", done, counted_periods(problem, wanted)); });
    ++done;
    return interrupted();
  };
  out.flow.cancelled = interrupted;
  return out;
}

}  // namespace

Settled settle_down(const Problem& problem, const StartOptions& options, const Console& console) {
  Progress progress(console.err, console.quiet, "settling");
  SettleOptions transient = settling(problem, options, progress);
  transient.max_period = 0;  // the period does not matter, and the motion need not last longer than it is asked to
  return settle(problem.system, problem.parameters, start_state(problem, options), transient);
}

namespace {

/// Why a search has found no orbit that is admissible, or was interrupted.
std::string search_message(const Problem& problem, const FoundOrbits& found, int period) {
  if (!found.search && found.cancelled)
    return fmt::format("{} before the first start of the search for orbits of period {}", interruption(), period);
  if (!found.search) {
    const std::string singularity = singularity_text(problem, found.box->ended, rest_state(problem, problem.parameters));
    return fmt::format("no motion from rest or beside it can be carried over one forcing period: {}",
                       singularity.empty() ? fmt::format("{}; {}", termination_text(found.box->ended), extreme_parameter(problem))
                                           : singularity);
  }
  const std::string starts = counted(static_cast<std::size_t>(found.search->starts), "start");
  if (found.cancelled)
    return fmt::format("{} after {} of the search; {} of period {} found by then", interruption(), starts,
                       counted(found.orbits.size(), "orbit"), period);
  return fmt::format("no admissible orbit of period {} was found by a search of {}", period, starts);
}

std::string autonomous_message(const Problem& problem, const FoundOrbits& found, int period) {
  const Settled& settled = *found.settled;
  const std::string after = counted_periods(problem, settled.periods);
  if (found.cancelled) return fmt::format("{} after {}", interruption(), after);
  if (found.attempted)
    return fmt::format("no orbit of {} was found from {} ({})", counted_periods(problem, period), shown(found.attempted->state),
                       found.attempted->newton.status == NewtonStatus::not_run
                           ? "the motion does not return there; --period gives another number of returns"
                           : newton_status_text(found.attempted->newton.status));
  if (found.settled_on) {
    const PeriodicOrbit& orbit = *found.settled_on;
    return fmt::format("no orbit of {} was found from {}; the orbit there repeats after {} ({}, {}): --period {} gives it",
                       counted_periods(problem, period), shown(settled.state), counted_periods(problem, orbit.period),
                       z_label(orbit), orbit.stable() ? "stable" : "unstable", orbit.period);
  }
  if (!found.orbits.empty()) return {};
  return fmt::format("{}: after {} it is at {}; events with a count are returns, or those that begin a contact",
                     termination_text(Termination::no_return), after, shown(settled.state));
}

/// The end of the motion in words.
std::string reached_text(const Problem& problem, const FoundOrbits& found) {
  if (found.settled->termination == Termination::time) return attractor(*found.settled, found.settled_on);
  return fmt::format("the transient ended after {}: {}", periods(found.settled->periods),
                     ending_text(problem, found.settled->termination, found.settled->state));
}

}  // namespace

OrbitResult find_orbits(const Problem& problem, const OrbitOptions& options, const Console& console) {
  const bool forced = is_forced(problem.system);
  if (options.search && !forced)
    throw std::invalid_argument(fmt::format(
        "--search is for forced systems; {} is autonomous: give a state near its orbit by --start", problem.system.name));
  const Vector start = start_state(problem, options.start);  // throws before anything is computed
  FindOrbitOptions finding;
  finding.period = period_of(problem, options);
  finding.any_returns = !options.period && !problem.period;
  finding.search_only = options.search;
  std::optional<Progress> progress;
  progress.emplace(console.err, console.quiet, options.search ? "searching" : "settling");
  finding.settle = settling(problem, options.start, *progress);
  OrbitResult out;
  finding.before_search = [&](const FoundOrbits& found) {
    out.remark = reached_text(problem, found);
    progress.reset();
    console.note(out.remark);  // of several lines if it shows a place in the file
    console.note(fmt::format("searching for orbits of period {}", finding.period));
    progress.emplace(console.err, console.quiet, "searching");
  };
  finding.search.seed = static_cast<unsigned>(options.seed);
  finding.search.all_threads = true;
  finding.search.cancelled = interrupted;
  finding.search.progress = [&](int starts, int orbits) {
    progress->update(-1.0, [&] {
      return fmt::format("{}, {} of period {}", counted(static_cast<std::size_t>(starts), "start"),
                         counted(static_cast<std::size_t>(orbits), "orbit"), finding.period);
    });
  };
  static_cast<FoundOrbits&>(out) = graze::find_orbits(problem.system, problem.parameters, start, finding);
  out.status = out.cancelled ? Status::interrupted : out.found() ? Status::done : Status::failed;
  if (!forced) {
    out.message = autonomous_message(problem, out, finding.period);
    if (!out.settled_on) out.settled.reset();  // results of autonomous systems have it only with the orbit of another period
  } else if (out.cancelled && !out.box) {
    out.message = fmt::format("{} after {} of {} of transient, at state {}", interruption(), out.settled->periods,
                              periods(finding.settle.periods), shown(out.settled->state));
  } else if (out.status != Status::done) {
    out.message = search_message(problem, out, finding.period);
    // One place in the file is enough, with its line of the text behind the sentence.
    const bool said = !out.settled || out.message.find(termination_text(out.settled->termination)) != std::string::npos ||
                      out.message.find('\n') != std::string::npos;
    if (out.status == Status::failed && !said) out.message += "; " + out.remark;
  }
  return out;
}

OrbitResult search_for_orbits(const Problem& problem, const OrbitOptions& options, const Console& console) {
  OrbitOptions searching = options;
  searching.search = true;
  return find_orbits(problem, searching, console);
}

const Columns<OrbitResult>& origin_columns() {
  using F = OrbitResult;
  const auto is_result = [](const F& found) {
    return !found.orbits.empty() && same_orbit(found.orbits.front(), *found.settled_on);
  };
  static const Columns<F> list = {
      {"origin", "whether the orbit is settled on, or found by a search",
       [](const F& found) { return std::string(orbit_origin_name(found.origin)); },
       only([](const F& found) { return found.origin != OrbitOrigin::none; })},
      object<F>("settled", "where the transient led to",
                {{"state", "at forcing phase 0", [](const F& found) { return found.settled->state; }},
                 {"periods", "of the transient", [](const F& found) { return found.settled->periods; }},
                 {"suspected_period", "period of the motion; 0: none recognised",
                  [](const F& found) { return found.settled->suspected_period; }},
                 object<F>("orbit", "orbit that the motion repeats, if of another period than requested",
                           {{"period", "of it", [](const F& found) { return found.settled_on->period; }},
                            {"impacts", "of it", [](const F& found) { return found.settled_on->impacts; }},
                            {"stable", "whether it is", [](const F& found) { return found.settled_on->stable(); }},
                            {"is_result", "it is the orbit of this result", is_result}})
                     .where([](const F& found) { return found.settled_on.has_value(); })})
          .where([](const F& found) { return found.settled.has_value(); }),
      {"remark", "end of the transient, if a search followed", &F::remark,
       only([](const F& found) { return !found.remark.empty(); })}};
  return list;
}

}  // namespace graze::apps
