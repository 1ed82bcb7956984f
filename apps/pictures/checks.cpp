// SPDX-License-Identifier: GPL-3.0-or-later
// Picture of graze.verify/1: disagreements and their bounds on a logarithmic scale.
#include <graze/apps/pictures/pictures.hpp>

#include <algorithm>

namespace graze::apps {

namespace {

Picture draw_checks(const Json& result) {
  constexpr double smallest = 1e-17;  // an exact agreement has no logarithm
  Picture picture;
  picture.title = "Checks";
  picture.subtitle = model_title(result);
  picture.y_label = "relative disagreement";
  picture.logarithmic_y = true;
  Curve disagreement, limit;
  disagreement.stroke = limit.stroke = Stroke::marks;
  disagreement.title = "disagreement";
  disagreement.size = limit.size = 1.5;
  limit.title = "bound";
  limit.mark = 2;
  limit.colour = "#b22222";
  for (const Json& orbit : result.at("orbits"))
    for (const Json& check : orbit.at("checks")) {
      const std::string name = check.at("name");
      const auto known = std::find(picture.x_names.begin(), picture.x_names.end(), name);
      const auto at = static_cast<double>(known - picture.x_names.begin());
      if (known == picture.x_names.end()) picture.x_names.push_back(name);
      if (check.at("disagreement").is_number())
        disagreement.points.push_back({at, std::max(smallest, check["disagreement"].get<double>()), 0.0});
      limit.points.push_back({at, check.at("bound"), 0.0});
    }
  picture.x_range = {{-0.5, static_cast<double>(picture.x_names.size()) - 0.5}};
  picture.curves = {disagreement, limit};
  return picture;
}

}  // namespace

PictureKind verify_picture() { return {"graze.verify/1", "checks", "disagreements against their bounds", draw_checks}; }

}  // namespace graze::apps
