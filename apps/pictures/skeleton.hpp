// SPDX-License-Identifier: GPL-3.0-or-later
// SkeletonCurves: the branches of a result in drawable form, in the colours of their periods, with marks and words. They make
// up the picture of a skeleton; in a diagram they lie over the sweeps.
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

inline constexpr int longest_with_words = 4;  ///< periods up to this one have priority for room for words
inline constexpr const char* mark_colour = "#000000";

struct SkeletonCurves {
  using Point = std::array<double, 3>;
  struct Named {
    int period;
    std::string label;
    double value;
    std::vector<double> x;  ///< largest iterate first
  };
  std::map<std::pair<int, Stroke>, std::vector<Point>> curves;       ///< by period and stroke, NaN between pieces
  std::map<std::pair<std::string, bool>, std::vector<Point>> marks;  ///< by type and whether the period is long
  std::map<std::string, int> mark_types;
  std::vector<Named> named;  ///< special points in the order of the parameter
};

/// The branches of a result, with the gaps between doubled branches and their doublings closed.
SkeletonCurves skeleton_curves(const Json& result);

/// The colour of a period, the same in all pictures; the doublings of periods one and three have clearly different colours.
std::string colour_of_period(int period);

/// Above this number, branches are coloured by period instead of individually.
inline constexpr std::size_t most_branch_colours = 8;

/// The axes of the picture, and places in it measured in characters.
struct SkeletonAxes {
  std::array<double, 2> x = {HUGE_VAL, -HUGE_VAL}, y = {HUGE_VAL, -HUGE_VAL};
  double rows = 20.0;
  Cell cell(double at_x, double at_y) const {
    return {WordPlaces::columns * (at_x - x[0]) / (x[1] - x[0]), rows * (at_y - y[0]) / (y[1] - y[0])};
  }
  SkeletonCurves::Point point(Cell cell) const {
    return {x[0] + cell.column / WordPlaces::columns * (x[1] - x[0]), y[0] + cell.row / rows * (y[1] - y[0]), 0.0};
  }
  /// Widens the axes so that they contain the point.
  void take_in(double at_x, double at_y);
  void take_in(const SkeletonCurves& parts);
  /// Adds margins, so that the curves do not touch the frame; names need room above.
  void add_margins(const SkeletonCurves& parts);
};

/// The words of a picture: names of special points and z along the branches, each only if there is room.
struct SkeletonWords {
  std::vector<Label> labels;
  Curve leaders;    ///< lines from names to their marks
  int without = 0;  ///< number of special points without room for their names
};

/// `barriers`: lines that words avoid; `samples`: dots that words avoid if possible.
SkeletonWords skeleton_words(const Json& result, const SkeletonCurves& parts, const SkeletonAxes& axes,
                             const std::vector<Barrier>& barriers, const std::vector<Curve>& samples);

/// A line of the legend for curves drawn elsewhere: gnuplot requires a point for it, which lies outside the axes.
Curve legend_line(const SkeletonAxes& axes, const std::string& title, Stroke stroke, const std::string& colour, double size);

/// The lines of the legend; `widths`: scale of the curves' widths, 1 in the picture of a skeleton alone.
std::vector<Curve> skeleton_legend(const SkeletonCurves& parts, const SkeletonAxes& axes, double widths);

/// Rows of characters that a legend with this number of entries takes from the axes.
double legend_rows(std::size_t entries);

/// Adds curves, words and marks to the picture, and their explanation to its subtitle. `samples`: as in skeleton_words().
void add_skeleton(Picture& picture, const Json& result, const SkeletonCurves& parts, const SkeletonAxes& axes, double widths,
                  const std::vector<Curve>& samples = {});

/// The whole picture of a result; `values`: names of special points include their values.
Picture skeleton_of(const Json& result, const std::string& title, bool values);

}  // namespace graze::apps
