// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/label_places.hpp>
#include <graze/apps/number.hpp>
#include <graze/apps/picture.hpp>
#include <graze/apps/raster.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <stdexcept>

namespace graze::apps {

namespace {

/// In single quotes, inside which gnuplot substitutes nothing; a line break is put in between.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? "''" : c == '\n' ? "'.\"\\n\".'" : std::string(1, c);
  return out + "'";
}

std::string range(const std::optional<std::array<double, 2>>& limits) {
  return limits ? fmt::format("[{}:{}]", exact((*limits)[0]), exact((*limits)[1])) : "[*:*]";
}

std::string terminal(const std::string& format) {
  // Text as it stands ("noenhanced": k_H is not k with an index), in sizes that can be read at a width of 800.
  if (format == "svg") return "set terminal svg noenhanced size 1000,700 font 'Sans,15' background 'white'";
  if (format == "pdf") return "set terminal pdfcairo noenhanced size 10in,7in font 'Sans,15'";
  return "set terminal pngcairo noenhanced size 1000,700 font 'Sans,13' background 'white'";
}

std::string style(const Curve& curve) {
  const std::string colour = curve.coloured ? "lc palette" : "lc rgb " + quoted(curve.colour);
  switch (curve.stroke) {
  case Stroke::solid:
    return fmt::format("with lines {} lw {} dt 1", colour, curve.size);
  case Stroke::dashed:
    return fmt::format("with lines {} lw {} dt (8,6)", colour, curve.size);
  case Stroke::dotted:
    return fmt::format("with lines {} lw {} dt (2,5)", colour, curve.size);
  case Stroke::dots:
    return fmt::format("with points pt 7 ps {} {}", curve.size, colour);
  case Stroke::marks:
    break;
  }
  return fmt::format("with points pt {} ps {} {}", curve.mark, curve.size, colour);
}

std::string data_block(const std::string& name, const std::vector<std::array<double, 3>>& points) {
  std::string out = "$" + name + " << END\n";
  for (const std::array<double, 3>& p : points)
    out += std::isnan(p[0]) || std::isnan(p[1]) ? "\n" : fmt::format("{} {} {}\n", p[0], p[1], std::isnan(p[2]) ? 0.0 : p[2]);
  return out + "END\n";
}

/// The legend has rows of its own below the axis label, which gnuplot's own placement writes over.
std::string legend(const Picture& picture) {
  std::size_t entries = picture.unit_circle ? 1 : 0, longest = 0;
  for (const Curve& curve : picture.curves) {
    entries += curve.title.empty() ? 0 : 1;
    longest = std::max(longest, curve.title.size());
  }
  const std::size_t columns = longest > 24 ? 2 : 3, rows = (entries + columns - 1) / columns;
  const int size = rows > 4 ? 9 : 13;
  return fmt::format(
      "set key at screen 0.5, screen 0.015 bottom center horizontal maxcols {} samplen 3 font ',{}'\nset bmargin {}\n", columns,
      size, (picture.x_names.empty() ? 4.0 : 6.5) + (size < 13 ? 0.9 : 1.25) * static_cast<double>(rows));
}

/// The range of one coordinate: as given, or that of the curves.
std::array<double, 2> extent(const Picture& picture, std::size_t coordinate, const std::optional<std::array<double, 2>>& given) {
  if (given) return *given;
  std::array<double, 2> range = {HUGE_VAL, -HUGE_VAL};
  for (const Curve& curve : picture.curves)
    for (const auto& point : curve.points)
      if (std::isfinite(point[coordinate]))
        range = {std::min(range[0], point[coordinate]), std::max(range[1], point[coordinate])};
  if (range[0] > range[1]) return {-1.0, 1.0};
  // Differences this small against the value itself are rounding, which is no picture of anything.
  const double size = std::max(std::abs(range[0]), std::abs(range[1])), least = 1e-6 * size;
  if (range[1] - range[0] > least) return range;
  const double half = size > 0.0 ? 0.01 * size : 1.0;
  return {range[0] - half, range[1] + half};
}

/// A range to draw in: as given, or with a margin where gnuplot's own would be that of noise, or an image needs to know it.
std::optional<std::array<double, 2>> drawn_range(const Picture& picture, std::size_t coordinate, bool known,
                                                 const std::optional<std::array<double, 2>>& given) {
  if (given) return given;
  double lowest = HUGE_VAL, highest = -HUGE_VAL;
  for (const Curve& curve : picture.curves)
    for (const auto& point : curve.points)
      if (std::isfinite(point[coordinate])) {
        lowest = std::min(lowest, point[coordinate]);
        highest = std::max(highest, point[coordinate]);
      }
  const bool logarithmic = coordinate == 1 && picture.logarithmic_y;
  if (logarithmic || lowest > highest) return std::nullopt;
  const std::array<double, 2> all = extent(picture, coordinate, given);
  if (all[0] < lowest) return all;
  if (!known) return std::nullopt;
  const double margin = 0.03 * (all[1] - all[0]);
  return std::array<double, 2>{all[0] - margin, all[1] + margin};
}

/// Lines of a width that fits above the picture, broken where a list goes on.
std::string wrapped(const std::string& text) {
  constexpr std::size_t longest = 96;
  const std::size_t lines = (text.size() + longest - 1) / longest, width = text.size() / std::max<std::size_t>(lines, 1) + 8;
  std::string out, rest = text;
  while (rest.size() > width) {
    std::size_t cut = rest.rfind(", ", width - 1);
    if (cut == std::string::npos || cut < width / 3) cut = rest.rfind(' ', width);
    if (cut == std::string::npos || cut == 0) break;
    if (rest[cut] == ',') ++cut;
    out += rest.substr(0, cut) + "\n";
    rest.erase(0, cut + 1);
  }
  return out + rest;
}

/// Marks, their words where there is room for them, and lines that lead from far words to their marks.
std::string labels(const Picture& picture) {
  std::string s;
  const std::vector<LabelPlace> places =
      label_places(picture.labels, extent(picture, 0, picture.x_range), extent(picture, 1, picture.y_range));
  for (std::size_t i = 0; i < picture.labels.size(); ++i) {
    const Label& label = picture.labels[i];
    const LabelPlace& place = places[i];
    const std::string at = exact(label.x) + ", " + exact(label.y), colour = quoted(label.colour);
    s += fmt::format("set label {} at {} {} point pt {} ps 1.4 lc rgb {} offset {},{} front tc rgb {}\n", quoted(label.text), at,
                     place.leftwards ? "right" : "left", label.mark, colour, place.right, place.up, colour);
    if (place.far)
      s += fmt::format("set arrow from {} rto character {}, character {} nohead front lc rgb {} lw 0.8\n", at, place.right,
                       place.up, colour);
  }
  return s;
}

}  // namespace

