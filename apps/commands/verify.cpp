// SPDX-License-Identifier: GPL-3.0-or-later
// graze verify: multipliers and exponents of orbits from independent methods, and their disagreement, at one value or over a
// range. With --hard-limit: soft contacts compared with the rigid stop that they approach.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/results/verification_report.hpp>
#include <graze/apps/text/number.hpp>

#include <graze/floquet/follow/sweep.hpp>
#include <graze/floquet/orbit/shooting.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <stdexcept>

namespace graze::apps {

namespace {

struct VerifyArguments {
  OrbitOptions orbit;
  std::string parameter;
  std::optional<double> from, to, step;
  int average = 2000;
  bool hard_limit = false;
  OutputOptions output;
};

/// The name of the parameter. At one value any will do.
std::string parameter_of(const VerifyArguments& options, const Problem& problem) {
  const bool one_value = !options.from && !options.to && !options.step;
  const std::vector<ParameterInfo>& all = problem.system.parameters;
  if (options.parameter.empty() && one_value && !problem.system.forcing_frequency && !all.empty()) return all.front().name;
  return parameter_name(problem, options.parameter);
}

/// The values of the parameter, in the order in which the orbit is carried from one to the next; without a range only the
/// problem's own value.
std::vector<double> values_of(const VerifyArguments& options, const Problem& problem) {
  check_parameter_name(problem, options.parameter);
  const double own = parameter(problem, options.parameter), from = options.from.value_or(own);
  if (!options.to && !options.step) return {from};
  if (!options.to || !options.step)
    throw std::invalid_argument(fmt::format("a range needs both --to and --step; {} is missing", options.to ? "--step" : "--to"));
  if (!(*options.step > 0.0)) throw std::invalid_argument(fmt::format("--step is {}; allowed is > 0", exact(*options.step)));
  if (from == *options.to)
    throw std::invalid_argument(
        fmt::format("the range goes from {} to {}; its ends must differ", exact(from), exact(*options.to)));
  if (from < *options.to) return sweep_values(from, *options.to, *options.step);
  std::vector<double> values = sweep_values(-from, -*options.to, *options.step);
  for (double& value : values) value = -value;
  return values;
}

/// The parameters of Hertz contact whose hard limit is requested.
Vector hertz_parameters(const Problem& problem) {
  if (problem.contact == "hertz") return built_in_parameters(problem);
  const HybridSystem hertz = make_oscillator(problem.oscillator, "hertz");
  Vector p = default_parameters(hertz.parameters);
  p.head(oscillator_parameter::law) = built_in_parameters(problem).head(oscillator_parameter::law);
  return p;
}

void check_hard_limit(const Problem& problem, const VerifyArguments& options) {
  if (!is_built_in(problem))
    throw std::invalid_argument(
        "--hard-limit is for the built-in oscillators; a system written as text has no stiffness that it knows");
  if (problem.contact == "newton") {
    if (options.parameter == "k_r" || parameter(problem, "k_r") != 1.0)
      throw std::invalid_argument(
          fmt::format("--hard-limit compares undamped Hertz contact with Newton's law of k_r = 1; here k_r {}",
                      options.parameter == "k_r" ? std::string("is varied") : "is " + exact(parameter(problem, "k_r"))));
  } else if (problem.contact != "hertz") {
    throw std::invalid_argument(fmt::format(
        "--hard-limit is for Hertz contact, or Newton's law with k_r = 1; the contact law here is {}", problem.contact));
  }
}

Problem problem_at(const Problem& problem, const VerifyArguments& options, double value) {
  Problem at = problem;
  set_parameter(at, options.parameter, value, options.to ? "--from, --to" : "--from");
  return at;
}

/// Orbits to verify, and the failures on the way.
struct Collected {
  struct Item {
    double value = 0.0;
    PeriodicOrbit orbit;
  };
  std::vector<Item> orbits;
  Status status = Status::done;
  std::vector<std::string> complaints;
  OrbitResult first;  ///< at the first value

