// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/label_places.hpp>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

// The axes measured in characters of the default picture; what matters is that a box is not smaller than its words.
constexpr double axes_width = 92.0, axes_height = 26.0;

struct Box {
  double left, right, bottom, top;
};

bool overlap(const Box& a, const Box& b) { return a.left < b.right && b.left < a.right && a.bottom < b.top && b.bottom < a.top; }

Box box_of(const Label& label, const LabelPlace& place, double x, double y) {
  const double width = static_cast<double>(label.text.size()) + 1.0, near = x + place.right, middle = y + place.up;
  return {place.leftwards ? near - width : near, place.leftwards ? near : near + width, middle - 0.5, middle + 0.5};
}

}  // namespace

std::vector<LabelPlace> label_places(const std::vector<Label>& labels, const std::array<double, 2>& x,
                                     const std::array<double, 2>& y) {
  std::vector<LabelPlace> places;
  std::vector<Box> taken;
  for (const Label& label : labels) {
    const double column = axes_width * (label.x - x[0]) / (x[1] - x[0]), row = axes_height * (label.y - y[0]) / (y[1] - y[0]);
    LabelPlace chosen;
    double least = HUGE_VAL;
    // Above and below, to the right and to the left, and then ever farther away.
    for (int step = 0; step < 10 && least > 0.0 && !label.text.empty(); ++step)
      for (const bool below : {false, true})
        for (const bool leftwards : {false, true}) {
          const double up = (below ? -1.0 : 1.0) * (0.7 + 1.1 * step), right = (leftwards ? -1.0 : 1.0) * (1.0 + 0.6 * step);
          const LabelPlace place{right, up, leftwards, step > 1};
          const Box box = box_of(label, place, column, row);
          const bool outside = box.left < 0.0 || box.right > axes_width || box.bottom < 0.0 || box.top > axes_height;
          const auto covered = std::count_if(taken.begin(), taken.end(), [&](const Box& other) { return overlap(box, other); });
          const double cost = static_cast<double>(covered) + (outside ? 100.0 : 0.0);
          if (cost < least) {
            least = cost;
            chosen = place;
          }
        }
    if (!label.text.empty()) taken.push_back(box_of(label, chosen, column, row));
    places.push_back(chosen);
  }
  return places;
}

}  // namespace graze::apps
