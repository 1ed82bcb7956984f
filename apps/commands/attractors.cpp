// SPDX-License-Identifier: GPL-3.0-or-later
// graze attractors: the attractors reached from many starts, and their basins.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/checkpoint_timer.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/output/notes.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/pictures/range.hpp>
#include <graze/apps/problem/axis.hpp>
#include <graze/apps/problem/flow_choice.hpp>
#include <graze/apps/results/attractor_report.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/results/input_file.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/apps/text/write_items.hpp>
#include <graze/lib/motion/sampled_motion.hpp>

#include <graze/floquet/basins/basins.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <set>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr int most_starts = 1000000;  // a result is held in memory before it is written

struct AttractorsArguments {
  StartOptions start;  // problem, settings, and the states that are not varied
  std::string x, v, plane, resume;
  std::optional<int> random, seed;
  int transient = 1000, periods = 20000, max_period = 64;
  FlowChoice flow;
  std::vector<std::string> quantities;
  OutputOptions output;
};

/// Number of starts along each axis from which attractors are sought that the default box must contain, and the number of
/// periods for which a non-periodic attractor is followed to find its extent.
constexpr int probes = 12, probed_periods = 2000;
/// The margin of the box around an attractor, as a share of its width.
constexpr double room = 0.05;

/// The plane of starts: two states vary, the others keep their values.
struct Plane {
  std::array<Eigen::Index, 2> state = {0, 1};
  std::array<std::string, 2> name = {"x", "v"};
  Vector others;
};

Plane plane_of(const AttractorsArguments& options, const Problem& problem) {
  Plane plane;
  plane.others = options.start.start ? state_of(problem, *options.start.start)
                                     : problem.start.value_or(rest_state(problem, problem.parameters));
  const std::vector<std::string> names = state_columns(problem);
  if (names.size() < 2) throw std::invalid_argument("basins are drawn over two states; this system has one");
  if (!options.plane.empty()) {
    const std::array<std::size_t, 2> chosen = plane_of(problem, options.plane);
    plane.state = {static_cast<Eigen::Index>(chosen[0]), static_cast<Eigen::Index>(chosen[1])};
  }
  for (const std::size_t i : {0, 1}) {
    plane.name[i] = names[static_cast<std::size_t>(plane.state[i])];
    if (!options.start.start) continue;
    const std::vector<std::string>& given = options.start.start->names;
    if (std::find(given.begin(), given.end(), plane.name[i]) != given.end())
      throw std::invalid_argument(fmt::format("--start {0}=: {0} varies over the plane of starts; name only the other states, or "
                                              "another --plane",
                                              plane.name[i]));
  }
  return plane;
}

Vector start_at(const Plane& plane, double x, double v) {
  Vector start = plane.others;
  start[plane.state[0]] = x;
  start[plane.state[1]] = v;
  return start;
}

Matrix grid_of(const Plane& plane, const std::array<Axis, 2>& axes, int threads) {
  const auto across = static_cast<std::size_t>(axes[0].count), rows = static_cast<std::size_t>(axes[1].count);
  Matrix starts(plane.others.size(), static_cast<Eigen::Index>(across * rows));
  in_parallel_on(threads, rows, [&](std::size_t j) {
    for (std::size_t i = 0; i < across; ++i)
      starts.col(static_cast<Eigen::Index>(j * across + i)) =
          start_at(plane, axes[0].at(static_cast<int>(i)), axes[1].at(static_cast<int>(j)));
  });
  return starts;
}