  void fail(std::string why) {
    if (status == Status::done) status = Status::failed;
    complaints.push_back(std::move(why));
  }
};

/// The orbit carried to another value by Newton's method.
std::optional<PeriodicOrbit> carried(const Problem& at, const PeriodicOrbit& last, const PeriodicOrbit* before) {
  std::vector<Vector> guess = last.states;
  // Values are equally spaced: extrapolate linearly from the last two.
  if (before != nullptr && before->states.size() == guess.size())
    for (std::size_t k = 0; k < guess.size(); ++k) guess[k] += last.states[k] - before->states[k];
  try {
    PeriodicOrbit orbit = shoot(at.system, at.parameters, guess, last.period);
    if (orbit.converged() && orbit.period == last.period && orbit.admissible == Admissibility::admissible) return orbit;
  } catch (const std::invalid_argument&) {  // the extrapolation leads inside a barrier
  }
  return std::nullopt;
}

Collected collect(const Problem& problem, const VerifyArguments& options, const std::vector<double>& values,
                  const Console& console) {
  Collected out;
  Progress progress(console.err, console.quiet, "following");
  const bool range = values.size() > 1;
  std::optional<PeriodicOrbit> last, before;
  for (const double value : values) {
    if (interrupted()) break;
    progress.update(static_cast<double>(out.orbits.size()) / static_cast<double>(values.size()),
                    [&] { return fmt::format("{} = {}", options.parameter, rounded(value, 7)); });
    const Problem at = problem_at(problem, options, value);
    if (!options.orbit.search && last) {
      if (auto orbit = carried(at, *last, before ? &*before : nullptr); orbit || before) {
        if (!orbit) orbit = carried(at, *last, nullptr);
        if (orbit) {
          out.orbits.push_back({value, *orbit});
          before = std::exchange(last, std::move(orbit));
          continue;
        }
      }
      console.note(fmt::format("the orbit could not be carried to {} = {}; another is looked for there", options.parameter,
                               rounded(value, 9)));
    }
    const OrbitResult found = find_orbits(at, options.orbit, console);
    if (out.first.origin == OrbitOrigin::none && out.orbits.empty()) out.first = found;
    if (found.status == Status::interrupted) {
      out.status = Status::interrupted;
      out.complaints.push_back(found.message);
    } else if (found.status == Status::failed) {
      out.fail(range ? fmt::format("at {} = {}: {}", options.parameter, rounded(value, 9), found.message) : found.message);
    }
    before.reset();
    last.reset();
    // Without --search one orbit was requested, even if it took a search to find it.
    const std::size_t count = options.orbit.search ? found.orbits.size() : std::min<std::size_t>(found.orbits.size(), 1);
    for (std::size_t i = 0; i < count; ++i) out.orbits.push_back({value, found.orbits[i]});
    if (count > 0 && found.status == Status::done) last = found.orbits.front();
  }
  return out;
}

Verification verify_one(const Problem& at, const Collected::Item& item, const VerifyArguments& options) {
  Verification out;
  out.value = item.value;
  VerificationOptions verifying;
  verifying.average_periods = options.average;
  verifying.cancelled = interrupted;
  out.verified = verify_orbit(at.system, item.orbit, verifying);
  out.checks = out.verified.checks;
  if (!options.hard_limit || interrupted()) return out;
  out.hard = hard_limit(oscillator_kind(at.oscillator), hertz_parameters(at), item.orbit, {.cancelled = interrupted});
  out.checks.insert(out.checks.end(), out.hard->checks.begin(), out.hard->checks.end());
  return out;
}

/// Verifies all orbits in parallel; those cut short by an interrupt are left out.
std::vector<Verification> verify_all(const Problem& problem, const Collected& collected, const VerifyArguments& options,
                                     const Console& console) {
  const std::size_t count = collected.orbits.size();
  std::vector<std::optional<Verification>> slots(count);
  Progress progress(console.err, console.quiet, "verifying");
  std::mutex telling;
  std::size_t done = 0;
  in_parallel_on(console.thread_count(), count, [&](std::size_t i) {
    if (interrupted()) return;
    const Collected::Item& item = collected.orbits[i];
    Verification verification = verify_one(problem_at(problem, options, item.value), item, options);
    if (interrupted()) return;
    const std::lock_guard lock(telling);
    slots[i] = std::move(verification);
    progress.update(static_cast<double>(++done) / static_cast<double>(count), [&] {
      return fmt::format("{} of {}, {} = {}", done, counted(count, "orbit"), options.parameter, rounded(item.value, 7));
    });
  });
  std::vector<Verification> list;
  for (std::optional<Verification>& slot : slots)
    if (slot) list.push_back(std::move(*slot));
  return list;
}

/// Adds complaints about orbits that do not agree, or whose hard limit was not reached.
void judge(const std::vector<Verification>& list, const VerifyArguments& options, bool range, Collected& collected) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string which =
        fmt::format("orbit {}{}", i + 1, range ? fmt::format(" at {} = {}", options.parameter, rounded(list[i].value, 9)) : "");
    for (const OrbitCheck& check : list[i].checks)
      if (!check.passes())
        collected.fail(
            fmt::format("{}: {}: {} is above {}", which, check.name, rounded(check.disagreement, 3), rounded(check.limit, 3)));
    if (list[i].hard && list[i].hard->stop != HardLimitStop::done)
      collected.fail(fmt::format("{}: hard limit: {}", which, hard_limit_stop_text(list[i].hard->stop)));
  }
}

/// The first complaints, and the number of the others.
std::string sentence(const std::vector<std::string>& complaints) {
  constexpr std::size_t most = 5;
  const std::size_t count = std::min(most, complaints.size());
  std::string text =
      fmt::format("{}", fmt::join(complaints.begin(), complaints.begin() + static_cast<std::ptrdiff_t>(count), "; "));
  if (complaints.size() > most) text += fmt::format("; and {} more", complaints.size() - most);
  return text;
}

