// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/problem/ending.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/number.hpp>

#include <graze/floquet/attractor/search.hpp>
#include <graze/floquet/orbit/returns.hpp>
#include <graze/floquet/orbit/search_box.hpp>
#include <graze/floquet/orbit/stroboscopic_states.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr int default_settle = 1000, default_returns = 200;  // forcing periods, returns

std::string shown(const Vector& state) { return rounded_state(state, 9); }

std::string periods(int n) { return counted(static_cast<std::size_t>(n), "forcing period"); }

void take(FoundOrbits& found, std::vector<PeriodicOrbit> orbits, const char* origin) {
  std::stable_partition(orbits.begin(), orbits.end(),
                        [](const PeriodicOrbit& o) { return o.admissible == Admissibility::admissible; });
  const bool any = !orbits.empty() && orbits.front().admissible == Admissibility::admissible;
  found.orbits = std::move(orbits);
  found.origin = origin;
  if (any) found.status = Status::done;
}

/// What to do where numbers of such sizes cannot be computed with.
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

/// The orbit that the settled motion repeats, if it does.
std::optional<PeriodicOrbit> settled_orbit(const Problem& problem, const Settled& settled) {
  if (settled.suspected_period == 0) return std::nullopt;
  PeriodicOrbit orbit = shoot(problem.system, problem.parameters, settled.state, settled.suspected_period);
  if (!orbit.converged()) return std::nullopt;
  return orbit;
}

