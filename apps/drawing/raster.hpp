// SPDX-License-Identifier: GPL-3.0-or-later
// Images: coloured cells, and curves of so many points that gnuplot would draw for minutes, turned into the picture elements that
// they touch: these cost the same however many there are. Nothing that could be seen is lost.
#pragma once

#include <graze/apps/drawing/picture.hpp>

#include <array>
#include <string>
#include <vector>

namespace graze::apps {

/// Whether a curve is better drawn as an image.
bool is_dense(const Curve& curve);

/// Whether it is drawn in the same image as a dense one: clouds of dots keep their order, which of them lies on top.
bool goes_with_dense(const Curve& curve);

/// The points of a line without those that cannot be told from the one before; short curves stay as they are.
std::vector<std::array<double, 3>> thinned(const Curve& curve, const std::array<double, 2>& x, const std::array<double, 2>& y);

/// Picture elements of equal size, as gnuplot reads them.
struct Image {
  int columns = 0, rows = 0;
  std::array<double, 2> first{}, step{};  ///< x and y of the middle of the first, and of the way to the next column and row
  std::string rgba;                       ///< four bytes each, row by row
};

/// Each cell as so many elements that its edges stay sharp however the image is enlarged.
Image image_of(const Cells& cells);

/// Picture elements touched by curves; those painted later lie on top.
class Raster {
 public:
  /// `x`, `y`: the ranges of the axes; `columns`, `rows`: elements, no more than the axes have: gnuplot loses what it has no room
  /// for.
  Raster(const std::array<double, 2>& x, const std::array<double, 2>& y, int columns = 800, int rows = 500);
  void paint(const Curve& curve);
  Image image() const;
  /// Elements painted.
  std::size_t painted() const;

 private:
  void mark(double column, double row, int width);
  void line(double column, double row, double to_column, double to_row, int width);

  std::array<double, 2> x_, y_;
  int columns_, rows_;
  std::vector<unsigned char> cells_;  // 0: nothing; else the number of the colour, from 1
  std::vector<std::string> colours_;
};

}  // namespace graze::apps
