// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/drawing/raster.hpp>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

constexpr int usual_columns = 800, usual_rows = 500;
constexpr std::size_t many_points = 12000;  // gnuplot needs a second for these, and ever longer for crossing lines
constexpr std::size_t few_points = 5000;

double place(double value, const std::array<double, 2>& range, int count) {
  return count * (value - range[0]) / (range[1] - range[0]);
}

bool is_line(const Curve& curve) {
  return curve.stroke == Stroke::solid || curve.stroke == Stroke::dashed || curve.stroke == Stroke::dotted;
}

using Rgba = std::array<char, 4>;
constexpr Rgba nothing = {};

/// The colour of "#rrggbb"; black for any other name.
Rgba rgba(const std::string& name) {
  const unsigned long rgb = name.size() == 7 && name[0] == '#' ? std::stoul(name.substr(1), nullptr, 16) : 0;
  return {static_cast<char>(rgb >> 16 & 255), static_cast<char>(rgb >> 8 & 255), static_cast<char>(rgb & 255), '\xff'};
}

}  // namespace

bool is_dense(const Curve& curve) { return curve.points.size() > many_points && !curve.coloured; }

bool goes_with_dense(const Curve& curve) {
  constexpr std::size_t cloud = 500;
  return is_dense(curve) || (curve.stroke == Stroke::dots && curve.points.size() > cloud && !curve.coloured);
}

std::vector<std::array<double, 3>> thinned(const Curve& curve, const std::array<double, 2>& x, const std::array<double, 2>& y) {
  if (curve.points.size() < few_points || !is_line(curve)) return curve.points;
  constexpr int fine = 4;  // parts of a pixel
  std::vector<std::array<double, 3>> kept;
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const auto& point = curve.points[i];
    const bool last = i + 1 == curve.points.size() || std::isnan(curve.points[i + 1][0] + curve.points[i + 1][1]);
    const bool near = !kept.empty() &&
                      std::abs(place(point[0], x, fine * usual_columns) - place(kept.back()[0], x, fine * usual_columns)) < 1.0 &&
                      std::abs(place(point[1], y, fine * usual_rows) - place(kept.back()[1], y, fine * usual_rows)) < 1.0;
    if (last || !near) kept.push_back(point);
  }
  return kept;
}

Raster::Raster(const std::array<double, 2>& x, const std::array<double, 2>& y, int columns, int rows)
    : x_(x), y_(y), columns_(columns), rows_(rows), cells_(static_cast<std::size_t>(columns * rows), 0) {}

void Raster::mark(double column, double row, int width) {
  const auto set = [&](double c, double r) {
    if (!(c >= 0.0 && c <= columns_ && r >= 0.0 && r <= rows_)) return;
    const int i = std::min(static_cast<int>(c), columns_ - 1), j = std::min(static_cast<int>(r), rows_ - 1);
    cells_[static_cast<std::size_t>(j * columns_ + i)] = static_cast<unsigned char>(colours_.size());
  };
  if (width > 2) {  // a disc
    const int half = width / 2;
    for (int dr = -half; dr <= half; ++dr)
      for (int dc = -half; dc <= half; ++dc)
        if (dc * dc + dr * dr <= half * half + 1) set(column + dc, row + dr);
    return;
  }
  set(column, row);
  if (width < 2) return;
  set(column + 1.0, row);
  set(column, row + 1.0);
}

void Raster::line(double column, double row, double to_column, double to_row, int width) {
  // Clipped to the picture (Liang and Barsky): a line may come from far outside.
  double from = 0.0, to = 1.0;
  const auto clip = [&](double start, double change, double limit) {
    if (change == 0.0) {
      if (start < 0.0 || start > limit) to = -1.0;
      return;
    }
    const double a = -start / change, b = (limit - start) / change;
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  };
  const double dc = to_column - column, dr = to_row - row;
  clip(column, dc, columns_);
  clip(row, dr, rows_);
  if (!(from <= to)) return;
  const int steps = 1 + static_cast<int>(2.0 * (to - from) * std::max(std::abs(dc), std::abs(dr)));  // half a pixel each
  for (int i = 0; i <= steps; ++i) {
    const double s = from + (to - from) * i / steps;
    mark(column + s * dc, row + s * dr, width);
  }
}

void Raster::paint(const Curve& curve) {
  if (colours_.size() < 255) colours_.push_back(curve.colour);
  const double size = curve.size;
  const int width = is_line(curve) ? (size > 1.5 ? 2 : 1) : size > 0.8 ? 5 : size > 0.4 ? 3 : size > 0.2 ? 2 : 1;
  double last_column = std::nan(""), last_row = last_column;
  for (const auto& point : curve.points) {
    const double column = place(point[0], x_, columns_), row = place(point[1], y_, rows_);
    if (is_line(curve) && std::isfinite(last_column + last_row + column + row))
      line(last_column, last_row, column, row, width);
    else
      mark(column, row, width);
    last_column = column;
    last_row = row;
  }
}

std::size_t Raster::painted() const {
  return static_cast<std::size_t>(std::count_if(cells_.begin(), cells_.end(), [](unsigned char cell) { return cell > 0; }));
}

Image Raster::image() const {
  std::vector<Rgba> colours = {nothing};
  for (const std::string& name : colours_) colours.push_back(rgba(name));
  Image out{columns_, rows_, {}, {(x_[1] - x_[0]) / columns_, (y_[1] - y_[0]) / rows_}, {}};
  out.first = {x_[0] + 0.5 * out.step[0], y_[0] + 0.5 * out.step[1]};
  out.rgba.reserve(4 * cells_.size());
  for (const unsigned char cell : cells_) out.rgba.append(colours[cell].data(), 4);
  return out;
}

Image image_of(const Cells& cells) {
  constexpr std::size_t wide = usual_columns, high = usual_rows;
  const std::size_t nx = cells.x.size(), ny = cells.y.size();
  const std::size_t kx = std::max<std::size_t>(1, wide / nx), ky = std::max<std::size_t>(1, high / ny);
  Image out;
  out.columns = static_cast<int>(nx * kx);
  out.rows = static_cast<int>(ny * ky);
  const auto lay_out = [&](std::size_t axis, const std::vector<double>& values, std::size_t parts) {
    const double cell = (values.back() - values.front()) / static_cast<double>(values.size() - 1);
    out.step[axis] = cell / static_cast<double>(parts);
    out.first[axis] = values.front() - 0.5 * cell + 0.5 * out.step[axis];
  };
  lay_out(0, cells.x, kx);
  lay_out(1, cells.y, ky);
  std::vector<Rgba> colours;
  for (const std::string& name : cells.colours) colours.push_back(rgba(name));
  out.rgba.reserve(4 * nx * kx * ny * ky);
  for (std::size_t j = 0; j < ny; ++j) {
    const std::size_t begin = out.rgba.size();
    for (std::size_t i = 0; i < nx; ++i) {
      const int colour = cells.colour[j * nx + i];
      for (std::size_t k = 0; k < kx; ++k)
        out.rgba.append(colour < 0 ? nothing.data() : colours[static_cast<std::size_t>(colour)].data(), 4);
    }
    const std::string row = out.rgba.substr(begin);
    for (std::size_t k = 1; k < ky; ++k) out.rgba += row;
  }
  return out;
}

}  // namespace graze::apps