/// Widens the box so that it contains the attractors reached from some starts in it.
void widen(std::array<Axis, 2>& axes, const Plane& plane, const AttractorsArguments& options, const Problem& problem,
           const Console& console) {
  std::array<Axis, 2> few = axes;
  for (Axis& axis : few) axis.count = probes;
  BasinOptions probing;
  probing.transient = options.transient;
  probing.max_period = options.max_period;
  probing.periods = std::min(options.periods, probed_periods);
  probing.threads = console.thread_count();
  probing.cancelled = interrupted;
  probing.flow.kind = options.flow.kind();
  probing.flow.cancelled = interrupted;
  const Basins basins = find_attractors(problem.system, problem.parameters, grid_of(plane, few, console.thread_count()), probing);
  for (const CoexistingAttractor& found : basins.attractors)
    for (const Vector& state : found.states)
      for (const std::size_t i : {0, 1}) {
        Axis& axis = axes[i];
        const double margin = room * (axis.to - axis.from), at = state[plane.state[i]];
        // Inside the box no margin is needed: at a hard stop nothing lies beyond the barrier.
        if (at < axis.from) axis.from = at - margin;
        if (at > axis.to) axis.to = at + margin;
      }
}

/// A box around the motions: as wide as the motion without barrier and as the clearance, and bounded by the barrier. Attractors
/// widen it later.
std::array<Axis, 2> built_in_axes(const Problem& problem) {
  const Vector p = built_in_parameters(problem);
  const Vector steady = steady_response(p);
  const double eta = p[oscillator_parameter::eta], r = p[oscillator_parameter::r];
  double size = std::max(std::hypot(steady[0], steady[1] / eta), std::abs(r));
  if (!std::isfinite(size) || size == 0.0) size = 1.0;
  return {Axis{std::min(-size, r - size), r}, Axis{-size * std::max(1.0, eta), size * std::max(1.0, eta)}};
}

/// The extent of a motion from the given start within some periods, plus half of it on both sides.
std::array<Axis, 2> axes_of_motion(const Plane& plane, const Problem& problem) {
  constexpr int periods = 100;
  const Motion motion = run_motion(problem.system, problem.parameters, plane.others, {.periods = periods});
  std::array<Axis, 2> axes;
  for (const std::size_t i : {0, 1}) {
    Range range;
    for (const Vector& state : motion.strobe) range.take(state[plane.state[i]]);
    for (const EventRecord& event : motion.events)
      for (const Vector* side : {&event.x_minus, &event.x_plus}) range.take((*side)[plane.state[i]]);
    const double reach = std::max({range.high - range.low, std::abs(range.low), std::abs(range.high), 1e-6});
    axes[i] = {range.low - 0.5 * reach, range.high + 0.5 * reach};
  }
  return axes;
}

std::array<Axis, 2> default_axes(const Plane& plane, const AttractorsArguments& options, const Problem& problem,
                                 const Console& console) {
  std::array<Axis, 2> axes = is_built_in(problem) ? built_in_axes(problem) : axes_of_motion(plane, problem);
  widen(axes, plane, options, problem, console);
  if (!options.random)  // the centres of the cells
    for (Axis& axis : axes) {
      const double half = 0.5 * (axis.to - axis.from) / axis.count;
      axis.from += half;
      axis.to -= half;
    }
  return axes;
}

/// The axis of the earlier run that is resumed, so that the default is the same.
Axis axis_from(const Json& earlier, const std::string& name, const Axis& otherwise) {
  const Json& range = earlier.at("options").at(name);
  return {range.at(0), range.at(1), range.size() > 2 ? range[2].get<int>() : otherwise.count};
}

std::array<Axis, 2> axes_of(const Plane& plane, const AttractorsArguments& options, const Problem& problem, const Json& earlier,
                            const Console& console) {
  const bool counted = !options.random, is_default = options.x.empty() || options.v.empty();
  std::array<Axis, 2> axes;
  if (is_default && earlier.is_null()) axes = default_axes(plane, options, problem, console);
  try {
    if (is_default && !earlier.is_null())
      axes = {axis_from(earlier, plane.name[0], axes[0]), axis_from(earlier, plane.name[1], axes[1])};
  } catch (const nlohmann::json::exception&) {
    throw_not_resumable(options.resume, "attractors", "is damaged; compute it anew");
  }
  if (!options.x.empty()) axes[0] = parse_axis("--x", options.x, counted);
  if (!options.v.empty()) axes[1] = parse_axis("--v", options.v, counted);
  if (counted && static_cast<double>(axes[0].count) * axes[1].count > most_starts)
    throw std::invalid_argument(
        fmt::format("{} times {} starts are more than a million; give fewer", axes[0].count, axes[1].count));
  return axes;
}

