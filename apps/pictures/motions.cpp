// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of motions: time series and phase portraits of orbits, special points and trajectories, with the barrier drawn.
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/range.hpp>
#include <graze/apps/pictures/shown_quantity.hpp>
#include <graze/apps/problem/head.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/lib/motion/sampled_motion.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace graze::apps {

namespace {

constexpr int longest_drawn = 4096;                                         // forcing periods of an orbit
constexpr int samples_per_period = 600;                                     // enough for a smooth arc in a short contact
constexpr std::size_t most_samples_per_period = 2400, most_samples = 9000;  // of a trajectory: larger ones become an image

struct Sampled {
  std::string title;
  std::vector<std::array<double, 3>> rows;  ///< tau, and the states of the plane: x, x'
  std::vector<std::array<double, 2>> strobe;
};

/// Inserts the states just before and after each event between the samples: an impact reverses x' instantaneously.
void insert_events(Sampled& motion, const Json& events, const StatePair& plane) {
  std::vector<std::array<double, 3>> rows;
  std::size_t next = 0;
  for (const Json& event : events) {
    const double tau = event.at("tau");
    while (next < motion.rows.size() && motion.rows[next][0] <= tau) rows.push_back(motion.rows[next++]);
    for (const char* side : {"before", "after"}) rows.push_back({tau, event.at(side).at(plane[0]), event.at(side).at(plane[1])});
  }
  rows.insert(rows.end(), motion.rows.begin() + static_cast<std::ptrdiff_t>(next), motion.rows.end());
  motion.rows = std::move(rows);
}

std::array<double, 2> in_plane(const Vector& x, const StatePair& plane) {
  return {x[static_cast<Eigen::Index>(plane[0])], x[static_cast<Eigen::Index>(plane[1])]};
}
std::array<double, 3> in_plane(double tau, const Vector& x, const StatePair& plane) {
  const std::array<double, 2> both = in_plane(x, plane);
  return {tau, both[0], both[1]};
}

/// An orbit of a result, simulated again from its state.
Sampled sampled_orbit(const Problem& problem, const Json& orbit, const StatePair& plane, const std::string& name) {
  const int period = value_of<int>(orbit.at("period"));
  if (period > longest_drawn)
    throw std::invalid_argument(fmt::format("an orbit of {} periods is not drawn; allowed are {}", period, longest_drawn));
  const Vector state = vector_from(orbit.at("state"));
  const Motion motion = run_motion(problem.system, problem.parameters, state,
                                   {.periods = period, .samples = samples_per_period, .stretch = orbit.value("duration", 0.0)});
  Sampled out;
  for (const Vector& row : motion.samples) out.rows.push_back(in_plane(row[0], row.tail(row.size() - 1), plane));
  insert_events(out, json_of(listed(motion.events, contacts_of_run(motion.events))), plane);
  for (int k = 0; k < std::min<int>(period, static_cast<int>(motion.strobe.size())); ++k)
    out.strobe.push_back(in_plane(motion.strobe[static_cast<std::size_t>(k)], plane));
  out.title = fmt::format("{}{}", name, z_label_of(orbit));
  if (orbit.contains("stable")) out.title += orbit["stable"].get<bool>() ? ", stable" : ", unstable";
  return out;
}

std::vector<Sampled> orbits_of(const Json& result) {
  const Problem problem = problem_of(result);
  const StatePair plane = portrait_plane(result);
  std::vector<Sampled> list;
  if (result.contains("orbits") && !result["orbits"].empty()) {
    const std::size_t count = result["orbits"].size();
    for (const Json& orbit : result["orbits"])
      list.push_back(sampled_orbit(problem, orbit, plane, count == 1 ? "" : fmt::format("orbit {}: ", list.size() + 1)));
  } else {
    const Json& orbit = result.at("orbit");
    if (orbit.is_null()) throw std::invalid_argument("this result holds no orbit: none was found");
    list.push_back(sampled_orbit(problem, orbit, plane, ""));
  }
  return list;
}

/// A short contact is a polygon with few samples: each period is simulated again from its state at phase 0.
void sample_more_finely(Sampled& motion, const Json& result, const StatePair& plane) {
  const auto periods = result.at("periods").get<std::size_t>();
  const std::size_t finer = std::min(most_samples_per_period, most_samples / std::max<std::size_t>(periods, 1));
  if (result.contains(shown_quantity) || periods == 0 || finer == 0 || motion.rows.size() > finer * periods) return;
  const Problem problem = problem_of(result);
  const double T = is_forced(problem.system) ? forcing_period(problem.system, problem.parameters) : 0.0;
  // For an autonomous system, which may have a duration instead of returns.
  const double stretch = result.at("options").value("duration", 0.0) / static_cast<double>(periods);
  double begin = 0.0;
  std::vector<std::array<double, 3>> rows;
  for (std::size_t k = 0; k < periods; ++k) {
    const Motion again = run_motion(problem.system, problem.parameters, vector_from(result.at("stroboscopic").at(k)),
                                    {.periods = 1, .samples = static_cast<int>(finer), .stretch = stretch});
    if (T > 0.0) begin = T * static_cast<double>(k);
    for (std::size_t i = 0; i < finer && i < again.samples.size(); ++i)
      rows.push_back(in_plane(begin + again.samples[i][0], again.samples[i].tail(again.samples[i].size() - 1), plane));
    begin += again.duration;
  }
  if (rows.empty()) return;
  // The end, and the part of a period in which the motion ended.
  const double last = rows.back()[0];
  std::copy_if(motion.rows.begin(), motion.rows.end(), std::back_inserter(rows),
               [last](const auto& row) { return row[0] > last; });
  motion.rows = std::move(rows);
}

Sampled trajectory_of(const Json& result) {
  Sampled out;
  const StatePair plane = portrait_plane(result);
  for (const Json& row : result.at("samples")) out.rows.push_back({row.at(0), row.at(1 + plane[0]), row.at(1 + plane[1])});
  sample_more_finely(out, result, plane);
  insert_events(out, result.at("events"), plane);
  for (const Json& state : result.at("stroboscopic")) out.strobe.push_back({state.at(plane[0]), state.at(plane[1])});
  return out;
}

Picture phase_portrait(const Json& result, const std::vector<Sampled>& motions) {
  Picture picture;
  picture.title = "Phase portrait";
  picture.subtitle = model_title(result);
  const StatePair plane = portrait_plane(result);
  picture.x_label = state_label(result, plane[0], false);
  picture.y_label = state_label(result, plane[1], false);
  picture.barriers = barriers_of(result, plane[0], true);
  Range across;
  for (const Barrier& barrier : picture.barriers) across.take(barrier.position);
  for (Barrier& barrier : barriers_of(result, plane[1], false)) picture.barriers.push_back(std::move(barrier));
  Curve strobe;
  strobe.stroke = Stroke::marks;
  strobe.colour = "black";
  strobe.size = 1.2;
  strobe.title = has_forcing(result) ? "forcing phase 0" : result.contains("stroboscopic") ? "returns" : "start";
  for (std::size_t i = 0; i < motions.size(); ++i) {
    Curve curve;
    curve.title = motions[i].title;
    curve.colour = colour_of(i);
    for (const auto& row : motions[i].rows) {
      curve.points.push_back({row[1], row[2], 0.0});
      across.take(row[1]);
    }
    picture.curves.push_back(std::move(curve));
    for (const auto& state : motions[i].strobe) strobe.points.push_back({state[0], state[1], 0.0});
  }
  picture.curves.push_back(std::move(strobe));
  // The picture includes the barrier and a little of the region behind it.
  const double margin = 0.06 * std::max(across.high - across.low, 1e-3);
  if (across.low <= across.high) picture.x_range = {{across.low - margin, across.high + margin}};
  return picture;
}

Picture time_series(const Json& result, const std::vector<Sampled>& motions) {
  Picture picture;
  picture.title = result.contains(shown_quantity) || result.contains("states") ? "Motion" : "Displacement";
  picture.subtitle = model_title(result);
  picture.x_label = time_label(result);
  const std::size_t shown = portrait_plane(result)[0];
  picture.y_label = state_label(result, shown, false);
  picture.barriers = barriers_of(result, shown, false);
  for (Barrier& barrier : picture.barriers) barrier.shaded = false;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    Curve curve;
    curve.title = motions[i].title.empty() ? state_name(result, shown) : motions[i].title;
    curve.colour = colour_of(i);
    for (const auto& row : motions[i].rows) curve.points.push_back({row[0], row[1], 0.0});
    picture.curves.push_back(std::move(curve));
  }
  // The picture includes the barrier and its name.
  Range up;
  for (const Barrier& barrier : picture.barriers) up.take(barrier.position);
  for (const Curve& curve : picture.curves)
    for (const auto& point : curve.points) up.take(point[1]);
  const double margin = 0.08 * std::max(up.high - up.low, 1e-3);
  if (up.low <= up.high) picture.y_range = {{up.low - margin, up.high + margin}};
  return picture;
}

