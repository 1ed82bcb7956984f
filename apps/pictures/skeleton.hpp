// SPDX-License-Identifier: GPL-3.0-or-later
// SkeletonCurves: the branches of a result as they are drawn, in the colours of their periods, with marks and words. The picture
// of a skeleton is made of them alone; in that of a diagram they lie over the sweeps.
#pragma once

#include <graze/apps/drawing/word_places.hpp>
#include <graze/apps/pictures/branch_curves.hpp>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace graze::apps {

inline constexpr int longest_with_words = 4;  ///< periods up to this one come first where words need room
inline constexpr const char* mark_colour = "#000000";

struct SkeletonCurves {
  using Point = std::array<double, 3>;
  struct Named {
    int period;
    std::string label;
    double value;
    std::vector<double> x;  ///< the largest iterate first
  };
  std::map<std::pair<int, Stroke>, std::vector<Point>> curves;       ///< by period and stroke, NaN between pieces
  std::map<std::pair<std::string, bool>, std::vector<Point>> marks;  ///< by type and whether the period is long
  std::map<std::string, int> mark_types;
  std::vector<Named> named;  ///< special points in the order of the parameter
};

/// Branches of a result, the gaps between a doubled branch and its doubling closed.
SkeletonCurves skeleton_curves(const Json& result);

/// The same in all pictures; doublings of one and of three are far apart.
std::string colour_of_period(int period);

/// More branches than this are not told apart by colours of their own, but by those of their periods.
inline constexpr std::size_t most_branch_colours = 8;

/// Axes of the picture, and its places measured in characters.
struct SkeletonAxes {
  std::array<double, 2> x = {HUGE_VAL, -HUGE_VAL}, y = {HUGE_VAL, -HUGE_VAL};
  double rows = 20.0;
  Cell cell(double at_x, double at_y) const {
    return {WordPlaces::columns * (at_x - x[0]) / (x[1] - x[0]), rows * (at_y - y[0]) / (y[1] - y[0])};
  }
  SkeletonCurves::Point point(Cell cell) const {
    return {x[0] + cell.column / WordPlaces::columns * (x[1] - x[0]), y[0] + cell.row / rows * (y[1] - y[0]), 0.0};
  }
  /// Widens them so that the point lies within.
  void take_in(double at_x, double at_y);
  void take_in(const SkeletonCurves& parts);
  /// Margins around what was taken in, so that it does not touch the frame; above, names need room.
  void add_margins(const SkeletonCurves& parts);
};

/// Words of a picture: names of special points and z along the branches, each where there is room for it.
struct SkeletonWords {
  std::vector<Label> labels;
  Curve leaders;    ///< lines from names to their marks
  int without = 0;  ///< special points for whose names there was no room
};

/// `barriers`: lines that words keep off; `samples`: dots that words keep off where they can.
SkeletonWords skeleton_words(const Json& result, const SkeletonCurves& parts, const SkeletonAxes& axes,
                             const std::vector<Barrier>& barriers, const std::vector<Curve>& samples);

/// A line of the legend that stands for curves drawn elsewhere: gnuplot wants a point for it, which lies outside the axes.
Curve legend_line(const SkeletonAxes& axes, const std::string& title, Stroke stroke, const std::string& colour, double size);

/// Lines of the legend; `widths`: of the curves, 1 in the picture of a skeleton alone.
std::vector<Curve> skeleton_legend(const SkeletonCurves& parts, const SkeletonAxes& axes, double widths);

/// Rows of characters that a legend of so many entries takes from the axes.
double legend_rows(std::size_t entries);

/// Adds curves, words and marks to the picture, and to its subtitle what they mean. `samples`: as in skeleton_words().
void add_skeleton(Picture& picture, const Json& result, const SkeletonCurves& parts, const SkeletonAxes& axes, double widths,
                  const std::vector<Curve>& samples = {});

/// The whole picture of a result; `values`: special points are named with their values.
Picture skeleton_of(const Json& result, const std::string& title, bool values);

}  // namespace graze::apps