/// The starts in the order of the picture: row by row, x fastest. Random starts are drawn from the bits of the generator, which
/// are the same on every platform.
Matrix starts_of(const Plane& plane, const AttractorsArguments& options, const std::array<Axis, 2>& axes, int threads) {
  if (!options.random) return grid_of(plane, axes, threads);
  Matrix starts(plane.others.size(), *options.random);
  std::mt19937_64 generator(static_cast<unsigned>(options.seed.value_or(1)));
  const auto draw = [&](const Axis& axis) {
    return axis.from + (axis.to - axis.from) * (static_cast<double>(generator() >> 11) * 0x1p-53);
  };
  for (auto start : starts.colwise()) {
    const double x = draw(axes[0]), v = draw(axes[1]);
    start = start_at(plane, x, v);
  }
  return starts;
}

/// @throws std::invalid_argument if no start is admissible.
void check_starts(const Problem& problem, const Matrix& starts) {
  const auto admissible = [&problem](const Vector& start) {
    return mode_at(problem.system, 0.0, start, problem.parameters).has_value();
  };
  if (std::none_of(starts.colwise().begin(), starts.colwise().end(), admissible))
    throw std::invalid_argument(
        is_built_in(problem)
            ? fmt::format("no start is admissible: all lie beyond the barrier, r = {}; give --x with values below it",
                          exact(parameter(problem, "r")))
            : "no start is admissible: all lie beyond a stop; give other ranges by --x and --v, or other states by --start");
}

/// The code of a start in "basins": the attractor's id, null beyond a barrier, 0 if the motion was lost, -1 if it was not run.
Json code_of(const StartOutcome& outcome) {
  switch (outcome.fate) {
  case Fate::reached:
    return outcome.attractor + 1;
  case Fate::inadmissible:
    return nullptr;
  case Fate::lost:
    return 0;
  case Fate::not_run:
    break;
  }
  return -1;
}

StartOutcome outcome_of(const Json& code) {
  if (code.is_null()) return {Fate::inadmissible, 0};
  const int id = code.get<int>();
  if (id > 0) return {Fate::reached, static_cast<std::uint32_t>(id - 1)};
  return {id == 0 ? Fate::lost : Fate::not_run, 0};
}

Json basins_json(const Problem& problem, const Plane& plane, const AttractorsArguments& options, const std::array<Axis, 2>& axes,
                 const Matrix& starts, const std::vector<StartOutcome>& outcomes) {
  Json json;
  if (!is_built_in(problem)) json["plane"] = plane.name;
  const auto codes = [&](std::size_t begin, std::size_t end) {
    Json::array_t list;
    list.reserve(end - begin);
    for (std::size_t k = begin; k < end; ++k) list.push_back(code_of(outcomes[k]));
    return list;
  };
  if (options.random) {
    for (const auto start : starts.colwise()) json["starts"].push_back(to_json(start));
    json["attractor"] = codes(0, outcomes.size());
    return json;
  }
  for (int i = 0; i < axes[0].count; ++i) json[plane.name[0]].push_back(axes[0].at(i));
  for (int j = 0; j < axes[1].count; ++j) json[plane.name[1]].push_back(axes[1].at(j));
  const auto across = static_cast<std::size_t>(axes[0].count);
  Json& rows = json["attractor"] = Json::array();
  for (std::size_t k = 0; k < outcomes.size(); k += across) rows.push_back(codes(k, std::min(k + across, outcomes.size())));
  return json;
}

