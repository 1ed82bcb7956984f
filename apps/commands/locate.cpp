// SPDX-License-Identifier: GPL-3.0-or-later
// graze locate: one special point to full precision.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/output/notes.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/results/branch_report.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/number.hpp>

#include <graze/continuation/graph/branch_graph.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>

namespace graze::apps {

namespace {

struct LocateArguments {
  OrbitOptions orbit;
  std::string type, parameter;
  std::optional<double> near, reach, from;
  std::vector<std::string> quantities;
  OutputOptions output;
};

/// Types of points with a dynamical meaning; EP, UZ and MX only mark events of a computation.
const std::vector<std::string>& locatable() {
  static const std::vector<std::string> list = {"PD", "LP", "BP", "NS", "GR"};
  return list;
}

/// Largest distance of a point from --near: a twentieth of the value, 0.005 of zero.
double default_reach(double near) { return near == 0.0 ? 0.005 : 0.05 * std::abs(near); }

Json all_options(const Problem& problem, const LocateArguments& options, double reach) {
  Json json = options_json(problem, options.orbit);
  json["type"] = options.type;
  json["param"] = options.parameter;
  json["near"] = *options.near;
  json["reach"] = reach;
  if (options.from) json["from"] = *options.from;
  return json;
}

/// Shares of the reach at which orbits are sought on both sides of --near: a branch may end close to it, or not come close.
constexpr std::array shares_of_reach = {1.0 / 64.0, 1.0 / 16.0, 0.25, 0.5, 0.75, 1.0};
/// A point farther from --near than this share of the reach is not the intended one.
constexpr double meant_share = 0.1;

/// The problem at the values where orbits are sought, nearest first; only at --from if that is given.
std::vector<Problem> places(const Problem& problem, const LocateArguments& options, double reach) {
  std::vector<Problem> list = {problem};
  if (options.from) return list;
  for (const double share : shares_of_reach)
    for (const double side : {-1.0, 1.0}) {
      Problem at = problem;
      try {
        set_parameter(at, options.parameter, *options.near + side * share * reach);
      } catch (const std::invalid_argument&) {  // outside the model's range
        continue;
      }
      list.push_back(std::move(at));
    }
  return list;
}

/// One unit of the last written digit of a value: 0.01 for 0.92.
double last_digit(double value) {
  const std::string text = exact(value);
  const std::size_t exponent = std::min(text.find('e'), text.size()), point = std::min(text.find('.'), exponent);
  const int decimals = point < exponent ? static_cast<int>(exponent - point) - 1 : 0;
  return std::pow(10.0, (exponent < text.size() ? std::stoi(text.substr(exponent + 1)) : 0) - decimals);
}

/// Whether a point lies as close to --near as its digits suggest.
bool is_intended(const SpecialPoint& point, double near, double reach) {
  return std::abs(point.value - near) <= std::min(last_digit(near), meant_share * reach) + point.precision;
}

/// The branches found, and the requested point on them.
struct Located {
  OrbitResult first;  ///< orbits at the first value
  std::vector<Branch> branches;
  LocateResult nearest;
};

/// Follows each orbit that lies on no known branch, until the intended point is found.
class PointSearch {
 public:
  PointSearch(const Problem& problem, const LocateArguments& options, double reach, const Console& console)
      : problem_(problem), options_(options), reach_(reach), progress_(console.err, console.quiet, "locating") {
    continuation_.parameter = options.parameter;
    continuation_.cancelled = interrupted;
    continuation_.progress = [this](const Branch& branch) {
      progress_.update(-1.0, [&] {
        return fmt::format("{}, {} = {}", counted(branch.points.size(), "point"), branch.parameter,
                           rounded(branch.points.back().value, 7));
      });
    };
  }

  /// True if the point is there.
  bool follow(const OrbitResult& found) {
    for (const PeriodicOrbit& orbit : found.orbits) {
      if (interrupted()) return true;
      if (orbit.admissible != Admissibility::admissible || is_known(orbit)) continue;
      for (Branch& branch : follow_near(problem_.system, orbit, *options_.near, reach_, continuation_))
        branches.push_back(std::move(branch));
      nearest = nearest_point(problem_.system, branches, options_.parameter, point_type(options_.type), *options_.near, reach_);
      if (nearest.point && is_intended(*nearest.point, *options_.near, reach_)) return true;
    }
    return interrupted();
  }