/// What the settled motion is, in words.
std::string attractor(const Settled& settled, const std::optional<PeriodicOrbit>& orbit) {
  if (settled.suspected_period == 0)
    return fmt::format("the motion settled at {} after {} repeats after no period up to {}", shown(settled.state),
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
  add_count(app, "--period", options.period, 1, "orbit of N forcing periods (default: the file's, else 1)", longest_period);
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

Settled settle_down(const Problem& problem, const StartOptions& options, const Console& console) {
  const int wanted = settle_of(problem, options);
  Progress progress(console.err, console.quiet, "settling");
  int done = 0;
  SettleOptions settling;
  settling.periods = wanted;
  settling.cancelled = [&] {
    progress.update(static_cast<double>(done) / std::max(1, wanted),
                    [&] { return fmt::format("{} of {}", done, counted_periods(problem, wanted)); });
    ++done;
    return interrupted();
  };
  settling.flow.cancelled = interrupted;
  return settle(problem.system, problem.parameters, start_state(problem, options), settling);
}

namespace {

void refuse_search(const Problem& problem, const OrbitOptions& options) {
  if (options.search && !is_forced(problem.system))
    throw std::invalid_argument(fmt::format(
        "--search is for forced systems; {} is autonomous: give a state near its orbit by --start", problem.system.name));
}

}  // namespace

FoundOrbits search_for_orbits(const Problem& problem, const OrbitOptions& options, const Console& console) {
  FoundOrbits found;
  const int period = period_of(problem, options);
  Progress progress(console.err, console.quiet, "searching");
  SearchOptions search;
  search.seed = static_cast<unsigned>(options.seed);
  search.cancelled = interrupted;
  search.progress = [&](int starts, int orbits) {
    progress.update(-1.0, [&] {
      return fmt::format("{}, {} of period {}", counted(static_cast<std::size_t>(starts), "start"),
                         counted(static_cast<std::size_t>(orbits), "orbit"), period);
    });
  };
  // The box first, and by runs that can be interrupted: where the forcing is slow, each of them takes its time.
  const SearchBox box = search_box(problem.system, problem.parameters, {.cancelled = interrupted});
  search.lower = box.lower;
  search.upper = box.upper;
  search.max_steps = box.max_steps;
  if (interrupted()) {
    found.status = Status::interrupted;
    found.message = fmt::format("{} before the first start of the search for orbits of period {}", interruption(), period);
    return found;
  }
  if (box.ended != Termination::time) {
    const std::string singularity = singularity_text(problem, box.ended, rest_state(problem, problem.parameters));
    found.message = fmt::format(
        "no motion from rest or beside it can be carried over one forcing period: {}",
        singularity.empty() ? fmt::format("{}; {}", termination_text(box.ended), extreme_parameter(problem)) : singularity);
    return found;
  }
  SearchResult result = search_orbits(problem.system, problem.parameters, period, search);
  for (PeriodicOrbit& orbit : result.orbits) orbit.checks.finite_difference = finite_difference_check(problem.system, orbit);
  const std::size_t count = result.orbits.size();
  take(found, std::move(result.orbits), "search");
  if (interrupted()) {
    found.status = Status::interrupted;
    found.message = fmt::format("{} after {} of the search; {} of period {} found by then", interruption(),
                                counted(static_cast<std::size_t>(result.starts), "start"), counted(count, "orbit"), period);
  } else if (found.status != Status::done) {
    found.message = fmt::format("no admissible orbit of period {} was found by a search of {}", period,
                                counted(static_cast<std::size_t>(result.starts), "start"));
  }
  return found;
}

namespace {

/// The orbit of an autonomous system that the motion settles on, closed after `period` returns.
FoundOrbits find_autonomous(const Problem& problem, const OrbitOptions& options, const Console& console) {
  refuse_search(problem, options);
  const int period = period_of(problem, options);
  const Settled settled = settle_down(problem, options.start, console);
  FoundOrbits found;
  const std::string after = counted_periods(problem, settled.periods);
  if (settled.termination == Termination::interrupted) {
    found.status = Status::interrupted;
    found.message = fmt::format("{} after {}", interruption(), after);
    return found;
  }
  Propagator propagator(problem.system, problem.parameters, {}, {.cancelled = interrupted});
  // The first of them brings the motion to a return, wherever it was before.
  std::vector<Vector> states = stroboscopic_states(propagator, settled.state, static_cast<std::size_t>(period) + 1);
  states.erase(states.begin());
  if (settled.termination != Termination::time || states.size() < static_cast<std::size_t>(period)) {
    found.message = fmt::format("{}: after {} it is at {}; events with a count are returns, or those that begin a contact",
                                termination_text(Termination::no_return), after, shown(settled.state));
    return found;
  }
  ShootingOptions shooting;
  shooting.finite_differences = true;
  PeriodicOrbit orbit = shoot_returns(propagator, states, shooting);
  if (!orbit.converged()) {
    found.message = fmt::format("no orbit of {} was found from {} ({})", counted_periods(problem, period), shown(states.front()),
                                newton_status_text(orbit.newton.status));
    return found;
  }
  take(found, {std::move(orbit)}, "settled");
  return found;
}

}  // namespace

FoundOrbits find_orbits(const Problem& problem, const OrbitOptions& options, const Console& console) {
  if (!is_forced(problem.system)) return find_autonomous(problem, options, console);
  start_state(problem, options.start);  // what is wrong with it is said before anything is computed
  if (options.search) return search_for_orbits(problem, options, console);
  FoundOrbits found;
  const int period = period_of(problem, options);
  found.settled = settle_down(problem, options.start, console);
  const Settled& settled = *found.settled;
  if (settled.termination == Termination::interrupted) {
    found.status = Status::interrupted;
    found.message = fmt::format("{} after {} of {} of transient, at state {}", interruption(), settled.periods,
                                periods(settle_of(problem, options.start)), shown(settled.state));
    return found;
  }
  std::optional<PeriodicOrbit> fallback, attained;
  std::string reached;
  if (settled.termination == Termination::time) {
    ShootingOptions shooting;
    shooting.finite_differences = true;
    PeriodicOrbit orbit = shoot(problem.system, problem.parameters, settled.state, period, shooting);
    const bool wanted = orbit.converged() && orbit.period == period && orbit.admissible == Admissibility::admissible;
    // Without a transient the state is the user's own guess; with one, an unstable orbit is not what the motion settled on.
    if (wanted && (orbit.stable() || settled.suspected_period == period || settle_of(problem, options.start) == 0)) {
      take(found, {orbit}, "settled");
      return found;
    }
    if (wanted) fallback = std::move(orbit);
    attained = settled_orbit(problem, settled);
    reached = attractor(settled, attained);
  } else {
    reached = fmt::format("the transient ended after {}: {}", periods(settled.periods),
                          ending_text(problem, settled.termination, settled.state));
  }
  console.note(fmt::format("{}; searching for orbits of period {}", reached, period));
  FoundOrbits searched = search_for_orbits(problem, options, console);
  searched.settled = found.settled;
  searched.settled_on = std::move(attained);
  searched.remark = reached;
  if (searched.status == Status::failed && fallback) take(searched, {*fallback}, "settled");
  // One place in the file is enough, with its line of the text behind the sentence.
  const bool said = searched.message.find(termination_text(settled.termination)) != std::string::npos ||
                    searched.message.find('\n') != std::string::npos;
  if (searched.status == Status::failed && !said) searched.message += "; " + reached;
  return searched;
}

const Columns<FoundOrbits>& origin_columns() {
  using F = FoundOrbits;
  const auto is_result = [](const F& found) {
    return !found.orbits.empty() && same_orbit(found.orbits.front(), *found.settled_on);
  };
  static const Columns<F> list = {
      {"origin", "whether the orbit is settled on, or found by a search", &F::origin,
       only([](const F& found) { return !found.origin.empty(); })},
      object<F>("settled", "where the transient led to",
                {{"state", "at forcing phase 0", [](const F& found) { return found.settled->state; }},
                 {"periods", "of the transient", [](const F& found) { return found.settled->periods; }},
                 {"suspected_period", "with which it repeats itself; 0: with none",
                  [](const F& found) { return found.settled->suspected_period; }},
                 object<F>("orbit", "that it repeats, where that is not of the period asked for",
                           {{"period", "of it", [](const F& found) { return found.settled_on->period; }},
                            {"impacts", "of it", [](const F& found) { return found.settled_on->impacts; }},
                            {"stable", "whether it is", [](const F& found) { return found.settled_on->stable(); }},
                            {"is_result", "it is the orbit of this result", is_result}})
                     .where([](const F& found) { return found.settled_on.has_value(); })})
          .where([](const F& found) { return found.settled.has_value(); }),
      {"remark", "what the motion settled on, where a search had to follow", &F::remark,
       only([](const F& found) { return !found.remark.empty(); })}};
  return list;
}

}  // namespace graze::apps
