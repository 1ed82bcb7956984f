// SPDX-License-Identifier: GPL-3.0-or-later
// Published figures beside computed ones: reading, verdicts, and the detection of errors in print.
#include "graze_program.hpp"

#include <graze/apps/published/exponents.hpp>
#include <graze/apps/published/points.hpp>
#include <graze/apps/published/windows.hpp>

#include <graze/floquet/attractor/settle.hpp>

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

Published shipped() { return load_published(GRAZE_DATA_DIR "/published.toml"); }

const PublishedExponents& row_of(const Published& published, const std::string& figure, double eta) {
  for (const PublishedExponents& row : published.exponents)
    if (row.figure == figure && (!row.eta || std::abs(*row.eta - eta) < 1e-12)) return row;
  throw std::logic_error("no row of figure " + figure);
}

ExponentsOptions quick() {
  ExponentsOptions options;
  options.transient = 1000;
  options.standard_error = 1e-3;
  options.source_runs = 2;
  return options;
}

Comparison compare(const Published& published, const PublishedExponents& item) {
  return compare_exponents(published, item, {}, quick());
}

std::string refused(const std::string& text) {
  try {
    parse_published(text, "p.toml");
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

const std::string system_text = "[[system]]\nid = \"s\"\ncontact = \"hertz\"\nparameters = { b = 0.05, k_H = 100.0 }\n";

SweepRow swept(double eta, SweepDirection direction, AttractorType type, int period = 0, int impacts = 0) {
  SweepRow row;
  row.value = eta;
  row.direction = direction;
  row.attractor.type = type;
  row.attractor.period = period;
  row.attractor.impacts = row.attractor.isolated_impacts = impacts;
  return row;
}

}  // namespace

TEST_CASE("the shipped file of published figures is read completely") {
  const Published published = shipped();
  CHECK(published.exponents.size() == 32);
  CHECK(published.points.size() == 1);
  CHECK(published.diagrams.size() == 4);
  CHECK(published.items() == 32 + 1 + 1 + 29);
  CHECK(published.points[0].multipliers.size() == 2);
  const PublishedExponents& row = row_of(published, "17a", 0.0);
  CHECK(*row.beta == Approx(36.0 / 35.0).epsilon(1e-15));
  const Problem beam = problem_of(published, row.system, row.eta, row.beta);
  CHECK(beam.oscillator == "cantilever");
  CHECK(parameter(beam, "eta") == 0.554);
}

TEST_CASE("a file of published figures with a mistake is refused in one sentence") {
  CHECK_THAT(refused("[[sytem]]\n"), Contains("unknown section [[sytem]]; did you mean [[system]]?"));
  CHECK_THAT(refused(system_text), Contains("holds nothing to compare with"));
  CHECK_THAT(refused(system_text + "[[exponents]]\nsystem = \"t\"\n"), Contains("there is no system \"t\""));
  CHECK_THAT(refused(system_text + "[[exponents]]\nsystem = \"s\"\nattractor = \"odd\"\n"),
             Contains("attractor = \"odd\" must be \"impactless\", \"periodic\" or \"chaotic\""));
  CHECK_THAT(refused(system_text + "[[exponents]]\nsystem = \"s\"\nattractor = \"chaotic\"\ndigits = 3\n"),
             Contains("lacks lambda"));
  CHECK_THAT(refused(system_text + "[[exponents]]\nsystem = \"s\"\nattractor = \"periodic\"\nz = [1.5, 2]\n"),
             Contains("z must be [p, n]"));
  CHECK_THAT(refused(system_text + "[[diagram]]\nsystem = \"s\"\neta = [0.9, 0.8]\nstep = 0.1\n"),
             Contains("a range [from, to]"));
  CHECK_THAT(refused(system_text + "[[diagram]]\nsystem = \"s\"\neta = [0.8, 0.9]\nstep = 0\n"), Contains("by a step > 0"));
  const std::string unknown_parameter =
      "[[system]]\nid = \"s\"\ncontact = \"hertz\"\nparameters = { k_r = 1.0 }\n[[exponents]]\nsystem = \"s\"\nattractor = "
      "\"chaotic\"\nlambda = [0.1, -0.2]\ndigits = 3\n";
  const Published published = parse_published(unknown_parameter, "p.toml");
  CHECK_THROWS_WITH(problem_of(published, "s"), Contains("p.toml: system \"s\": ") && Contains("k_r"));
}

TEST_CASE("a number agrees with print within half a unit of its last decimal and three standard errors") {
  CHECK(agrees_with_print(-0.0154999, 0.0, -0.015, 3));
  CHECK(agrees_with_print(0.0145, 0.0, 0.015, 3));
  CHECK_FALSE(agrees_with_print(-0.0155001, 0.0, -0.015, 3));
  CHECK(agrees_with_print(-0.0158, 1e-4, -0.015, 3));
  CHECK_FALSE(agrees_with_print(-0.01581, 1e-4, -0.015, 3));
  CHECK_FALSE(agrees_with_print(0.015, 0.0, -0.015, 3));
}

TEST_CASE("errors in print are found: the period doubling and multipliers of another motion") {
  const Published published = shipped();
  const std::vector<Comparison> rows = compare_point(published, published.points.at(0));
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].verdict == Verdict::differs);
  CHECK(rows[0].computed.get<double>() == Approx(0.919542643087348).epsilon(1e-12));  // data/reference.toml
  CHECK_THAT(rows[0].remark, Contains("the orbit's first multiplier is -0.99885"));
  CHECK(rows[1].verdict == Verdict::differs);
  CHECK(rows[1].computed[0][0].get<double>() == Approx(-0.9988).margin(1e-4));  // as printed
  CHECK_THAT(rows[1].remark, Contains("those of the motion without impact"));
}