bool has_orbit(const Json& result) {
  return (result.contains("orbits") && !result["orbits"].empty()) || (result.contains("orbit") && !result["orbit"].is_null());
}

bool has_point(const Json& result) { return !result.at("special_point").is_null(); }

Picture draw_point(const Json& result) {
  const Json& point = result.at("special_point");
  if (point.is_null()) throw std::invalid_argument("this result holds no special point: none was found");
  const std::string name = result.at("options").at("param");
  Json there = result;  // its parameters are those of the model; the point has its own value of one of them
  there["parameters"][name] = point.at("value");
  Sampled motion = sampled_orbit(problem_of(there), point, portrait_plane(there), point.at("label").get<std::string>() + ": ");
  Picture picture = phase_portrait(there, {motion});
  picture.title = fmt::format("{} at {} = {}", point.at("label").get<std::string>(), name, rounded(point.at("value"), 13));
  return picture;
}

Picture draw_section(const Json& result) {
  Picture picture;
  const bool impacts = result.at("section") == "impact", stroboscopic = result.at("section") == "stroboscopic";
  const Json& name = result.at("section") == "event" ? result.at("options").at("section") : result.at("section");
  picture.title = fmt::format("Poincaré section ({})", name.get<std::string>());
  picture.subtitle = model_title(result);
  const bool phases = impacts && has_forcing(result);  // else the times between the impacts
  picture.x_label = phases    ? "forcing phase eta tau mod 2 pi (radians)"
                    : impacts ? "time since the last impact" + unit_behind(problem_of(result), "t")
                              : state_label(result, 0, stroboscopic);
  picture.y_label = impacts ? "speed of impact (dimensionless)" : state_label(result, 1, stroboscopic);
  if (phases) picture.x_range = {{0.0, 2.0 * M_PI}};
  Curve curve;
  curve.stroke = Stroke::dots;
  const std::size_t count = result.at("points").size();
  curve.size = count > 5000 ? 0.15 : count > 500 ? 0.35 : 0.8;
  double highest = -HUGE_VAL, lowest = HUGE_VAL, slowest = HUGE_VAL, fastest = -HUGE_VAL;
  for (const Json& point : result.at("points")) {
    curve.points.push_back({point.at(0), point.at(1), 0.0});
    slowest = std::min(slowest, curve.points.back()[1]);
    fastest = std::max(fastest, curve.points.back()[1]);
    lowest = std::min(lowest, curve.points.back()[0]);
    highest = std::max(highest, curve.points.back()[0]);
  }
  picture.curves.push_back(std::move(curve));
  // Drawn only if it lies near the points: a distant barrier would squeeze the section into a corner.
  for (const Barrier& barrier : barriers_of(result, 0, true)) {
    if (impacts || !(barrier.position < highest + 0.5 * (highest - lowest))) continue;
    picture.barriers.push_back(barrier);
    lowest = std::min(lowest, barrier.position);
    highest = std::max(highest, barrier.position);
  }
  const double margin = 0.05 * std::max(highest - lowest, 1e-3);
  if (!phases && count > 0) picture.x_range = {{lowest - margin, highest + margin}};
  // A periodic attractor consists of a few points: the axis shows where they are, not how their last digits differ.
  const double above = std::max(0.05 * (fastest - slowest), 0.01 * std::max(std::abs(slowest), std::abs(fastest)));
  if (count > 0) picture.y_range = {{slowest - std::max(above, 1e-3), fastest + std::max(above, 1e-3)}};
  return picture;
}

}  // namespace

PictureKind orbit_phase_picture() {
  return {"graze.orbit/1",
          "phase",
          "phase portrait",
          [](const Json& result) { return phase_portrait(result, orbits_of(result)); },
          {},
          has_orbit};
}

PictureKind orbit_time_picture() {
  return {"graze.orbit/1",
          "time",
          "displacement against time",
          [](const Json& result) { return time_series(result, orbits_of(result)); },
          {},
          has_orbit};
}

PictureKind point_phase_picture() {
  return {"graze.point/1", "phase", "phase portrait of the orbit at the point", draw_point, {}, has_point};
}

PictureKind trajectory_time_picture() {
  return {"graze.trajectory/1",
          "time",
          "displacement against time",
          [](const Json& result) { return time_series(result, {trajectory_of(result)}); },
          {},
          nullptr,
          true};
}

PictureKind trajectory_phase_picture() {
  return {"graze.trajectory/1", "phase", "phase portrait",
          [](const Json& result) { return phase_portrait(result, {trajectory_of(result)}); }};
}

PictureKind section_picture() {
  return {"graze.poincare/1", "section", "points of the section", draw_section, {}, nullptr, true};
}

}  // namespace graze::apps
