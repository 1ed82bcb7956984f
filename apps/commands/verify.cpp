// SPDX-License-Identifier: GPL-3.0-or-later
// graze verify: the multipliers of an orbit obtained in independent ways, and how far these disagree.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/find_orbit.hpp>
#include <graze/apps/number.hpp>
#include <graze/apps/orbit_report.hpp>
#include <graze/apps/result.hpp>

#include <graze/floquet/shooting.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace graze::apps {

namespace {

struct Options {
  OrbitOptions orbit;
  OutputOptions output;
};

struct Check {
  std::string name;
  double disagreement = 0.0;  ///< negative: not applicable
  double limit = 0.0;
  bool passes() const { return !(disagreement > limit) && !std::isnan(disagreement); }
};

struct Verified {
  PeriodicOrbit orbit;
  PeriodicOrbit general;           ///< the same nodes carried by the general integrator
  FloquetMultipliers differences;  ///< of the monodromy matrix by finite differences
  std::vector<Check> checks;
};

/// Two integrators that each keep 1e-13 a step; DESIGN asks for agreement to 1e-11 over a period.
constexpr double flow_bound = 1e-11;
/// Of the matrix, over all periods of an orbit: as for the finite differences.
constexpr double matrix_bound = bound::finite_difference;

/// The orbit's own nodes carried once more, every mode by the general integrator.
PeriodicOrbit carried_by_general(const Problem& problem, const PeriodicOrbit& orbit) {
  const FlowOptions flow{.kind = FlowKind::general};
  ShootingEquations equations(problem.system, orbit.parameters, orbit.period, static_cast<int>(orbit.nodes.size()), std::nullopt,
                              flow, orbit.section_phase);
  Vector u(equations.unknowns());
  Eigen::Index filled = 0;
  for (const Vector& node : orbit.nodes) {
    u.segment(filled, node.size()) = node;
    filled += node.size();
  }
  return describe_orbit(equations, u, orbit.newton);
}

Verified verify(const Problem& problem, const PeriodicOrbit& orbit) {
  Verified out{orbit, carried_by_general(problem, orbit), {}, {}};
  out.checks.push_back({"residual", orbit.checks.residual, bound::residual});
  out.checks.push_back({"Liouville", orbit.checks.liouville, bound::liouville});
  const FiniteDifferenceCheck difference =
      orbit.checks.finite_difference.value_or(finite_difference_check(problem.system, orbit));
  if (difference.applicable) out.differences = multipliers(difference.monodromy, orbit.duration);
  out.checks.push_back(
      {"finite differences", difference.applicable ? difference.disagreement : -1.0, finite_difference_bound(difference)});
  if (out.general.multipliers.valid && orbit.multipliers.valid) {
    const Matrix ours = orbit.monodromy.product(), theirs = out.general.monodromy.product();
    out.checks.push_back({"GSL: motion", out.general.checks.residual, flow_bound});
    out.checks.push_back(
        {"GSL: matrix", (ours - theirs).cwiseAbs().maxCoeff() / (1.0 + ours.cwiseAbs().maxCoeff()), matrix_bound});
    out.checks.push_back({"GSL: Liouville", out.general.checks.liouville, bound::liouville});
  } else {
    out.checks.push_back({"GSL: matrix", -1.0, matrix_bound});
  }
  return out;
}

Json verified_json(const Verified& verified) {
  const PeriodicOrbit& orbit = verified.orbit;
  Json out = {{"period", orbit.period},
              {"impacts", orbit.impacts},
              {"state", to_json(orbit.state)},
              {"stable", orbit.stable()},
              {"admissible", orbit.admissible == Admissibility::admissible}};
  out["multipliers"] = {{"saltation", multipliers_json(orbit.multipliers)},
                        {"finite_difference", multipliers_json(verified.differences)},
                        {"general", multipliers_json(verified.general.multipliers)}};
  out["checks"] = Json::array();
  for (const Check& check : verified.checks)
    out["checks"].push_back({{"name", check.name},
                             {"disagreement", check.disagreement < 0.0 ? Json(nullptr) : Json(check.disagreement)},
                             {"bound", check.limit},
                             {"ok", check.passes()}});
  return out;
}

std::string verified_text(const Verified& verified) {
  const PeriodicOrbit& orbit = verified.orbit;
  std::string text = fmt::format("orbit {} at ({}, {}), {}\n", z_label(orbit.impacts, orbit.period), rounded(orbit.state[0]),
                                 rounded(orbit.state[1]), orbit.stable() ? "stable" : "unstable");
  Table values{{"multiplier", "saltation, product form", "finite differences", "general integrator (GSL)"}, {}};
  for (std::size_t i = 0; i < orbit.multipliers.values.size(); ++i) {
    const auto cell = [i](const FloquetMultipliers& list) { return i < list.values.size() ? rounded(list.values[i], 15) : "-"; };
    values.rows.push_back(
        {std::to_string(i + 1), cell(orbit.multipliers), cell(verified.differences), cell(verified.general.multipliers)});
  }
  Table checks{{"check", "disagreement", "bound", "verdict"}, {}};
  for (const Check& check : verified.checks)
    checks.rows.push_back({check.name, check.disagreement < 0.0 ? "-" : rounded(check.disagreement, 3), rounded(check.limit, 3),
                           check.disagreement < 0.0 ? "not applicable"
                           : check.passes()         ? "ok"
                                                    : "FAILED"});
  return text + aligned(values) + "\n" + aligned(checks);
}

int run(const Options& options, const Console& console) {
  check_outputs(options.output, options.orbit.start.file);
  const Problem problem = open_problem(options.orbit.start, console);
  Result result;
  result.json = result_head("verify/1", "verify", problem, options_json(problem, options.orbit));
  const FoundOrbits found = find_orbits(problem, options.orbit, console);
  Status status = found.status;
  std::string message = found.message;
  result.text = describe(problem) + "\n";
  result.table.columns = {"orbit", "check", "disagreement", "bound", "ok"};
  Json orbits = Json::array();
  // Without --search one orbit was asked for, also where it took a search to find it.
  const std::size_t count = options.orbit.search ? found.orbits.size() : std::min<std::size_t>(found.orbits.size(), 1);
  for (std::size_t i = 0; i < count; ++i) {
    const Verified verified = verify(problem, found.orbits[i]);
    orbits.push_back(verified_json(verified));
    result.text.append("\n").append(verified_text(verified));
    for (const Check& check : verified.checks) {
      result.table.rows.push_back({std::to_string(i + 1), check.name, check.disagreement < 0.0 ? "" : exact(check.disagreement),
                                   exact(check.limit), check.passes() ? "yes" : "no"});
      if (check.passes() || status == Status::interrupted) continue;
      status = Status::failed;
      message += fmt::format("{}orbit {}: {}: {} is above {}", message.empty() ? "" : "; ", i + 1, check.name,
                             rounded(check.disagreement, 3), rounded(check.limit, 3));
    }
  }
  set_status(result.json, status, message);
  add_origin(result.json, found);
  result.json["agrees"] = status == Status::done;
  result.json["orbits"] = std::move(orbits);
  if (status != Status::done) console.err << "graze verify: " << message << "\n";
  return deliver(result, options.output, "verify", exit_code(status), console);
}

std::function<int(const Console&)> setup(CLI::App& app) {
  auto options = std::make_shared<Options>();
  add_orbit_options(app, options->orbit);
  add_output_options(app, options->output, "verify/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command verify_command() {
  return {"verify",
          "multipliers against finite differences, another integrator, and Liouville's identity",
          "For the orbit that `graze orbit` finds (with --search, for all): the monodromy matrix by saltation against finite "
          "differences of the\n"
          "return map and against the general integrator (GSL), and Liouville's identity. Exit 1 if any disagreement is above "
          "its bound.",
          {"graze verify data/problems/hertz-damped.toml --set eta=0.925",
           "graze verify data/problems/newton-elastic.toml --period 2 --search"},
          setup};
}

}  // namespace graze::apps
