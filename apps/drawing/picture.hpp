// SPDX-License-Identifier: GPL-3.0-or-later
// Picture: curves, marks and text in one pair of axes, or several pairs on one sheet, drawn by gnuplot. It knows nothing of
// oscillators: apps/pictures/ turns results into pictures.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace graze::apps {

enum class Stroke { solid, dashed, dotted, dots, marks };

/// A curve or a set of points. A NaN row breaks a curve.
struct Curve {
  std::string title = {};  ///< empty: not in the legend
  Stroke stroke = Stroke::solid;
  std::string colour = "#1f77b4";
  double size = 2.0;                               ///< line width, or size of a mark
  int mark = 7;                                    ///< gnuplot's point type, for Stroke::marks
  std::vector<std::array<double, 3>> points = {};  ///< x, y, and a value shown as colour if `coloured`
  bool coloured = false;
};

/// A mark in the legend only: its point lies far outside.
Curve legend_entry(const std::string& title, const std::string& colour);

inline constexpr int no_mark = -1;  ///< for a label that consists of words only

/// A point with a mark and text beside it.
struct Label {
  double x = 0.0, y = 0.0;
  std::string text;
  int mark = 7;  ///< gnuplot's point type, or no_mark
  std::string colour = "black";
  bool placed = false;  ///< its words stand right beside it: room was already found for them
};

/// A line across the picture: x = position (or y = position); `shaded`: the region beyond it is shaded.
struct Barrier {
  bool vertical = true;
  double position = 0.0;
  std::string text;  ///< in the legend; empty: no entry
  bool shaded = false;
  bool above = true;  ///< whether the shaded region is on the side of larger values
};

/// A field of coloured cells below everything else, centred at equally spaced values of x and y, at least two in each
/// direction.
struct Cells {
  std::vector<double> x, y;
  std::vector<std::string> colours;  ///< "#rrggbb"
  std::vector<int> colour = {};      ///< index of each cell's colour, row by row, x fastest; -1: none
};

/// A colour of a scale; between two stops colours are interpolated.
struct ColourStop {
  double value = 0.0;
  std::string colour;  ///< "#rrggbb"
};

struct Picture {
  std::string title, subtitle;
  std::string x_label, y_label, colour_label;
  std::optional<std::array<double, 2>> x_range, y_range, colour_range;
  std::vector<ColourStop> palette = {};  ///< for the values from colour_range[0] to [1]; empty: the default scale
  bool logarithmic_x = false, logarithmic_y = false;
  bool equal_axes = false;  ///< one unit has the same length in x and y
  bool unit_circle = false;
  bool grid = true;
  std::size_t legend_columns = 0;  ///< 0: as the length of its entries allows
  std::optional<Cells> cells = {};
  std::vector<Curve> curves;
  std::vector<Label> labels;
  std::vector<Barrier> barriers;
  std::vector<std::string> x_names;  ///< names at x = 0, 1, 2, ... instead of numbers
  double height = 1.0;               ///< of these axes, relative to others below or above them
  std::vector<Picture> below;        ///< further axes under these, with the same x axis
  std::vector<Picture> beside;       ///< or to the right of these
  bool common_legend = false;        ///< one legend for these axes and those beside them
};

/// Checks the file ending, which selects the format: "png", "svg", "pdf". @throws std::invalid_argument if `file` has another
/// one.
void check_picture_file(const std::string& file);

/// Whether gnuplot is installed, and the message if it is not.
bool can_draw();
inline constexpr const char* cannot_draw =
    "pictures are drawn by gnuplot, which is not installed (Debian: apt install gnuplot-nox)";

/// The commands for gnuplot. `format` is one of the file endings.
std::string gnuplot_script(const Picture& picture, const std::string& format);

/// The picture as the content of a file. @throws std::runtime_error with gnuplot's own message if it fails, Interrupted if a
/// signal arrives meanwhile.
std::string draw(const Picture& picture, const std::string& format);

/// The ending of a file name, in lower case.
std::string ending(const std::string& file);

}  // namespace graze::apps
