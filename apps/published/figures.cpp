// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/problem/head.hpp>
#include <graze/apps/published/figures.hpp>
#include <graze/apps/results/motion_report.hpp>
#include <graze/apps/results/section_report.hpp>
#include <graze/apps/results/sweep_report.hpp>
#include <graze/apps/text/number.hpp>

#include <graze/floquet/orbit/shooting.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

constexpr int section_points = 20000;
constexpr int portrait_periods = 60, portrait_samples = 400;

Problem problem_of_row(const Published& published, const Comparison& row) {
  return problem_of(published, row.system, row.eta, row.details.at("beta").get<double>());
}

Picture portrait_of_orbit(const Problem& problem, const Json& attractor) {
  const PeriodicOrbit orbit =
      shoot(problem.system, problem.parameters, vector_from(attractor.at("state")), attractor.at("period").get<int>());
  Json result = result_head("orbit/1", "reproduce", problem, Json::object());
  result["orbit"] = json_of(orbit);
  return picture_of(result, "phase");
}

/// Portrait beside section, both on the attractor itself: from its state there is no transient left to discard.
Picture portrait_of_chaos(const Problem& problem, const Vector& state) {
  Json result = result_head("trajectory/1", "reproduce", problem, Json::object());
  const Motion motion =
      run_motion(problem.system, problem.parameters, state, {.periods = portrait_periods, .samples = portrait_samples});
  result.update(motion_json(problem, motion, contacts_of_run(motion.events)));
  Picture portrait = picture_of(result, "phase");
  Json section = result_head("poincare/1", "reproduce", problem, Json::object());
  section.update(section_json(problem, poincare_section(problem.system, problem.parameters, state, {.points = section_points})));
  Picture points = picture_of(section, "section");
  points.title = fmt::format("Poincaré section, {} points", section_points);
  points.subtitle.clear();
  portrait.beside.push_back(std::move(points));
  return portrait;
}

Figure motion_figure(const Published& published, const Comparison& row) {
  Figure figure;
  figure.name = "figure-" + row.figure;
  figure.caption = fmt::format("Figure {}: {}, eta = {}; printed {}, computed {}", row.figure, row.system, rounded(*row.eta, 6),
                               row.published_text, row.computed_text);
  figure.picture = [&published, &row] {
    const Problem problem = problem_of_row(published, row);
    const Json& attractor = row.details.at("computed_attractor");
    Picture picture = attractor.at("type") == "periodic" ? portrait_of_orbit(problem, attractor)
                                                         : portrait_of_chaos(problem, vector_from(attractor.at("state")));
    picture.title = fmt::format("Figure {}: {}, eta = {}", row.figure, row.system, rounded(*row.eta, 6));
    return picture;
  };
  return figure;
}

Figure diagram_figure(const SweptDiagram& swept) {
  Figure figure;
  figure.name = "figure-" + swept.diagram.figure;
  figure.caption = fmt::format("Figure {}: {}, attractors and their exponents from eta = {} to {} by {}, both ways",
                               swept.diagram.figure, swept.diagram.system, rounded(swept.diagram.from, 6),
                               rounded(swept.diagram.to, 6), rounded(swept.diagram.step, 6));
  figure.picture = [&swept] {
    Json result = result_head("sweep/1", "reproduce", swept.problem, {{"from", swept.diagram.from}, {"to", swept.diagram.to}});
    result["parameter"] = "eta";
    result["rows"] = rows_json(swept.rows);
    Picture picture = picture_of(result, "diagram");
    picture.title = fmt::format("Figure {}: {}", swept.diagram.figure, swept.diagram.system);
    return picture;
  };
  return figure;
}

Picture draw_equal_exponents(const Claim& claim) {
  Picture picture, below;
  picture.title = "Claim: " + claim.statement;
  picture.y_label = "first exponent";
  below.x_label = "eta (dimensionless)";
  below.y_label = "difference of the first exponents";
  for (const char* direction : {"up", "down"}) {
    Curve difference;
    difference.title = fmt::format("difference, sweep {}", direction);
    difference.colour = colour_of(direction == std::string("up") ? 0 : 1);
    for (std::size_t system = 0; system < 2; ++system) {
      Curve curve;
      curve.title = fmt::format("{}, sweep {}", claim.details.at("systems").at(system).get<std::string>(), direction);
      curve.colour = colour_of(2 * system + (direction == std::string("up") ? 0 : 1));
      curve.size = 1.5;
      for (const Json& row : claim.details.at("rows"))
        if (row.at("direction") == direction) curve.points.push_back({row.at("eta"), row.at("exponents").at(system), 0.0});
      picture.curves.push_back(std::move(curve));
    }
    for (const Json& row : claim.details.at("rows"))
      if (row.at("direction") == direction)
        difference.points.push_back(
            {row.at("eta"), row.at("exponents").at(0).get<double>() - row.at("exponents").at(1).get<double>(), 0.0});
    below.curves.push_back(std::move(difference));
  }
  const Barrier grazing{true, claim.details.at("grazing").get<double>(), "grazing", false};
  picture.barriers = {grazing, {false, 0.0, "", false}};
  below.barriers = {{false, 0.0, "", false}};
  if (!picture.curves.front().points.empty())
    picture.x_range = below.x_range = {{picture.curves.front().points.front()[0], picture.curves.front().points.back()[0]}};
  picture.below.push_back(std::move(below));
  return picture;
}

Picture draw_widest_chaos(const Claim& claim) {
  Picture picture;
  picture.title = "Claim: " + claim.statement;
  picture.x_label = "r (dimensionless clearance)";
  picture.y_label = "width of the chaotic windows in eta";
  Curve curve;
  for (const Json& row : claim.details.at("rows")) curve.points.push_back({row.at("r"), row.at("width"), 0.0});
  Curve marks = curve;
  marks.stroke = Stroke::marks;
  marks.size = 1.2;
  picture.curves = {curve, marks};
  return picture;
}

Figure claim_figure(const Claim& claim) {
  Figure figure;
  figure.name = "claim-" + claim.name;
  figure.caption = fmt::format("Claim: {}. {}.", claim.statement, claim.computed);
  figure.picture = [&claim] {
    return claim.details.contains("grazing") ? draw_equal_exponents(claim) : draw_widest_chaos(claim);
  };
  return figure;
}

}  // namespace

std::vector<Figure> figures_of(const Published& published, const Reproduction& reproduction) {
  std::vector<Figure> list;
  for (const SweptDiagram& swept : reproduction.diagrams)
    if (!swept.diagram.figure.empty() && !swept.rows.empty()) list.push_back(diagram_figure(swept));
  for (const Comparison& row : reproduction.rows) {
    if (row.quantity != "exponents" || row.figure.empty() || !row.details.contains("computed_attractor")) continue;
    const std::string name = "figure-" + row.figure;
    // Exponents read off a diagram have no figure of their own.
    if (std::none_of(list.begin(), list.end(), [&](const Figure& figure) { return figure.name == name; }))
      list.push_back(motion_figure(published, row));
  }
  const auto number = [](const Figure& figure) { return std::atoi(figure.name.c_str() + std::string("figure-").size()); };
  std::stable_sort(list.begin(), list.end(), [&](const Figure& a, const Figure& b) { return number(a) < number(b); });
  for (const Claim& claim : reproduction.claims)
    if (!claim.details.at("rows").empty()) list.push_back(claim_figure(claim));
  return list;
}

}  // namespace graze::apps
