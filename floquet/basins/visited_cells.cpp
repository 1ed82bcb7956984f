// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/basins/visited_cells.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace graze {

namespace {

template <class Iterator> std::size_t distinct(Iterator begin, Iterator end) {
  CellSet set;
  for (; begin != end; ++begin) set.insert(*begin);
  return set.size();
}

}  // namespace

std::size_t CellSet::place(std::uint64_t number) const {
  std::size_t i = (number * 0x9e3779b97f4a7c15U) >> (64 - bits_);  // the golden ratio scatters neighbours
  while (slots_[i] != 0 && slots_[i] != number) i = (i + 1) & (slots_.size() - 1);
  return i;
}

bool CellSet::insert(std::uint64_t number) {
  std::uint64_t& slot = slots_[place(number)];
  if (slot == number) return false;
  slot = number;
  if (4 * ++size_ < 3 * slots_.size()) return true;
  const std::vector<std::uint64_t> before = std::exchange(slots_, std::vector<std::uint64_t>(2 * slots_.size()));
  ++bits_;
  for (const std::uint64_t one : before)
    if (one != 0) slots_[place(one)] = one;
  return true;
}

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
    part.cells_ = {};
    for (const Vector& x : first) part.cells_.insert(cell(x));
    if (part.share(second) >= known_again) break;
  }
  choose(states, across);
  std::vector<std::uint64_t> path;
  cells_ = {};
  for (const Vector& x : states) {
    path.push_back(cell(x));
    cells_.insert(path.back());
  }
  least_in_window_ = cells_.size();
  for (auto begin = path.begin(); path.end() - begin >= window; begin += window)
    least_in_window_ = std::min(least_in_window_, distinct(begin, begin + window));
}

void VisitedCells::choose(const std::vector<Vector>& states, int across) {
  low_ = states.front();
  Vector high = low_;
  for (const Vector& x : states) {
    low_ = low_.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  // A coordinate that does not change gets one cell, slightly larger than rounding.
  per_size_ = across * (high - low_).cwiseMax(1e-9 * (1.0 + high.lpNorm<Eigen::Infinity>())).cwiseInverse();
}

std::uint64_t VisitedCells::cell(const Vector& x) const {
  std::uint64_t number = 1;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double place = std::clamp((x[i] - low_[i]) * per_size_[i] + 2.0, 0.0, 1002.0);
    number = number * 1009 + static_cast<std::uint64_t>(static_cast<std::int64_t>(place));  // via signed: fast conversion
  }
  return number;
}

double VisitedCells::share(const std::vector<Vector>& states) const {
  if (states.empty()) return 0.0;
  const auto inside = std::count_if(states.begin(), states.end(), [&](const Vector& x) { return holds(x); });
  return static_cast<double>(inside) / static_cast<double>(states.size());
}

bool CellResidence::add(const VisitedCells& cells, const Vector& x) {
  const std::uint64_t number = cells.cell(x);
  if (!cells.holds(number)) {
    met_.clear();
    return false;
  }
  if (met_.empty()) met_.reserve(VisitedCells::window);
  met_.push_back(number);
  if (met_.size() < VisitedCells::window) return false;
  const bool enough = 2 * distinct(met_.begin(), met_.end()) >= cells.least_in_window();
  met_.clear();
  return enough;
}

}  // namespace graze