const Columns<CoexistingAttractor>& found_columns() {
  using F = CoexistingAttractor;
  static const Columns<F> list =
      joined<F>({of_part(attractor_columns(), &F::attractor),
                 of_part(exponents_columns(), &F::attractor),
                 {{"kaplan_yorke", "dimension", [](const F& found) { return kaplan_yorke_dimension(found.attractor.exponents); }},
                  {"count", "starts that reach it", [](const F& found) { return found.count; }},
                  {"fraction", "of the admissible starts", [](const F& found) { return found.fraction; }},
                  {"fraction_error", "standard error of the fraction", [](const F& found) { return found.fraction_error; }},
                  {"states", "on it, at forcing phase 0", &F::states}}});
  return list;
}

/// The quantities of each attractor.
std::vector<QuantityValues> measure(const Quantities& quantities, const Problem& problem, const Basins& basins) {
  std::vector<QuantityValues> measured;
  for (const CoexistingAttractor& found : basins.attractors)
    measured.push_back(measure(quantities, problem.system, problem.parameters, found.attractor));
  return measured;
}

/// Writes everything except the attractor of each start.
void put_basins(Json& json, const Basins& basins, const std::vector<QuantityValues>& measured) {
  json["starts"] = basins.outcomes.size();
  json["admissible"] = basins.admissible;
  json["lost"] = basins.lost;
  json["periods"] = basins.periods;
  json["attractors"] = Json::array();
  for (const CoexistingAttractor& found : basins.attractors) {
    Json& entry = json["attractors"].emplace_back(Json{{"id", json["attractors"].size() + 1}});
    entry.update(json_of(found_columns(), found));
    put_quantities(entry, measured[json["attractors"].size() - 1]);
  }
}

/// The result of an earlier run with the same options.
Basins earlier_basins(const Json& earlier, const std::string& folder, const Json& head, std::size_t states) {
  check_same_run(earlier, head, folder);
  Basins basins;
  try {
    for (const Json& json : earlier.at("attractors")) {
      CoexistingAttractor found;
      found.attractor.termination = Termination::time;
      read(found_columns(), json, found);
      if (!has_states(found.attractor, states))
        throw Json::type_error::create(302, "type must be an attractor of this system", &json);
      basins.attractors.push_back(std::move(found));
    }
    for (const Json& row : earlier.at("basins").at("attractor")) {
      if (!row.is_array()) basins.outcomes.push_back(outcome_of(row));
      if (row.is_array())
        for (const Json& code : row) basins.outcomes.push_back(outcome_of(code));
    }
    basins.periods = earlier.at("periods");
  } catch (const nlohmann::json::exception&) {
    throw_not_resumable(folder, "attractors", "is damaged; compute it anew");
  }
  return basins;
}

void starts_csv(const Problem& problem, const Matrix& starts, const Basins& basins, int threads, const TextSink& sink) {
  const std::vector<Shown> shown = {{"type"}, {"period"}, {"impacts"}};
  std::vector<std::string> ends;  // line ends, by attractor
  for (const CoexistingAttractor& found : basins.attractors) {
    ends.push_back(std::to_string(ends.size() + 1));
    append_cells(ends.back(), attractor_columns(), shown, found.attractor);
    ends.back() += '\n';
  }
  Table head{state_columns(problem), {}};
  add_heading(head, "attractor");
  add_columns(head, shown);
  sink(csv(head));
  write_items(threads, basins.outcomes.size(), sink, [&](std::size_t k, std::string& lines) {
    const StartOutcome& outcome = basins.outcomes[k];
    const auto start = starts.col(static_cast<Eigen::Index>(k));
    const std::string_view other = outcome.fate == Fate::inadmissible ? ",beyond the barrier,,\n"
                                   : outcome.fate == Fate::lost       ? ",lost,,\n"
                                                                      : ",not run,,\n";
    char number[32];  // at most 24 characters
    for (const double value : start) lines.append(number, fmt::format_to(number, FMT_COMPILE("{},"), value));
    lines += outcome.fate == Fate::reached ? std::string_view(ends[outcome.attractor]) : other;
  });
}

