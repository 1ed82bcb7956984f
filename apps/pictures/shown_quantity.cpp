// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/pictures/shown_quantity.hpp>
#include <graze/lib/system/parameters.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace graze::apps {

namespace {

/// The quantity's values in the form of states; empty: unknown.
Json values_of(const Json& point, const std::string& quantity) {
  const Json& value = point.at("y").at(quantity);
  Json list = Json::array();
  for (const Json& one : value.is_array() ? value : Json::array({value})) {
    if (one.is_null()) return Json::array();
    list.push_back(Json::array({one}));
  }
  return list;
}

/// Puts the quantity in place of the state; false: the point has no value.
bool show(Json& point, const std::string& quantity) {
  Json values = values_of(point, quantity);
  if (values.empty()) return false;
  point["state"] = values.front();
  point.erase("states");
  if (values.size() > 1) point["states"] = std::move(values);
  return true;
}

void show_in_branch(Json& branch, const std::string& quantity) {
  Json points = Json::array(), special = Json::array();
  std::vector<std::size_t> number;  // index of each point among those that remain, or of the last one before it
  bool gap = false;
  for (Json& point : branch.at("points")) {
    if (!show(point, quantity)) {
      gap = true;
    } else {
      if (std::exchange(gap, false) && !points.empty()) point["after_gap"] = true;
      points.push_back(std::move(point));
    }
    number.push_back(points.empty() ? 0 : points.size() - 1);
  }
  for (Json& point : branch.at("special_points")) {
    if (!show(point, quantity)) continue;
    const std::size_t after = point.at("after_point");
    if (after < number.size()) point["after_point"] = number[after];
    special.push_back(std::move(point));
  }
  branch["points"] = std::move(points);
  branch["special_points"] = std::move(special);
}

/// Puts the quantity in place of a state of a trajectory or a section.
void show_in_columns(Json& out, const std::string& quantity) {
  const Json& columns = out["columns"];
  const auto from = static_cast<std::size_t>(std::find(columns.rbegin(), columns.rend(), quantity).base() - columns.begin()) - 1;
  const bool section = out.contains("points");
  if (section) out[shown_place] = 1;
  for (Json& row : out[section ? "points" : "samples"]) row.at(1) = row.at(from).is_null() ? Json(std::nan("")) : row.at(from);
  out["events"] = Json::array();
}

}  // namespace

Json with_quantity_as_state(const Json& result, const std::string& quantity) {
  Json out = result;
  out[shown_quantity] = quantity;
  if (out.contains("branches"))
    for (Json& branch : out["branches"]) show_in_branch(branch, quantity);
  if (out.contains("rows"))
    for (Json& row : out["rows"]) row["states"] = row.contains("y") ? values_of(row, quantity) : Json::array();
  if (out.contains("columns")) show_in_columns(out, quantity);
  return out;
}

Json with_quantities(Json result, const std::vector<std::string>& chosen) {
  std::vector<std::string> known;
  if (result.contains("options") && result["options"].contains("y"))
    known = result["options"]["y"].get<std::vector<std::string>>();
  for (const std::string& one : chosen) {
    if (known.empty())
      throw std::invalid_argument(fmt::format("--y {}: this result has no quantities; compute it with --y \"{}\"", one, one));
    if (std::find(known.begin(), known.end(), one) == known.end())
      throw std::invalid_argument(fmt::format("--y {}: {}", one, unknown_name("quantity", one, known)));
  }
  result["options"]["y"] = chosen;
  return result;
}

Picture draw_shown(const PictureKind& kind, const Json& result) {
  const Json none = Json::object();
  const Json& options = result.contains("options") ? result["options"] : none;
  if (!options.contains("y")) return kind.draw(result);
  Picture picture;
  std::vector<Picture> further;
  for (const Json& quantity : options["y"]) {
    Picture one = kind.draw(with_quantity_as_state(result, quantity));
    if (picture.y_label.empty()) {
      picture = std::move(one);
      continue;
    }
    one.below.clear();
    one.title.clear();
    one.subtitle.clear();
    for (Curve& curve : one.curves) curve.title.clear();  // the legend above serves all axes
    one.x_range = picture.x_range;
    further.push_back(std::move(one));
  }
  picture.below.insert(picture.below.begin(), further.begin(), further.end());
  return picture;
}

}  // namespace graze::apps