int run(const VerifyArguments& given, const Console& console) {
  VerifyArguments options = given;
  const OutputFolder folder(options.output, "verify", options.orbit.start.file);
  const Problem problem = open_problem(options.orbit.start, console, {options.parameter});
  options.parameter = parameter_of(options, problem);
  const std::vector<double> values = values_of(options, problem);
  const bool range = values.size() > 1;
  for (const double end : {values.front(), values.back()}) problem_at(problem, options, end);  // reports a wrong value now
  if (options.hard_limit) check_hard_limit(problem, options);
  if (!options.hard_limit && !options.output.plot_kind.empty() && options.output.plot_kind != "checks")
    throw std::invalid_argument(fmt::format("--plot-kind {} shows the hard limit; add --hard-limit", options.output.plot_kind));
  Json described = options_json(problem, options.orbit);
  described.update({{"param", options.parameter}, {"from", values.front()}, {"to", values.back()}});
  if (options.step) described["step"] = *options.step;
  described.update({{"average", options.average}, {"hard_limit", options.hard_limit}});
  Result result;
  result.json = result_head("verify/1", "verify", problem, described);
  folder.check_free_for(result.json);

  Collected collected = collect(problem, options, values, console);
  const std::vector<Verification> list = verify_all(problem, collected, options, console);
  if (interrupted() && collected.complaints.empty())
    collected.complaints.push_back(fmt::format("{} after {} of {} at {}", interruption(), list.size(),
                                               counted(collected.orbits.size(), "orbit"), counted(values.size(), "value")));
  if (interrupted()) collected.status = Status::interrupted;
  judge(list, options, range, collected);

  const std::string message = sentence(collected.complaints);
  set_status(result.json, collected.status, message);
  result.json.update(json_of(origin_columns(), collected.first));
  result.json["agrees"] = collected.status == Status::done;
  result.json["parameter"] = options.parameter;
  result.json["orbits"] = json_of(list);
  result.json["largest"] = Json::array();
  for (const Largest& worst : largest_of(list)) result.json["largest"].push_back(json_of(largest_columns(list), worst));
  result.table = checks_table(list, options.parameter);
  result.text = describe(problem_at(problem, options, values.front()), range ? options.parameter : "") + "\n";
  if (range && !list.empty()) result.text += "\n" + range_text(list, options.parameter);
  if (!range)
    for (const Verification& verification : list) result.text += "\n" + verification_text(verification);
  if (collected.status != Status::done) console.err << "graze verify: " << message << "\n";
  return deliver(result, options.output, "verify", exit_code(collected.status), console);
}

Json verify_result_schema() {
  return result_schema(
      "verify/1", "orbits, each computed in several ways, and the disagreements",
      {schema_of(origin_columns()), object_schema({{"agrees", "no check of any orbit has failed", JsonForm<bool>::schema()},
                                                   {"parameter", "name of the varied parameter", JsonForm<std::string>::schema()},
                                                   {"orbits", "by value", JsonForm<std::vector<Verification>>::schema()},
                                                   {"largest", "the worst of each check, in units of its bound",
                                                    list_schema(schema_of(largest_columns({})))}})});
}

std::function<int(const Console&)> set_up_verify(CLI::App& app) {
  auto options = std::make_shared<VerifyArguments>();
  add_orbit_options(app, options->orbit);
  begin_group(app, "Range");
  add_text(app, "--param", options->parameter, "NAME", "parameter (default: the forcing frequency; needed for a range only)");
  add_number(app, "--from", options->from, "first value (default: the problem's own)");
  add_number(app, "--to", options->to, "last value, above or below it (default: one value only)");
  add_number(app, "--step", options->step, "step from one value to the next");
  begin_group(app, "Checks");
  add_count(app, "--average", options->average, 0,
            "forcing periods (returns without forcing) of the exponents' time average (default 2000; 0: none)");
  add_flag(app, "--hard-limit", options->hard_limit, "also compare Hertz contact of growing k_H with the rigid stop it becomes");
  add_output_options(app, options->output, "verify/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command verify_command() {
  return {
      "verify",
      "multipliers against finite differences, another integrator, time averages, Liouville's identity; the hard limit",
      "For the orbit that `graze orbit` finds (with --search, for all): the monodromy matrix and the multipliers by saltation\n"
      "against finite differences of the return map and against the general integrator (GSL), Liouville's identity, and on\n"
      "stable orbits exponents by time average. With --to and --step at every value of a range, the orbit carried from one to\n"
      "the next. --hard-limit: k_H from 1e3 to 1e9 against the rigid stop, whose restitution for damped Hertz is known in\n"
      "closed form. Exit 1 if any disagreement is above its bound.",
      {"graze verify data/problems/hertz-damped.toml --set eta=0.925",
       "graze verify data/problems/newton-elastic.toml --period 2 --search",
       "graze verify data/problems/hertz-damped.toml --from 0.95 --to 0.9 --step 0.005 --plot verify.png",
       "graze verify data/problems/hertz-damped.toml --hard-limit --plot restitution.png --plot-kind restitution"},
      set_up_verify,
      {{"verify", verify_result_schema}}};
}

}  // namespace graze::apps