  std::vector<Branch> branches;
  LocateResult nearest;

 private:
  bool is_known(const PeriodicOrbit& orbit) const {
    const std::size_t parameter = parameter_index(problem_.system.parameters, options_.parameter);
    const double value = orbit.parameters[static_cast<Eigen::Index>(parameter)];
    return std::any_of(branches.begin(), branches.end(),
                       [&](const Branch& branch) { return branch_contains(problem_.system, branch, orbit.states, value); });
  }

  const Problem& problem_;
  const LocateArguments& options_;
  double reach_;
  Progress progress_;
  ContinuationOptions continuation_;
};

/// Seeks orbits at every place, by settling and by searching.
Located locate_near(const Problem& problem, const LocateArguments& options, double reach, const Console& console) {
  Located out;
  PointSearch hunt(problem, options, reach, console);
  const Console silent{console.out, console.err, true, console.threads};
  const auto look_at = [&](const Problem& place, bool is_first) {
    try {
      const OrbitResult found = find_orbits(place, options.orbit, is_first ? console : silent);
      if (is_first) out.first = found;
      if (hunt.follow(found)) return true;
      if (found.origin != OrbitOrigin::settled || !is_forced(problem.system))
        return false;                         // of other systems there is no search
    } catch (const std::invalid_argument&) {  // the start lies inside the barrier there
      if (is_first) throw;
    }
    if (is_first)
      console.note(fmt::format("{}; searching for other orbits of period {}",
                               hunt.nearest.point ? "another point may lie nearer" : hunt.nearest.message,
                               period_of(problem, options.orbit)));
    return hunt.follow(search_for_orbits(place, options.orbit, silent));
  };
  bool is_first = true;
  for (const Problem& place : places(problem, options, reach)) {
    if (look_at(place, is_first)) break;
    is_first = false;
  }
  out.branches = std::move(hunt.branches);
  out.nearest = std::move(hunt.nearest);
  return out;
}

/// How the point differs from the requested one; empty: not at all.
std::string remark(const Located& located, const LocateArguments& options, double reach) {
  const SpecialPoint& point = *located.nearest.point;
  std::vector<std::string> parts;
  const double distance = std::abs(point.value - *options.near);
  if (!is_intended(point, *options.near, reach))
    parts.push_back(fmt::format("the nearest {} lies {} from --near {}, farther than {}", options.type, rounded(distance, 3),
                                exact(*options.near),
                                distance > meant_share * reach ? "a tenth of the reach" : "its digits suggest"));
  const std::vector<PeriodicOrbit>& there = located.first.orbits;
  const auto has_its_label = [&](const PeriodicOrbit& orbit) { return z_label(orbit) == z_label(point.orbit); };
  if (!there.empty() && point.type != PointType::GR && std::none_of(there.begin(), there.end(), has_its_label))
    parts.push_back(fmt::format("it is of {}, as no orbit found at --near is (the first is {})", z_label(point.orbit),
                                z_label(there.front())));
  if (interrupted()) parts.push_back(interruption() + " before all of the reach was looked at");
  return fmt::format("{}", fmt::join(parts, "; "));
}

int run(const LocateArguments& given, const Console& console) {
  LocateArguments options = given;
  const OutputFolder folder(options.output, "locate", options.orbit.start.file);
  Problem problem = open_problem(options.orbit.start, console, {options.parameter});
  options.parameter = parameter_name(problem, options.parameter);
  if (!std::isfinite(*options.near))
    throw std::invalid_argument(fmt::format("--near {}: must be a finite number, for example 0.92", *options.near));
  const double reach = options.reach.value_or(default_reach(*options.near));
  if (!(reach > 0.0)) throw std::invalid_argument(fmt::format("--reach {}: must be > 0, for example 0.01", reach));
  set_parameter(problem, options.parameter, options.from.value_or(*options.near), options.from ? "--from" : "--near");

  const Quantities quantities = read_quantities(problem, options.quantities);
  Json asked = all_options(problem, options, reach);
  put_quantity_option(asked, options.quantities);
  Result result;
  result.json = result_head("point/1", "locate", problem, asked);
  folder.check_free_for(result.json);
  const Located located = locate_near(problem, options, reach, console);
  const std::optional<SpecialPoint>& point = located.nearest.point;
  const Status status = point ? Status::done : interrupted() ? Status::interrupted : Status::failed;
  const std::string message = point                       ? remark(located, options, reach)
                              : interrupted()             ? interruption() + " before a point was located"
                              : !located.branches.empty() ? located.nearest.message
                              : options.from              ? located.first.message
                                             : located.first.message + "; at other values within the reach there is none either";
  set_status(result.json, status, message);
  result.json.update(json_of(origin_columns(), located.first));
  result.json["special_point"] = point ? json_of(*point) : Json(nullptr);
  result.text = describe(problem, options.parameter) + "\n\n";
  if (point) {
    const QuantityValues measured = measure(quantities, problem.system, point->orbit);
    put_quantities(result.json["special_point"], measured);
    result.text += special_point_text(*point, options.parameter) + "\n" +
                   orbit_text(problem, point->orbit, stability_text(*point)) + quantities_text(measured);
    if (!message.empty()) result.text += "\n" + message + "\n";
    Problem at_point = problem;
    at_point.parameters = point->orbit.parameters;
    add_notes(result, branch_notes(at_point, point->orbit));
    result.table = orbits_table(problem, {point->orbit}, false, {measured});
    const auto stable =
        std::find(result.table.columns.begin(), result.table.columns.end(), "stable") - result.table.columns.begin();
    result.table.rows.front()[static_cast<std::size_t>(stable)] = stable_cell(stable_at(*point));
    result.table.columns.insert(result.table.columns.begin(), {"label", options.parameter, "precision"});
    result.table.rows.front().insert(result.table.rows.front().begin(),
                                     {point->label, exact(point->value), exact(point->precision)});
  }
  if (status != Status::done) console.err << "graze locate: " << message << "\n";
  if (status == Status::done && !message.empty()) console.note(message);
  return deliver(result, options.output, "locate", exit_code(status), console);
}

Json locate_result_schema() {
  return result_schema(
      "point/1", "a special point of a branch",
      {schema_of(origin_columns()), object_schema({{"special_point", "null: there is none", or_null(special_point_schema())}})});
}

std::function<int(const Console&)> set_up_locate(CLI::App& app) {
  auto options = std::make_shared<LocateArguments>();
  add_orbit_options(app, options->orbit);
  begin_group(app, "Point");
  add_choice(app, "--type", options->type, locatable(), "type of the point", Need::required);
  add_text(app, "--param", options->parameter, "NAME", "continuation parameter (default: the forcing frequency)");
  add_number(app, "--near", options->near, "value of the parameter near the point", Need::required);
  add_number(app, "--reach", options->reach, "largest distance from --near (default: 5 % of it, or 0.005 of 0)");
  add_number(app, "--from", options->from, "value at which orbits are sought (default: --near, then both sides of it)");
  add_quantity_option(app, options->quantities);
  add_output_options(app, options->output, "point/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command locate_command() {
  return {
      "locate",
      "one special point to full precision",
      "Orbits are found at --near and on both sides of it, as by `graze orbit` and by search, and followed both ways within\n"
      "--reach; the point of the given type that lies nearest to --near is located by Newton's method on an extended system.\n"
      "The first that agrees with the digits of --near ends the search; the result says so where none does. If no such point\n"
      "is found: exit 1, and the points found instead.",
      {"graze locate data/problems/hertz-damped.toml --type PD --param eta --near 0.92",
       "graze locate data/problems/hertz-damped.toml --type PD --near 0.7433 --period 2"},
      set_up_locate,
      {{"point", locate_result_schema}}};
}

}  // namespace graze::apps