std::string ending(const std::string& file) {
  std::string text = std::filesystem::path(file).extension().string();
  if (!text.empty()) text.erase(0, 1);
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::string gnuplot_script(const Picture& picture, const std::string& format) {
  std::string s = terminal(format) + "\n";
  s += "set encoding utf8\n";
  s += "set title " + quoted(wrapped(picture.title) + (picture.subtitle.empty() ? "" : "\n" + wrapped(picture.subtitle))) + "\n";
  s += "set xlabel " + quoted(picture.x_label) + "\nset ylabel " + quoted(picture.y_label) + "\n";
  s += "set border lw 1.2\nset tics out nomirror\n";
  s += legend(picture);
  if (picture.grid) s += "set grid lc rgb '#dddddd' lt 1 lw 0.8\n";
  const bool image = !picture.logarithmic_y && std::any_of(picture.curves.begin(), picture.curves.end(), is_dense);
  const auto x_range = drawn_range(picture, 0, image, picture.x_range), y_range = drawn_range(picture, 1, image, picture.y_range);
  s += "set xrange " + range(x_range) + "\nset yrange " + range(y_range) + "\n";
  if (picture.logarithmic_y) s += "set logscale y\nset format y '%.0e'\n";
  if (picture.equal_axes) s += "set size ratio -1\n";
  if (!picture.colour_label.empty())
    s += "set cblabel " + quoted(picture.colour_label) +
         "\nset palette defined (0 '#2c2a7a', 0.5 '#1fa187', 1 '#f2a104')\nset cbrange " + range(picture.colour_range) + "\n";
  else
    s += "unset colorbox\nset rmargin 4\n";
  if (!picture.x_names.empty()) {
    s += "set xtics (";
    for (std::size_t i = 0; i < picture.x_names.size(); ++i)
      s += fmt::format("{}{} {}", i ? ", " : "", quoted(picture.x_names[i]), i);
    s += ") rotate by 20 right\n";
  }
  int object = 1;
  for (const Barrier& barrier : picture.barriers) {
    const std::string at = exact(barrier.position);
    const std::string from = barrier.vertical ? at + ", graph 0" : "graph 0, first " + at;
    const std::string to = barrier.vertical ? at + ", graph 1" : "graph 1, first " + at;
    s += fmt::format("set arrow from {} to {} nohead front lc rgb '#b22222' lw 1.8\n", from, to);
    if (barrier.shaded)
      s += fmt::format(
          "set object {} rectangle from {} to graph 1, graph 1 behind fc rgb '#b22222' fs transparent solid 0.07 noborder\n",
          object++, from);
    s +=
        barrier.vertical
            ? fmt::format("set label {} at {}, graph 0.03 right offset -0.6,0 front tc rgb '#b22222'\n", quoted(barrier.text), at)
            : fmt::format("set label {} at graph 0.01, first {} offset 0,0.6 front tc rgb '#b22222'\n", quoted(barrier.text), at);
  }
  s += labels(picture);
  if (picture.unit_circle) {
    std::vector<std::array<double, 3>> circle;
    for (int i = 0; i <= 360; ++i) circle.push_back({std::cos(i * M_PI / 180.0), std::sin(i * M_PI / 180.0), 0.0});
    s += data_block("circle", circle);
  }
  std::string plot = picture.unit_circle ? "$circle using 1:2 with lines lc rgb '#888888' lw 1.2 title 'unit circle'" : "";
  const std::array<double, 2> x = extent(picture, 0, x_range), y = extent(picture, 1, y_range);
  if (image) {
    Raster raster(x, y);
    for (const Curve& curve : picture.curves)
      if (is_dense(curve)) raster.paint(curve);
    s += "$raster << END\n" + raster.data() + "END\n";
    plot += std::string(plot.empty() ? "" : ", \\\n     ") + "$raster using 1:2:3:4:5:6 with rgbalpha notitle";
  }
  for (std::size_t i = 0; i < picture.curves.size(); ++i) {
    const Curve& curve = picture.curves[i];
    if (image && is_dense(curve)) {
      // What stands for it in the legend; a point outside the picture is no point.
      if (!curve.title.empty()) plot += fmt::format(", \\\n     NaN {} title {}", style(curve), quoted(curve.title));
      continue;
    }
    const bool empty =
        std::all_of(curve.points.begin(), curve.points.end(), [](const auto& p) { return std::isnan(p[0] + p[1]); });
    if (empty) continue;
    const std::string name = fmt::format("curve{}", i);
    s += data_block(name, thinned(curve, x, y));
    plot += fmt::format("{}${} using {} {} {}", plot.empty() ? "" : ", \\\n     ", name, curve.coloured ? "1:2:3" : "1:2",
                        style(curve), curve.title.empty() ? "notitle" : "title " + quoted(curve.title));
  }
  if (plot.empty()) throw std::runtime_error("there is nothing to draw");
  return s + "plot " + plot + "\n";
}

}  // namespace graze::apps
