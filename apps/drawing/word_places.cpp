// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/drawing/word_places.hpp>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

constexpr double fine = 4.0;  // squares of the grid per character
// Geometry of words that gnuplot draws beside the anchor of a label.
constexpr double gap = 1.7, lift = 0.63, height = 1.2, letter = 1.2;
constexpr double mark_weight = 4.0;  // covering a mark is worse than covering a line
constexpr double dot_weight = 0.01;  // words in a region full of dots cost as much as words across one line
constexpr double most_covered = 1.5;

double length_of(const std::string& words) { return letter * static_cast<double>(words.size()); }

/// Visits points of the line between two places, spaced by less than a square of the grid.
template <class Visit> void walk(Cell from, Cell to, const Visit& visit) {
  const double length = std::hypot(to.column - from.column, to.row - from.row);
  const int steps = std::max(1, static_cast<int>(std::ceil(2.0 * fine * length)));
  for (int i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    visit(Cell{from.column + t * (to.column - from.column), from.row + t * (to.row - from.row)});
  }
}

}  // namespace

WordPlaces::WordPlaces(double rows)
    : rows_(rows), width_(static_cast<std::size_t>(columns * fine)), height_(static_cast<std::size_t>(std::ceil(rows * fine))),
      grid_(width_ * height_, 0.0) {}

void WordPlaces::raise(Cell at, double weight) {
  if (!(at.column >= 0.0 && at.row >= 0.0)) return;
  const auto i = static_cast<std::size_t>(at.column * fine), j = static_cast<std::size_t>(at.row * fine);
  if (i < width_ && j < height_) grid_[j * width_ + i] = std::max(grid_[j * width_ + i], weight);
}

void WordPlaces::add_line(Cell from, Cell to) {
  walk(from, to, [&](Cell at) { raise(at, 1.0); });
}

void WordPlaces::add_mark(Cell at) {
  for (const double right : {-0.4, -0.15, 0.1, 0.35})
    for (const double up : {-0.25, 0.0, 0.25}) raise({at.column + right, at.row + up}, mark_weight);
}

void WordPlaces::add_dot(Cell at) { raise(at, dot_weight); }

WordPlaces::Box WordPlaces::box_of(Cell anchor, const std::string& words) {
  // Slightly wider than the words on the left, as in label_places(), which would otherwise move words that it considers
  // covered.
  const double left = anchor.column + gap, middle = anchor.row + lift;
  return {left - 0.7, left + length_of(words) + 0.4, middle - 0.5 * height, middle + 0.5 * height};
}

bool WordPlaces::overlap(const Box& a, const Box& b) {
  return a.left < b.right && b.left < a.right && a.bottom < b.top && b.bottom < a.top;
}

bool WordPlaces::fits(const Box& box) const {
  if (box.left < 1.0 || box.right > columns - 1.0 || box.bottom < 0.2 || box.top > rows_ - 0.2) return false;
  return std::none_of(boxes_.begin(), boxes_.end(), [&](const Box& other) { return overlap(box, other); });
}

double WordPlaces::covered(const Box& box) const {
  double sum = 0.0;
  const auto first = static_cast<std::size_t>(box.left * fine), last = static_cast<std::size_t>(box.right * fine);
  const auto low = static_cast<std::size_t>(box.bottom * fine), high = static_cast<std::size_t>(box.top * fine);
  for (std::size_t j = low; j <= high && j < height_; ++j)
    for (std::size_t i = first; i <= last && i < width_; ++i) sum += grid_[j * width_ + i];
  return sum;
}

