// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/drawing/label_places.hpp>
#include <graze/apps/drawing/legend.hpp>
#include <graze/apps/drawing/picture.hpp>
#include <graze/apps/drawing/raster.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <stdexcept>

namespace graze::apps {

namespace {

/// In single quotes, inside which gnuplot substitutes nothing; line breaks are inserted between quoted parts.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? "''" : c == '\n' ? "'.\"\\n\".'" : std::string(1, c);
  return out + "'";
}

std::string range(const std::optional<std::array<double, 2>>& limits) {
  return limits ? fmt::format("[{}:{}]", exact((*limits)[0]), exact((*limits)[1])) : "[*:*]";
}

/// A sheet in pixels (1/100 inch).
struct Sheet {
  int width = 1000, height = 700;
};

std::string terminal(const std::string& format, const Sheet& sheet) {
  // Literal text ("noenhanced": k_H does not become k with a subscript), in sizes readable at a width of 800.
  const std::string size = fmt::format("{},{}", sheet.width, sheet.height);
  if (format == "svg") return "set terminal svg noenhanced size " + size + " font 'Sans,15' background 'white'";
  if (format == "pdf")
    return fmt::format("set terminal pdfcairo noenhanced size {}in,{}in font 'Sans,15'", sheet.width / 100.0,
                       sheet.height / 100.0);
  return "set terminal pngcairo noenhanced size " + size + " font 'Sans,13' background 'white'";
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

/// The legend has rows of its own below the axis label; gnuplot's own placement would overwrite the label.
std::string legend(const Picture& picture, double x, double y) {
  const Legend legend = legend_of(picture);
  return fmt::format("set key at screen {}, screen {} bottom center horizontal maxcols {} samplen 3 font ',{}'\n", x, y,
                     legend.columns, legend.font);
}

/// Room below the axes, in lines of text, for tics, axis label and legend.
double lines_below(const Picture& picture, bool names_x) {
  const Legend legend = legend_of(picture);
  return (!names_x ? 1.0 : picture.x_names.empty() ? 4.0 : 6.5) + legend.row_height() * static_cast<double>(legend.rows);
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
  // Differences this small relative to the value are rounding noise, which is not worth a picture.
  const double size = std::max(std::abs(range[0]), std::abs(range[1])), least = 1e-6 * size;
  if (range[1] - range[0] > least) return range;
  const double half = size > 0.0 ? 0.01 * size : 1.0;
  return {range[0] - half, range[1] + half};
}

/// The range to draw: as given, or with a margin if gnuplot's own range would show only noise, or if an image requires a known
/// range.
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
  const bool logarithmic = coordinate == 0 ? picture.logarithmic_x : picture.logarithmic_y;
  if (logarithmic || lowest > highest) return std::nullopt;
  const std::array<double, 2> all = extent(picture, coordinate, given);
  if (all[0] < lowest) return all;
  if (!known) return std::nullopt;
  const double margin = 0.03 * (all[1] - all[0]);
  return std::array<double, 2>{all[0] - margin, all[1] + margin};
}

/// The text in lines of a width that fits above the picture, broken after commas if possible.
std::string wrapped(const std::string& text) {
  if (const std::size_t end = text.find('\n'); end != std::string::npos)
    return wrapped(text.substr(0, end)) + "\n" + wrapped(text.substr(end + 1));
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

/// An entry of gnuplot's plot command; the image data follow the command.
std::string image_plot(const Image& image) {
  return fmt::format("'-' binary array=({},{}) dx={} dy={} origin=({},{}) format='%uchar%uchar%uchar%uchar' using 1:2:3:4 "
                     "with rgbalpha notitle",
                     image.columns, image.rows, exact(image.step[0]), exact(image.step[1]), exact(image.first[0]),
                     exact(image.first[1]));
}

std::string title_of(const Picture& picture) {
  return wrapped(picture.title) + (picture.subtitle.empty() ? "" : "\n" + wrapped(picture.subtitle));
}

double title_lines_of(const Picture& picture) {
  const std::string title = title_of(picture);
  return title.empty() ? 0.6 : 1.0 + static_cast<double>(std::count(title.begin(), title.end(), '\n') + 1);
}

std::vector<std::array<double, 3>> unit_circle() {
  std::vector<std::array<double, 3>> circle;
  for (int i = 0; i <= 360; ++i) circle.push_back({std::cos(i * M_PI / 180.0), std::sin(i * M_PI / 180.0), 0.0});
  return circle;
}

/// Marks, their words if there is room, and lines that lead from distant words to their marks.
std::string labels(const Picture& picture) {
  std::string s;
  if (picture.labels.empty()) return s;
  std::vector<Curve> curves = picture.curves;
  if (picture.unit_circle) curves.push_back({.points = unit_circle()});
  const std::vector<LabelPlace> places = label_places(
      picture.labels, extent(picture, 0, picture.x_range), extent(picture, 1, picture.y_range), curves,
      std::max(10.0, 33.0 - lines_below(picture, true) - title_lines_of(picture)), picture.colour_label.empty() ? 92.0 : 70.0);
  const double size = is_crowd(picture.labels) ? 0.7 : 1.4;
  for (std::size_t i = 0; i < picture.labels.size(); ++i) {
    const Label& label = picture.labels[i];
    const LabelPlace& place = places[i];
    const std::string at = exact(label.x) + ", " + exact(label.y), colour = quoted(label.colour);
    const std::string text = place.free ? label.text : "";
    if (label.mark == no_mark && text.empty()) continue;
    const std::string mark = label.mark == no_mark ? "" : fmt::format(" point pt {} ps {} lc rgb {}", label.mark, size, colour);
    s += fmt::format("set label {} at {} {}{} offset {},{} front tc rgb {}{}\n", quoted(text), at,
                     place.leftwards ? "right" : "left", mark, place.right, place.up, colour,
                     label.placed || text.empty() ? "" : " boxed");
    if (place.far && !text.empty())
      s += fmt::format("set arrow from {} rto character {}, character {} nohead front lc rgb {} lw 0.8\n", at, place.right,
                       place.up, colour);
  }
  return s;
}

/// Barriers: a line each, and a shade over the region beyond. Their words stand in the legend, where they cover nothing.
std::string barriers(const Picture& picture) {
  std::string s;
  int object = 1;
  for (const Barrier& barrier : picture.barriers) {
    const std::string at = exact(barrier.position);
    const std::string from = barrier.vertical ? at + ", graph 0" : "graph 0, first " + at;
    const std::string to = barrier.vertical ? at + ", graph 1" : "graph 1, first " + at;
    s += fmt::format("set arrow from {} to {} nohead front lc rgb '#b22222' lw 1.8\n", from, to);
    if (barrier.shaded)
      s += fmt::format("set object {} rectangle from {} to {} behind fc rgb '#b22222' fs transparent solid 0.07 noborder\n",
                       object++, barrier.above ? from : "graph 0, graph 0", barrier.above ? "graph 1, graph 1" : to);
  }
  return s;
}

std::string palette(const Picture& picture) {
  if (picture.palette.empty()) return "0 '#2c2a7a', 0.5 '#1fa187', 1 '#f2a104'";
  std::string s;
  for (const ColourStop& stop : picture.palette)
    s += fmt::format("{}{} {}", s.empty() ? "" : ", ", exact(stop.value), quoted(stop.colour));
  return s;
}

/// The legend's last entries: barriers, and the number of curves without an entry.
std::vector<std::string> last_entries(const Picture& picture) {
  std::vector<std::string> list;
  for (const Barrier& barrier : picture.barriers)
    if (!barrier.text.empty()) list.push_back(fmt::format("NaN {} title {}", barrier_style, quoted(barrier.text)));
  if (const Legend legend = legend_of(picture); legend.left_out > 0)
    list.push_back(fmt::format("NaN with lines lc bgnd title {}", quoted(left_out_entry(legend))));
  return list;
}

/// The gnuplot commands of one pair of axes: data, settings, and finally the plot.
struct Drawn {
  std::string data, settings, plot;
};

/// The label of a vertical axis of that height. Of a long one the middle is left out: it ends with the unit.
std::string fitting(const std::string& label, int pixels) {
  constexpr int pixels_of_a_character = 9;
  const auto most = static_cast<std::size_t>(std::max(pixels / pixels_of_a_character, 12));
  if (label.size() <= most) return label;
  const auto whole_character = [&](std::size_t at) {  // not within the bytes of one
    while (at > 0 && (static_cast<unsigned char>(label[at]) & 0xC0U) == 0x80U) --at;
    return at;
  };
  return label.substr(0, whole_character(most * 2 / 3)) + "…" + label.substr(whole_character(label.size() - most / 3 + 1));
}

/// `prefix`: of the names of its data; `columns`, `rows`: pixels of an image.
Drawn axes(const Picture& picture, const std::string& prefix, int columns, int rows) {
  Drawn out;
  std::string& s = out.settings;
  s += "set title " + quoted(title_of(picture)) + "\n";
  s += "set xlabel " + quoted(picture.x_label) + "\nset ylabel " + quoted(fitting(picture.y_label, rows)) + "\n";
  s += "set border lw 1.2\nset tics out nomirror\n";
  if (picture.grid) s += "set grid lc rgb '#dddddd' lt 1 lw 0.8\n";
  const bool image =
      !picture.logarithmic_x && !picture.logarithmic_y && std::any_of(picture.curves.begin(), picture.curves.end(), is_dense);
  const auto x_range = drawn_range(picture, 0, image, picture.x_range), y_range = drawn_range(picture, 1, image, picture.y_range);
  s += "set xrange " + range(x_range) + "\nset yrange " + range(y_range) + "\n";
  if (picture.logarithmic_x) s += "set logscale x\nset format x '%.0e'\n";
  if (picture.logarithmic_y) s += "set logscale y\nset format y '%.0e'\n";
  if (picture.equal_axes) s += "set size ratio -1\n";
  if (!picture.colour_label.empty())
    s += fmt::format("set cblabel {}\nset palette defined ({})\nset cbrange {}\n", quoted(picture.colour_label), palette(picture),
                     range(picture.colour_range));
  else
    s += "unset colorbox\nset rmargin 4\n";
  if (!picture.x_names.empty()) {
    s += "set xtics (";
    for (std::size_t i = 0; i < picture.x_names.size(); ++i)
      s += fmt::format("{}{} {}", i ? ", " : "", quoted(picture.x_names[i]), i);
    s += ") rotate by 20 right\n";
  }
  s += "set style textbox opaque fillcolor rgb '#30ffffff' noborder margins 0.3,0.2\n" + barriers(picture) + labels(picture);
  if (picture.unit_circle) {
    out.data += data_block(prefix + "circle", unit_circle());
    out.plot = fmt::format("${}circle using 1:2 with lines lc rgb '#888888' lw 1.2 title 'unit circle'", prefix);
  }
  const auto add = [&plot = out.plot](const std::string& text) { plot += (plot.empty() ? "" : ", \\\n     ") + text; };
  std::string images;  // the bytes of the images, which follow the plot command
  const auto add_image = [&](const Image& one) {
    add(image_plot(one));
    images += one.rgba;
  };
  if (picture.cells) add_image(image_of(*picture.cells));
  if (!picture.palette.empty()) add("NaN with points palette notitle");  // without this there is no colour bar
  const std::array<double, 2> x = extent(picture, 0, x_range), y = extent(picture, 1, y_range);
  if (image) {
    Raster raster(x, y, columns, rows);
    for (const Curve& curve : picture.curves)
      if (goes_with_dense(curve)) raster.paint(curve);
    add_image(raster.image());
  }
  std::size_t titles = legend_of(picture).titles;
  for (std::size_t i = 0; i < picture.curves.size(); ++i) {
    const Curve& curve = picture.curves[i];
    const bool titled = !curve.title.empty() && titles > 0;
    if (image && goes_with_dense(curve)) {
      // The legend entry for an image; a point outside the picture is not drawn.
      if (titled) add(fmt::format("NaN {} title {}", style(curve), quoted(curve.title)));
      titles -= titled ? 1 : 0;
      continue;
    }
    const bool empty =
        std::all_of(curve.points.begin(), curve.points.end(), [](const auto& p) { return std::isnan(p[0] + p[1]); });
    if (empty) continue;
    const std::string name = fmt::format("{}curve{}", prefix, i);
    out.data += data_block(name, thinned(curve, x, y));
    add(fmt::format("${} using {} {} {}", name, curve.coloured ? "1:2:3" : "1:2", style(curve),
                    titled ? "title " + quoted(curve.title) : "notitle"));
    titles -= titled ? 1 : 0;
  }
  if (out.plot.empty()) throw std::invalid_argument("there is nothing to draw: no point of it is known");
  for (const std::string& entry : last_entries(picture)) add(entry);
  out.plot = "plot " + out.plot + "\n" + images;
  return out;
}

/// One pair of axes on a sheet of its own.
std::string single(const Picture& picture, const std::string& format) {
  const Drawn drawn = axes(picture, "", 800, 500);
  return terminal(format, {}) + "\nset encoding utf8\n" + drawn.settings + legend(picture, 0.5, 0.015) +
         (picture.colour_label.empty() ? "" : "set rmargin at screen 0.8\n") +  // gnuplot drops a label without room
         fmt::format("set bmargin {}\n", lines_below(picture, true)) + drawn.data + drawn.plot;
}

/// Invisible axes over the whole sheet, for the legend of all others: gnuplot makes no legend wider than its axes.
std::string common_legend(const Picture& picture, double y) {
  std::vector<std::string> entries;
  const std::size_t most = legend_of(picture).titles;
  for (const Curve& curve : picture.curves)
    if (!curve.title.empty() && entries.size() < most)
      entries.push_back(fmt::format("NaN {} title {}", style(curve), quoted(curve.title)));
  for (std::string& entry : last_entries(picture)) entries.push_back(std::move(entry));
  if (entries.empty()) return {};
  const std::string plot = fmt::format("plot {}", fmt::join(entries, ", "));
  return "reset\nset encoding utf8\nunset border\nunset tics\nset xrange [0:1]\nset yrange [0:1]\n" + legend(picture, 0.5, y) +
         "set lmargin at screen 0.02\nset rmargin at screen 0.98\nset bmargin at screen 0\nset tmargin at screen 1\n" + plot +
         "\n";
}

/// Several pairs of axes on one sheet: below each other with a common x axis, or side by side.
std::string several(const std::vector<Picture>& pictures, bool below, const std::string& format) {
  const auto count = static_cast<int>(pictures.size());
  double heights = 0.0, above = 0.0;
  for (const Picture& picture : pictures) heights += picture.height;
  const Sheet sheet = below ? Sheet{1000, 160 + static_cast<int>(430.0 * heights)} : Sheet{750 * count, 700};
  constexpr double line = 21.0;  // pixels
  // Axes side by side have equal size, independent of their titles.
  double most_title_lines = 0.0;
  for (const Picture& picture : pictures) most_title_lines = std::max(most_title_lines, title_lines_of(picture));
  const bool shared = !below && pictures.front().common_legend;
  std::string data, commands;
  for (int i = 0; i < count; ++i) {
    const Picture& picture = pictures[static_cast<std::size_t>(i)];
    const bool names_x = !below || i + 1 == count;
    // Place of the panel including everything around its axes.
    const double width = below ? sheet.width : sheet.width / static_cast<double>(count);
    const double height = below ? sheet.height * picture.height / heights : sheet.height;
    above += height;
    const double left = below ? 0.0 : i * width, bottom = below ? sheet.height - above : 0.0;
    const double title_lines = below ? title_lines_of(picture) : most_title_lines + 0.4;
    constexpr double room_for_label_and_tics = 140.0;  // tic labels of seven characters
    const double from_x = left + room_for_label_and_tics, to_x = left + width - (picture.colour_label.empty() ? 35.0 : 190.0);
    const double from_y = bottom + line * lines_below(picture, names_x), to_y = bottom + height - line * title_lines;
    const Drawn drawn = axes(picture, fmt::format("panel{}", i), static_cast<int>(0.96 * (to_x - from_x)),
                             static_cast<int>(0.96 * (to_y - from_y)));
    data += drawn.data;
    commands += "reset\nset encoding utf8\n" + drawn.settings;
    commands += shared ? "unset key\n" : legend(picture, (from_x + to_x) / 2.0 / sheet.width, (bottom + 8.0) / sheet.height);
    commands +=
        fmt::format("set lmargin at screen {}\nset rmargin at screen {}\nset bmargin at screen {}\nset tmargin at screen {}\n",
                    from_x / sheet.width, to_x / sheet.width, from_y / sheet.height, to_y / sheet.height);
    if (!names_x) commands += "set format x ''\nunset xlabel\n";
    commands += drawn.plot;
  }
  if (shared) commands += common_legend(pictures.front(), 8.0 / sheet.height);
  return terminal(format, sheet) + "\nset encoding utf8\n" + data + "set multiplot\n" + commands + "unset multiplot\n";
}

}  // namespace

Curve legend_entry(const std::string& title, const std::string& colour) {
  Curve curve;
  curve.title = title;
  curve.stroke = Stroke::marks;
  curve.mark = 5;
  curve.colour = colour;
  curve.points.push_back({1e30, 1e30, 0.0});
  return curve;
}

std::string ending(const std::string& file) {
  std::string text = std::filesystem::path(file).extension().string();
  if (!text.empty()) text.erase(0, 1);
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::string gnuplot_script(const Picture& picture, const std::string& format) {
  if (picture.below.empty() && picture.beside.empty()) return single(picture, format);
  const bool below = picture.beside.empty();
  std::vector<Picture> all = below ? picture.below : picture.beside;
  all.insert(all.begin(), picture);
  return several(all, below, format);
}

}  // namespace graze::apps
