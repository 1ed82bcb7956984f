// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/visited_cells.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze {

namespace {

std::size_t distinct(std::vector<std::uint64_t> list) {
  std::sort(list.begin(), list.end());
  return static_cast<std::size_t>(std::unique(list.begin(), list.end()) - list.begin());
}

}  // namespace

VisitedCells::VisitedCells(const std::vector<Vector>& states) {
  if (states.empty()) return;
  const auto half = states.begin() + static_cast<std::ptrdiff_t>(states.size() / 2);
  const std::vector<Vector> first(states.begin(), half), second(half, states.end());
  constexpr int finest = 128, coarsest = 4;
  constexpr double known_again = 0.999;
  int across = finest;
  for (; across > coarsest; across /= 2) {
    choose(states, across);
    VisitedCells part = *this;
    part.cells_.clear();
    for (const Vector& x : first) part.cells_.push_back(cell(x));
    std::sort(part.cells_.begin(), part.cells_.end());
    if (part.share(second) >= known_again) break;
  }
  choose(states, across);
  std::vector<std::uint64_t> path;
  for (const Vector& x : states) path.push_back(cell(x));
  least_in_window_ = distinct(path);
  for (std::size_t begin = 0; begin + window <= path.size(); begin += window)
    least_in_window_ = std::min(least_in_window_, distinct({path.begin() + static_cast<std::ptrdiff_t>(begin),
                                                            path.begin() + static_cast<std::ptrdiff_t>(begin) + window}));
  std::sort(path.begin(), path.end());
  path.erase(std::unique(path.begin(), path.end()), path.end());
  cells_ = std::move(path);
}

void VisitedCells::choose(const std::vector<Vector>& states, int across) {
  low_ = states.front();
  Vector high = low_;
  for (const Vector& x : states) {
    low_ = low_.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  // A coordinate that does not change has one cell, a little larger than rounding.
  size_ = (high - low_).cwiseMax(1e-9 * (1.0 + high.lpNorm<Eigen::Infinity>())) / across;
}

std::uint64_t VisitedCells::cell(const Vector& x) const {
  std::uint64_t number = 0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double place = std::clamp(std::floor((x[i] - low_[i]) / size_[i]), -2.0, 1000.0);
    number = number * 1009 + static_cast<std::uint64_t>(place + 2.0);
  }
  return number;
}

bool VisitedCells::holds(const Vector& x) const { return std::binary_search(cells_.begin(), cells_.end(), cell(x)); }

double VisitedCells::share(const std::vector<Vector>& states) const {
  if (states.empty()) return 0.0;
  const auto inside = std::count_if(states.begin(), states.end(), [&](const Vector& x) { return holds(x); });
  return static_cast<double>(inside) / static_cast<double>(states.size());
}

bool Strand::add(const VisitedCells& cells, const Vector& x) {
  const std::uint64_t number = cells.cell(x);
  if (!cells.holds(x)) {
    met_.clear();
    return false;
  }
  met_.push_back(number);
  if (met_.size() < VisitedCells::window) return false;
  const bool enough = 2 * distinct(met_) >= cells.least_in_window();
  met_.clear();
  return enough;
}

}  // namespace graze