/// Cost of a leader: the words and leaders (both with a large weight) and the lines that it crosses.
double WordPlaces::crossed(Cell from, Cell to) const {
  double sum = 0.0;
  walk(from, to, [&](Cell at) {
    const auto inside = [&](const Box& box) { return overlap(box, {at.column, at.column, at.row, at.row}); };
    if (std::any_of(boxes_.begin(), boxes_.end(), inside)) sum += 100.0;
    if (!(at.column >= 0.0 && at.row >= 0.0)) return;
    const auto i = static_cast<std::size_t>(at.column * fine), j = static_cast<std::size_t>(at.row * fine);
    if (i < width_ && j < height_) sum += 0.1 * grid_[j * width_ + i];
  });
  const auto side = [](Cell a, Cell b, Cell c) {
    return (b.column - a.column) * (c.row - a.row) - (b.row - a.row) * (c.column - a.column);
  };
  for (const auto& [a, b] : leaders_)
    if (side(a, b, from) * side(a, b, to) < 0.0 && side(from, to, a) * side(from, to, b) < 0.0) sum += 12.0;
  return sum;
}

void WordPlaces::keep(const PlacedWords& placed, const std::string& words) {
  boxes_.push_back(box_of(placed.anchor, words));
  for (std::size_t i = 0; i + 1 < placed.leader.size(); ++i) {
    add_line(placed.leader[i], placed.leader[i + 1]);
    leaders_.emplace_back(placed.leader[i], placed.leader[i + 1]);
  }
}

std::optional<PlacedWords> WordPlaces::beside_mark(const std::vector<Cell>& marks, const std::string& words, double farthest) {
  constexpr int angles = 24;
  const double length = length_of(words);
  std::optional<PlacedWords> best;
  double least = 50.0, rank = 0.0;
  const auto consider = [&](Cell mark, double distance, double phi, bool leftwards) {
    // Rows are about twice as high as columns are wide.
    const Cell end = {mark.column + distance * std::cos(phi), mark.row + 0.5 * distance * std::sin(phi)};
    PlacedWords placed{leftwards ? Cell{end.column - length - gap, end.row} : end, {}};
    const Box box = box_of(placed.anchor, words);
    if (!fits(box)) return;
    if (distance > 0.0 || leftwards)
      placed.leader = {mark, end, leftwards ? placed.anchor : Cell{end.column + gap + length, end.row}};
    const double over = covered(box);
    if (over > most_covered) return;
    double cost = rank + distance + 3.0 * over + (leftwards ? 0.3 : 0.0);
    for (std::size_t i = 0; i + 1 < placed.leader.size() && cost < least; ++i)
      cost += crossed(placed.leader[i], placed.leader[i + 1]);
    if (cost >= least) return;
    least = cost;
    best = placed;
  };
  for (const Cell& mark : marks) {
    for (const bool leftwards : {false, true}) {
      consider(mark, 0.0, 0.0, leftwards);
      for (int steps = 3; 0.5 * steps <= farthest; ++steps)
        for (int angle = 0; angle < angles; ++angle) consider(mark, 0.5 * steps, 2.0 * M_PI * angle / angles, leftwards);
    }
    rank = 2.0;
  }
  if (best) keep(*best, words);
  return best;
}

std::optional<PlacedWords> WordPlaces::along_curve(const std::vector<Cell>& points, const std::string& words) {
  const double length = length_of(words);
  std::optional<PlacedWords> best;
  double least = HUGE_VAL, rank = 0.0;
  for (const Cell& point : points) {
    rank += 8.0 / static_cast<double>(points.size());
    for (const double up : {0.0, 0.3, -1.5, -1.8})
      for (const double right : {0.0, -0.5 * length - gap, -length - 2.0 * gap}) {
        const PlacedWords placed{{point.column + right, point.row + up}, {}};
        const Box box = box_of(placed.anchor, words);
        // A label's anchor is drawn as a dot, which is invisible on the curve.
        const double dot = up == 0.0 && right == 0.0 ? 0.0 : 4.0;
        const double cost = rank + dot + std::abs(up) + 4.0 * covered(box);
        if (cost >= least || !fits(box) || covered(box) > most_covered) continue;
        least = cost;
        best = placed;
      }
  }
  if (best) keep(*best, words);
  return best;
}

}  // namespace graze::apps
