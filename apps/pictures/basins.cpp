// SPDX-License-Identifier: GPL-3.0-or-later
// Picture of graze.attractors/1: the attractor that each start reaches, and the attractors' states on top.
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/range.hpp>
#include <graze/apps/results/attractor_report.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

/// A colour mixed with white, so that the attractor itself stands out in its basin.
std::string tint(const std::string& colour, double white) {
  const unsigned long rgb = std::stoul(colour.substr(1), nullptr, 16);
  const auto mixed = [white](unsigned long part) { return static_cast<int>(std::lround(255.0 * white + (1.0 - white) * part)); };
  return fmt::format("#{:02x}{:02x}{:02x}", mixed(rgb >> 16), mixed(rgb >> 8 & 255), mixed(rgb & 255));
}

std::string percent(double share) { return fmt::format("{:.1f}", 100.0 * share); }

/// Extends the range by half a cell beyond the outermost values.
void take_cells(Range& range, const Json& values) {
  const double first = values.front(), last = values.back(), half = 0.5 * (last - first) / static_cast<double>(values.size() - 1);
  range.take(first - half);
  range.take(last + half);
}

/// Index of a start's colour: first those of the attractors, then that of lost motions; -1: none.
int colour_index(const Json& code, std::size_t attractors) {
  const int id = code.is_null() ? -1 : code.get<int>();
  return id > 0 ? id - 1 : id == 0 ? static_cast<int>(attractors) : -1;
}

/// The two states along the axes: the names under which the starts are listed, and their indices.
struct BasinPlane {
  std::array<std::string, 2> name = {"x", "v"};
  std::array<std::size_t, 2> state = {0, 1};
};

BasinPlane plane_of(const Json& result) {
  BasinPlane plane;
  const Json& basins = result.at("basins");
  if (!basins.contains("plane")) return plane;
  const Json& states = result.at("states");
  for (const std::size_t i : {0, 1}) {
    plane.name[i] = basins.at("plane").at(i);
    plane.state[i] = static_cast<std::size_t>(std::find(states.begin(), states.end(), plane.name[i]) - states.begin());
  }
  return plane;
}

Picture draw_basins(const Json& result) {
  Picture picture;
  picture.title = "Basins of attraction";
  picture.subtitle = model_title(result);
  const BasinPlane plane = plane_of(result);
  picture.x_label = state_label(result, plane.state[0], true);
  picture.y_label = state_label(result, plane.state[1], true);
  picture.grid = false;
  const Json& attractors = result.at("attractors");
  const Json& basins = result.at("basins");
  std::vector<std::string> colours;
  Range x, v;
  std::vector<std::array<double, 2>> starts;
  std::vector<int> colour;
  const bool grid = basins.contains(plane.name[0]);
  const bool cells = grid && basins[plane.name[0]].size() > 1 && basins.at(plane.name[1]).size() > 1;
  for (std::size_t i = 0; i < attractors.size(); ++i) colours.push_back(tint(colour_of(i), cells ? 0.6 : 0.35));
  colours.emplace_back(lost_colour);
  if (grid)
    for (std::size_t j = 0; j < basins.at(plane.name[1]).size(); ++j)
      for (std::size_t i = 0; i < basins[plane.name[0]].size(); ++i) {
        starts.push_back({basins[plane.name[0]][i].get<double>(), basins[plane.name[1]][j].get<double>()});
        colour.push_back(colour_index(basins.at("attractor").at(j).at(i), attractors.size()));
      }
  else
    for (std::size_t k = 0; k < basins.at("starts").size(); ++k) {
      const Json& start = basins.at("starts").at(k);
      starts.push_back({start.at(plane.state[0]).get<double>(), start.at(plane.state[1]).get<double>()});
      colour.push_back(colour_index(basins.at("attractor").at(k), attractors.size()));
    }
  for (const auto& start : starts) {
    x.take(start[0]);
    v.take(start[1]);
  }
  if (cells) {
    take_cells(x, basins[plane.name[0]]);
    take_cells(v, basins[plane.name[1]]);
    picture.cells = Cells{basins[plane.name[0]].get<std::vector<double>>(), basins[plane.name[1]].get<std::vector<double>>(),
                          colours, colour};
  } else {
    add_start_dots(picture, starts, colour, colours);
  }
  for (std::size_t i = 0; i < attractors.size(); ++i) {
    const Json& found = attractors[i];
    const std::string title = fmt::format("{}: {} ± {} %", attractor_name(value_of<Attractor>(found)),
                                          percent(found.at("fraction")), percent(found.at("fraction_error")));
    const bool periodic = found.at("type") == "periodic";
    Curve curve;
    curve.colour = colour_of(i);
    curve.stroke = periodic ? Stroke::marks : Stroke::dots;
    curve.size = periodic ? 1.4 : 0.5;
    for (const Json& state : found.at("states")) {
      curve.points.push_back({state.at(plane.state[0]), state.at(plane.state[1]), 0.0});
      x.take(state.at(plane.state[0]));
      v.take(state.at(plane.state[1]));
    }
    if (periodic) {
      Curve rim = curve;
      rim.colour = "black";
      rim.size = 1.9;
      picture.curves.push_back(std::move(rim));
    }
    picture.curves.push_back(std::move(curve));
    picture.curves.push_back(legend_entry(title, colour_of(i)));
  }
  const double lost = result.at("lost"), admissible = result.at("admissible");
  if (lost > 0.0) picture.curves.push_back(legend_entry(fmt::format("lost: {} %", percent(lost / admissible)), lost_colour));
  // A barrier near the range is included in the picture; others are left out.
  const auto add_barriers = [&](std::size_t state, bool vertical, auto& range) {
    const double low = range.low - 0.1 * (range.high - range.low), high = range.high + 0.5 * (range.high - range.low);
    for (const Barrier& barrier : barriers_of(result, state, vertical)) {
      if (!(barrier.position > low && barrier.position < high)) continue;
      picture.barriers.push_back(barrier);
      range.take(barrier.position);
    }
  };
  add_barriers(plane.state[0], true, x);
  add_barriers(plane.state[1], false, v);
  picture.x_range = x.with_margin(0.02);
  picture.y_range = v.with_margin(0.02);
  return picture;
}

}  // namespace

void add_start_dots(Picture& picture, const std::vector<std::array<double, 2>>& starts, const std::vector<int>& colour,
                    const std::vector<std::string>& colours) {
  for (std::size_t c = 0; c < colours.size(); ++c) {
    Curve curve;
    curve.stroke = Stroke::dots;
    curve.colour = colours[c];
    curve.size = starts.size() > 5000 ? 0.4 : starts.size() > 1000 ? 0.7 : 1.1;
    for (std::size_t k = 0; k < starts.size(); ++k)
      if (colour[k] == static_cast<int>(c)) curve.points.push_back({starts[k][0], starts[k][1], 0.0});
    picture.curves.push_back(std::move(curve));
  }
}

PictureKind basins_picture() {
  return {"graze.attractors/1", "basins", "basins of the coexisting attractors, with their states", draw_basins, {}};
}

}  // namespace graze::apps