TEST_CASE("errors in print are found: motion called impactless above its grazing") {
  const Published published = shipped();
  const Comparison there = compare(published, row_of(published, "4a", 0.696));
  CHECK(there.verdict == Verdict::agrees);
  CHECK(there.remark.empty());
  const Comparison above = compare(published, row_of(published, "5a", 0.711));
  CHECK(above.verdict == Verdict::agrees);  // its exponents are those of weak impacts, to the printed digits
  CHECK_THAT(above.remark, Contains("the motion is z = 1/1 (slowest impact 0.058), not impactless"));
  CHECK_THAT(above.remark, Contains("no motion without impact exists above eta = 0.710687369"));
}

TEST_CASE("errors in print are found: a lost sign and the change of eta that would explain a value") {
  Published published = shipped();
  PublishedExponents item = row_of(published, "12b", 0.733);
  CHECK(compare(published, item).verdict == Verdict::agrees);
  item.lambda[0] = -item.lambda[0];
  const Comparison turned = compare(published, item);
  CHECK(turned.verdict == Verdict::differs);
  CHECK_THAT(turned.remark, Contains("the sign of the first exponent is lost in print"));
  // Newton's period-16 orbit: the printed value is reached 8e-6 further on.
  const Comparison moved = compare(published, row_of(published, "12c", 0.740));
  CHECK(moved.verdict == Verdict::differs);
  const double eta = moved.details.at("eta_for_printed_value");
  PublishedExponents there = row_of(published, "12c", 0.740);
  there.eta = eta;
  const Comparison again = compare(published, there);
  CHECK(again.verdict == Verdict::agrees);
  CHECK(again.computed[0].get<double>() == Approx(there.lambda[0]).margin(1e-9));
  CHECK(moved.details.at("nearest_bifurcation").at("type") == "PD");
}