std::string overview(const Problem& problem, const Basins& basins, const std::vector<QuantityValues>& measured) {
  Table table{{"id", "attractor", "starts", "fraction", "standard error", "exponents", "standard errors"}, {}};
  const std::vector<std::string> names = state_headings(problem);
  table.columns.insert(table.columns.end(), names.begin(), names.end());
  if (!measured.empty()) add_columns(table, measured.front());
  const auto list = [](const std::vector<double>& values, int digits, std::string (*text_of)(double, int)) {
    std::string text;
    for (const double value : values) text += (text.empty() ? "" : ", ") + text_of(value, digits);
    return text;
  };
  for (const CoexistingAttractor& found : basins.attractors) {
    const Attractor& attractor = found.attractor;
    const bool periodic = attractor.type == AttractorType::periodic;
    table.rows.push_back({std::to_string(table.rows.size() + 1), attractor_name(attractor), std::to_string(found.count),
                          rounded(found.fraction, 4), rounded(found.fraction_error, 2),
                          list(attractor.exponents, periodic ? 6 : 4, exponent_text),
                          periodic ? "-" : list(attractor.standard_errors, 1, error_text)});
    for (const double value : attractor.state) table.rows.back().push_back(rounded(value, 9));
    add_cells(table.rows.back(), measured[table.rows.size() - 1], true);
  }
  std::string text = aligned(table);
  const auto conservative = [](const CoexistingAttractor& found) { return found.attractor.conservative; };
  if (std::any_of(basins.attractors.begin(), basins.attractors.end(), conservative))
    text += "  nothing dissipates here: these are kinds of motion, not attractors\n";
  text += fmt::format("  of {} admissible starts; {} {}", basins.admissible, fmt::join(names, ", "),
                      is_forced(problem.system) ? "at forcing phase 0" : "behind a return");
  if (basins.lost > 0) text += fmt::format("; {} lost (the motion could not be carried on)", counted(basins.lost, "start"));
  return text + fmt::format("\n  {} {} were computed for them\n", basins.periods, periods_name(problem));
}

std::size_t starts_done(const Basins& basins) {
  return static_cast<std::size_t>(std::count_if(basins.outcomes.begin(), basins.outcomes.end(),
                                                [](const StartOutcome& outcome) { return outcome.fate != Fate::not_run; }));
}

BasinOptions basin_options(const AttractorsArguments& options, const Console& console, Progress& progress,
                           CheckpointTimer& checkpoints, std::size_t starts) {
  BasinOptions out;
  out.transient = options.transient;
  out.max_period = options.max_period;
  out.periods = options.periods;
  out.threads = console.thread_count();
  out.cancelled = [&checkpoints] { return interrupted() || checkpoints.over(); };
  out.flow.kind = options.flow.kind();
  out.flow.cancelled = interrupted;
  out.progress = [&progress, &checkpoints, starts](std::size_t done, std::size_t attractors) {
    checkpoints.news();
    progress.update(static_cast<double>(done) / static_cast<double>(starts),
                    [&] { return fmt::format("{} of {} starts, {}", done, starts, counted(attractors, "attractor")); });
  };
  return out;
}

