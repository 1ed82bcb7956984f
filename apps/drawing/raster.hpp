// SPDX-License-Identifier: GPL-3.0-or-later
// Images: coloured cells, and curves with too many points for gnuplot, which would draw for minutes, converted to the pixels that
// they touch. The cost of an image does not depend on the number of points. No visible detail is lost.
#pragma once

#include <graze/apps/drawing/picture.hpp>

#include <array>
#include <string>
#include <vector>

namespace graze::apps {

/// Whether a curve is better drawn as an image.
bool is_dense(const Curve& curve);

/// Whether a curve is drawn in the same image as a dense one, so that clouds of dots keep their drawing order.
bool goes_with_dense(const Curve& curve);

/// The points of a line without those indistinguishable from the previous one; short curves stay unchanged.
std::vector<std::array<double, 3>> thinned(const Curve& curve, const std::array<double, 2>& x, const std::array<double, 2>& y);

/// Pixels of equal size, as gnuplot reads them.
struct Image {
  int columns = 0, rows = 0;
  std::array<double, 2> first{}, step{};  ///< x and y of the centre of the first pixel, and the spacing of columns and rows
  std::string rgba;                       ///< four bytes per pixel, row by row
};

/// Each cell as a block of several pixels, so that its edges stay sharp when the image is enlarged.
Image image_of(const Cells& cells);

/// The pixels touched by curves; later curves lie on top.
class Raster {
 public:
  /// `x`, `y`: the ranges of the axes; `columns`, `rows`: numbers of pixels, at most those of the axes: gnuplot drops pixels
  /// without room.
  Raster(const std::array<double, 2>& x, const std::array<double, 2>& y, int columns = 800, int rows = 500);
  void paint(const Curve& curve);
  Image image() const;
  /// Number of painted pixels.
  std::size_t painted() const;

 private:
  void mark(double column, double row, int width);
  void line(double column, double row, double to_column, double to_row, int width);

  std::array<double, 2> x_, y_;
  int columns_, rows_;
  std::vector<unsigned char> cells_;  // 0: nothing; otherwise the number of the colour, from 1
  std::vector<std::string> colours_;
};

}  // namespace graze::apps
