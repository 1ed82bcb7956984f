// SPDX-License-Identifier: GPL-3.0-or-later
// WordPlaces: finds room for words in a crowded picture, away from curves, marks and words already placed.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace graze::apps {

/// A place in the picture, in characters of its words from the lower left corner of the axes.
struct Cell {
  double column = 0.0, row = 0.0;
};

/// Words with a place. Like the words of a Label, they begin one character to the right of `anchor` and slightly above it.
struct PlacedWords {
  Cell anchor;
  std::vector<Cell> leader;  ///< a line to the mark that also underlines the words; empty if they stand beside the mark
};

class WordPlaces {
 public:
  /// `rows`: height of the axes.
  explicit WordPlaces(double rows);

  static constexpr double columns = 92.0;

  void add_line(Cell from, Cell to);
  void add_mark(Cell at);
  /// Adds one of many pale dots: words may cover some, but avoid them if possible.
  void add_dot(Cell at);

  /// Words for one of several marks, at most `farthest` characters away from it; the first mark is preferred.
  std::optional<PlacedWords> beside_mark(const std::vector<Cell>& marks, const std::string& words, double farthest);

  /// Words for a curve, close to one of its points; the first points are preferred.
  std::optional<PlacedWords> along_curve(const std::vector<Cell>& points, const std::string& words);

 private:
  struct Box {
    double left, right, bottom, top;
  };
  static Box box_of(Cell anchor, const std::string& words);
  static bool overlap(const Box& a, const Box& b);
  bool fits(const Box& box) const;
  double covered(const Box& box) const;
  double crossed(Cell from, Cell to) const;
  void raise(Cell at, double weight);
  void keep(const PlacedWords& placed, const std::string& words);

  double rows_;
  std::size_t width_, height_;
  std::vector<double> grid_;  ///< weight of the drawing in each small square
  std::vector<Box> boxes_;
  std::vector<std::pair<Cell, Cell>> leaders_;
};

}  // namespace graze::apps