Json described(const Problem& problem, const Plane& plane, const AttractorsArguments& options, const std::array<Axis, 2>& axes) {
  Json json = {{"problem", options.start.file}, {"set", options.start.settings}};
  if (!is_built_in(problem)) json.update({{"plane", plane.name}, {"start", to_json(plane.others)}});
  static const std::set<std::string> taken = {"problem",   "set",     "plane",      "start", "random", "seed",
                                              "transient", "periods", "max_period", "y",     "flow"};
  for (std::size_t i = 0; i < 2; ++i) {
    Json& axis = json[plane.name[i] + (taken.contains(plane.name[i]) ? "_" : "")];
    axis = {axes[i].from, axes[i].to};
    if (!options.random) axis.push_back(axes[i].count);
  }
  if (options.random) json.update({{"random", *options.random}, {"seed", options.seed.value_or(1)}});
  json.update({{"transient", options.transient}, {"periods", options.periods}, {"max_period", options.max_period}});
  put_quantity_option(json, options.quantities);
  put_flow(json, options.flow.kind());
  return json;
}

int run(const AttractorsArguments& given, const Console& console) {
  AttractorsArguments options = given;
  if (options.seed && !options.random) throw std::invalid_argument("--seed is that of random starts; give --random N too");
  if (!options.resume.empty() && options.output.out.empty()) options.output.out = options.resume;
  const OutputFolder folder(options.output, "attractors", options.start.file, options.resume);
  const Problem problem = open_problem(options.start, console);
  const Quantities quantities = read_quantities(problem, options.quantities);
  const Plane plane = plane_of(options, problem);
  const std::array<Axis, 2> axes = axes_of(plane, options, problem, folder.earlier(), console);
  const Matrix starts = starts_of(plane, options, axes, console.thread_count());
  const auto count = static_cast<std::size_t>(starts.cols());
  check_starts(problem, starts);
  Result result;
  result.json = result_head("attractors/1", "attractors", problem, described(problem, plane, options, axes));
  folder.check_free_for(result.json);
  Basins basins;
  if (!options.resume.empty()) basins = earlier_basins(folder.earlier(), options.resume, result.json, problem.system.states);
  if (!basins.outcomes.empty() && basins.outcomes.size() != count)
    throw_not_resumable(options.resume, "attractors", "is damaged; compute it anew");
  const auto with_basins = [&, head = result.json](Status status, const std::string& message) {
    Json json = head;
    set_status(json, status, message);
    put_basins(json, basins, measure(quantities, problem, basins));
    // These are large if there are many starts.
    if (wants_json(options.output)) json["basins"] = basins_json(problem, plane, options, axes, starts, basins.outcomes);
    return json;
  };
  {
    Progress progress(console.err, console.quiet, "carrying on");
    CheckpointTimer checkpoints(checkpoint_interval(options.output), CheckpointTimer::End::stops);
    for (;;) {
      checkpoints.begin(starts_done(basins));
      basins = find_attractors(problem.system, problem.parameters, starts,
                               basin_options(options, console, progress, checkpoints, count), basins);
      if (interrupted() || !checkpoints.over() || basins.complete) break;
      const std::string message = fmt::format("kept after {} of {} starts, while it went on", starts_done(basins), count);
      keep(with_basins(Status::interrupted, message), options.output, "attractors", console);
    }
  }
  Status status = Status::done;
  std::string message;
  if (!basins.complete) {
    status = Status::interrupted;
    message = fmt::format("{} after {} of {} starts", interruption(), starts_done(basins), count);
  } else if (basins.attractors.empty()) {
    status = Status::failed;
    message = "no motion could be carried on";
  }
  result.json = with_basins(status, message);
  result.csv = [&](const TextSink& sink) { starts_csv(problem, starts, basins, console.thread_count(), sink); };
  result.text = describe(problem) + "\n\n" +
                (basins.attractors.empty() ? message + "\n" : overview(problem, basins, measure(quantities, problem, basins)));
  std::vector<std::string> notes;
  for (const CoexistingAttractor& one : basins.attractors)
    if (notes.empty()) notes = order_notes(problem, one.attractor.state, std::max(1, one.attractor.period));
  add_notes(result, notes);
  if (status != Status::done) console.err << "graze attractors: " << message << resume_advice(status, options.output) << "\n";
  return deliver(result, options.output, "attractors", exit_code(status), console);
}