TEST_CASE("a chaotic row reports the scatter of the source's rule") {
  const Published published = shipped();
  const Comparison row = compare(published, row_of(published, "11b", 0.711));
  CHECK(row.verdict == Verdict::agrees);
  REQUIRE(row.details.at("source_rule").size() == 2);
  for (const Json& run : row.details["source_rule"]) CHECK(run.at("periods").get<int>() % 15 == 0);
  CHECK_THAT(row.remark, Contains("stopped by the source's rule, 2 averages end between"));
  CHECK(row.uncertainty[0].get<double>() < 1e-3);
}

TEST_CASE("windows of a diagram are judged value by value") {
  using enum SweepDirection;
  using enum AttractorType;
  PublishedDiagram diagram{"s", "1", 0.7, 0.704, 0.001, {}};
  diagram.windows = {{0.700, 0.701, "both", {"impactless", std::nullopt, 0}, ""},
                     {0.702, 0.703, "up", {"chaotic", std::nullopt, 0}, "with a period-10 window, z = 7/10"},
                     {0.704, 0.704, "both", {"periodic", std::nullopt, 2}, ""},
                     {0.702, 0.703, "down", {"periodic", std::array{2, 2}, 2}, "coexists with z = 2/3"}};
  SweptDiagram all{diagram, problem_of(shipped(), "newton-elastic"), {}};
  all.rows = {swept(0.700, up, periodic, 1, 0),   swept(0.701, up, periodic, 1, 0),   swept(0.702, up, chaotic),
              swept(0.703, up, periodic, 10, 7),  swept(0.704, up, periodic, 2, 1),   swept(0.704, down, periodic, 2, 2),
              swept(0.703, down, periodic, 3, 2), swept(0.702, down, periodic, 2, 2), swept(0.701, down, periodic, 1, 1),
              swept(0.700, down, periodic, 1, 0)};
  const std::vector<Comparison> rows = compare_windows(all);
  REQUIRE(rows.size() == 4);
  CHECK(rows[0].verdict == Verdict::differs);
  CHECK_THAT(rows[0].remark, Contains("1 of 4 values differ: down z = 1/1 (0.701)"));
  CHECK(rows[1].verdict == Verdict::agrees);
  CHECK_THAT(rows[1].remark, Contains("as the source notes: up z = 7/10 (0.703)"));
  CHECK(rows[2].verdict == Verdict::agrees);
  CHECK(rows[2].computed_text == "up z = 1/2 (0.704); down z = 2/2 (0.704)");
  CHECK(rows[3].verdict == Verdict::agrees);
  all.rows.clear();
  for (const Comparison& row : compare_windows(all)) CHECK(row.verdict == Verdict::differs);
}

TEST_CASE("on the published systems the shortcuts reach the attractor of plain simulation") {
  const Published published = shipped();
  AttractorOptions options;
  options.periods_on_orbit = 0;
  options.lyapunov.max_periods = 20000;
  options.lyapunov.standard_error = 1e-3;
  int periodic = 0;
  for (const PublishedExponents& item : published.exponents) {
    const Problem problem = problem_of(published, item.system, item.eta, item.beta);
    if (parameter(problem, "beta") != 0.0) continue;  // the same code, a hundred times slower
    std::vector<Vector> starts = {start_state(problem, std::nullopt)};
    if (item.initial) starts.push_back(*item.initial);
    for (const Vector& start : starts) {
      INFO(item.system << " " << parameter(problem, "eta") << " from " << start.transpose());
      const Attractor attractor = find_attractor(problem.system, problem.parameters, start, options);
      // The slowest of these orbits gains a factor e in 210 forcing periods.
      const Settled simulated = settle(problem.system, problem.parameters, start, {.periods = 8000});
      REQUIRE(simulated.termination == Termination::time);
      if (!attractor.orbit) {
        CHECK(attractor.type == AttractorType::chaotic);
        CHECK(simulated.suspected_period == 0);
        continue;
      }
      ++periodic;
      double nearest = 1.0;
      for (const Vector& state : attractor.orbit->states) nearest = std::min(nearest, (state - simulated.state).norm());
      CHECK(nearest < 1e-7);
    }
  }
  CHECK(periodic > 25);
}
