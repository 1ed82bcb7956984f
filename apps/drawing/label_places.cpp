// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/drawing/label_places.hpp>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

struct Box {
  double left, right, bottom, top;
};

bool overlap(const Box& a, const Box& b) { return a.left < b.right && b.left < a.right && a.bottom < b.top && b.bottom < a.top; }

Box box_of(const Label& label, const LabelPlace& place, double x, double y) {
  const double width = 1.1 * static_cast<double>(label.text.size()) + 1.0, near = x + place.right, middle = y + place.up;
  return {place.leftwards ? near - width : near, place.leftwards ? near : near + width, middle - 0.5, middle + 0.5};
}

/// The squares of a fine grid that lines cross or marks cover.
class DrawnSquares {
 public:
  DrawnSquares(const std::vector<Label>& labels, const std::vector<Curve>& curves, const std::array<double, 2>& x,
               const std::array<double, 2>& y, double rows, double columns)
      : width_(static_cast<int>(fine * columns)), height_(static_cast<int>(fine * rows)),
        taken_(static_cast<std::size_t>(width_ * height_), false) {
    constexpr double half_mark = 0.6 * fine;
    for (const Label& label : labels) {
      const double i = width_ * (label.x - x[0]) / (x[1] - x[0]), j = height_ * (label.y - y[0]) / (y[1] - y[0]);
      add(i - half_mark, j, i + half_mark, j);
    }
    for (const Curve& curve : curves) {
      if (curve.stroke == Stroke::dots) continue;
      if (curve.stroke == Stroke::marks) {
        for (const auto& point : curve.points) {
          const double i = width_ * (point[0] - x[0]) / (x[1] - x[0]), j = height_ * (point[1] - y[0]) / (y[1] - y[0]);
          add(i, j, i, j);
        }
        continue;
      }
      for (std::size_t i = 1; i < curve.points.size(); ++i) {
        const auto &a = curve.points[i - 1], &b = curve.points[i];
        add(width_ * (a[0] - x[0]) / (x[1] - x[0]), height_ * (a[1] - y[0]) / (y[1] - y[0]),
            width_ * (b[0] - x[0]) / (x[1] - x[0]), height_ * (b[1] - y[0]) / (y[1] - y[0]));
      }
    }
  }

  bool in(const Box& box) const {
    const auto clamped = [](double value, int most) { return std::clamp(static_cast<int>(std::floor(value)), 0, most - 1); };
    for (int j = clamped(fine * box.bottom, height_); j <= clamped(fine * box.top, height_); ++j)
      for (int i = clamped(fine * box.left, width_); i <= clamped(fine * box.right, width_); ++i)
        if (taken_[static_cast<std::size_t>(j * width_ + i)]) return true;
    return false;
  }

 private:
  static constexpr int fine = 4;  // squares per character

  void add(double from_x, double from_y, double to_x, double to_y) {
    const double length = std::max(std::abs(to_x - from_x), std::abs(to_y - from_y));
    if (!(length < 4.0 * width_)) return;  // NaN, or from far outside
    const int steps = 1 + static_cast<int>(length);
    for (int k = 0; k <= steps; ++k) {
      const double i = from_x + (to_x - from_x) * k / steps, j = from_y + (to_y - from_y) * k / steps;
      if (i >= 0.0 && i < width_ && j >= 0.0 && j < height_)
        taken_[static_cast<std::size_t>(static_cast<int>(j) * width_ + static_cast<int>(i))] = true;
    }
  }

  int width_, height_;
  std::vector<bool> taken_;
};

}  // namespace

bool is_crowd(const std::vector<Label>& labels) {
  return std::count_if(labels.begin(), labels.end(), [](const Label& label) { return !label.placed && !label.text.empty(); }) >
         30;
}

std::vector<LabelPlace> label_places(const std::vector<Label>& labels, const std::array<double, 2>& x,
                                     const std::array<double, 2>& y, const std::vector<Curve>& curves, double rows,
                                     double columns) {
  const DrawnSquares drawn(labels, curves, x, y, rows, columns);
  std::vector<LabelPlace> places;
  std::vector<Box> taken;
  const bool crowd = is_crowd(labels);
  const int steps = crowd ? 5 : 10;  // long lines to many marks would become a tangle
  for (const Label& label : labels) {
    const double column = columns * (label.x - x[0]) / (x[1] - x[0]), row = rows * (label.y - y[0]) / (y[1] - y[0]);
    LabelPlace chosen;
    double least = label.placed ? 0.0 : HUGE_VAL;
    // Above and below, to the right and to the left, then farther and farther away.
    for (int step = 0; step < steps && least > 0.0 && !label.text.empty(); ++step)
      for (const bool below : {false, true})
        for (const bool leftwards : {false, true}) {
          const double up = (below ? -1.0 : 1.0) * (0.7 + 1.1 * step), right = (leftwards ? -1.0 : 1.0) * (1.0 + 0.6 * step);
          const LabelPlace place{right, up, leftwards, step > 1};
          const Box box = box_of(label, place, column, row);
          const bool outside = box.left < 0.0 || box.right > columns || box.bottom < 0.0 || box.top > rows;
          const auto covered = std::count_if(taken.begin(), taken.end(), [&](const Box& other) { return overlap(box, other); });
          const double cost = static_cast<double>(covered) + (outside ? 100.0 : 0.0) + (drawn.in(box) ? 0.5 : 0.0);
          if (cost < least) {
            least = cost;
            chosen = place;
          }
        }
    chosen.free = label.placed || least < (crowd ? 0.5 : 1.0);
    if (!label.text.empty() && chosen.free) taken.push_back(box_of(label, chosen, column, row));
    places.push_back(chosen);
  }
  return places;
}

}  // namespace graze::apps