Json attractors_result_schema() {
  const Json count = JsonForm<int>::schema(), number = JsonForm<double>::schema();
  const Json found = with_quantities(
      merged_schemas({object_schema({{"id", "number of the attractor, from 1", count}}), schema_of(found_columns())}));
  const Json code = JsonForm<std::optional<int>>::schema();
  Json basins = object_schema(
      {{"plane", "the two states that vary, of a system from a text", list_schema(JsonForm<std::string>::schema()), false},
       {"starts", "random ones", JsonForm<std::vector<Vector>>::schema(), false},
       {"attractor", "its id, by start, or by row and column of a grid; null: beyond a barrier, 0: lost, -1: not run",
        list_schema({{"anyOf", {code, list_schema(code)}}})}});
  basins["additionalProperties"] = list_schema(number);  // the axes, by the names of the states
  return result_schema(
      "attractors/1", "coexisting attractors and their basins",
      {object_schema({{"starts", "number of starts", count},
                      {"admissible", "starts that were run and lie in front of every barrier", count},
                      {"lost", "starts whose motion could not be continued", count},
                      {"periods", "forcing periods, or returns of an autonomous system, computed for them", count},
                      {"attractors", "most starts first", list_schema(found)},
                      {"basins", "attractor of each start", basins, false}})});
}

std::function<int(const Console&)> set_up_attractors(CLI::App& app) {
  auto options = std::make_shared<AttractorsArguments>();
  add_problem_options(app, options->start);
  begin_group(app, "Starts");
  add_state(app, "--start", options->start.start, "the states that are not varied (default: the file's, else 0)");
  add_text(app, "--plane", options->plane, "NAME,NAME", "the two states that are varied (default: the first two)");
  add_text(
      app, "--x", options->x, "A:B:N",
      "N values of the first varied state, x at forcing phase 0 from A to B (default: up to the barrier and as far as attractors "
      "reach, 64)");
  add_text(app, "--v", options->v, "A:B:N", "N values of the second, x' (default: as wide as the motion, 64)");
  add_count(app, "--random", options->random, 1, "number of random starts in the ranges --x A:B and --v A:B, instead of a grid",
            most_starts);
  add_count(app, "--seed", options->seed, 0, "seed of the random starts (default 1)");
  begin_group(app, "Motions");
  add_count(app, "--transient", options->transient, 1,
            "forcing periods (returns without forcing) in which an attractor must be recognised; then its exponents are averaged "
            "(default 1000)");
  add_count(app, "--periods", options->periods, 1,
            "forcing periods (returns without forcing) of the average; a motion without an orbit by then is chaotic or undecided "
            "(default 20000)");
  add_count(app, "--max-period", options->max_period, 1, "longest period that is recognised (default 64)", longest_period);
  add_flow_option(app, options->flow);
  add_quantity_option(app, options->quantities);
  add_text(app, "--resume", options->resume, "DIR", "continue an interrupted or killed run with --out DIR");
  add_output_options(app, options->output, "attractors/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command attractors_command() {
  return {"attractors",
          "coexisting attractors met from a grid of starts, their basins and exponents",
          "Each start is carried on until it is sure which attractor it reaches: stable orbits (by Newton's method, exponents of "
          "their\n"
          "multipliers), chaos (exponents by average). Basins are given as fractions f of the N admissible starts, with the "
          "standard\n"
          "error sqrt(f (1 - f) / N): that of random starts; a grid is mostly better than that.",
          {"graze attractors data/problems/newton-elastic.toml --set eta=0.744 --plot basins.png",
           "graze attractors data/problems/hertz-damped.toml --set eta=0.711 --x=-2:1.9:200 --v=-2:2:200 --out run",
           "graze attractors data/problems/hertz-damped.toml --set eta=0.696 --random 2000 --json -"},
          set_up_attractors,
          {{"attractors", attractors_result_schema}}};
}

}  // namespace graze::apps
