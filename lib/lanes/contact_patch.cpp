// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lanes/contact_patch.hpp>
#include <graze/lib/lanes/contact_sum.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace graze {

namespace {

using lanes::polynomials;

constexpr std::size_t nodes = polynomials * polynomials, quantities = 7, values = 3;

/// Tolerance of the steps through a contact: the truncation error is then below rounding.
constexpr double step_tolerance = 1e-15;
/// A contact with more steps is not tabulated.
constexpr std::size_t most_steps = 100000;
/// Terms below this, relative to the allowed error, are left out.
constexpr double negligible = 0.01;

/// A rectangle of cells of a patch.
struct Rectangle {
  std::size_t column, columns, row, rows;
};

double quantity(const lanes::ContactExit& exit, std::size_t f) {
  switch (f) {
  case 0:
    return exit.ended ? exit.duration : exit.y * exit.y;
  case 1:
    return exit.v;
  case 2:
    return exit.divergence;
  default:
    return exit.Phi[f - values];
  }
}

/// cos(pi j (2 i + 1) / (2 n)): T_j at node i.
const std::array<std::array<double, polynomials>, polynomials>& polynomials_at_nodes() {
  static const auto table = [] {
    std::array<std::array<double, polynomials>, polynomials> T{};
    for (std::size_t j = 0; j < polynomials; ++j)
      for (std::size_t i = 0; i < polynomials; ++i)
        T[j][i] = std::cos(std::numbers::pi * static_cast<double>(j * (2 * i + 1)) / static_cast<double>(2 * polynomials));
    return T;
  }();
  return table;
}

class Builder {
 public:
  Builder(const lanes::Coefficients& oscillator, LaneWidth width, const PatchPlace& place, const ContactTable* whole)
      : oscillator_(oscillator), kernels_(lane_kernels(width)), place_(place), whole_(whole),
        longest_(std::min(3.0 / oscillator[lanes::frequency], oscillator[lanes::period])) {
    out_.cells.fill(lanes::no_piece);
  }

  ContactPatch build() && {
    build({0, ContactPatch::columns, 0, ContactPatch::rows});
    return std::move(out_);
  }

 private:
  using Coefficients = std::array<std::array<double, polynomials>, polynomials>;  // of T_k(t) T_j(v)

  void build(const Rectangle& r) {
    if (try_piece(r)) return;
    // Bisect the variable with the larger last coefficients (none are known if a contact did not end), or the other one if that
    // has only one cell.
    const bool by_time = (slow_time_ >= slow_speed_ && r.columns > 1) || r.rows == 1;
    if (by_time && r.columns == 1) return;
    const std::size_t half = (by_time ? r.columns : r.rows) / 2;
    Rectangle one = r, two = r;
    (by_time ? one.columns : one.rows) = (by_time ? two.columns : two.rows) = half;
    (by_time ? two.column : two.row) += half;
    build(one);
    build(two);
  }

  /// Bound of the terms after the last coefficients in a variable, from the fall between the two last pairs of them.
  static double remainder(double before, double last) {
    const double fall = last / std::max(before, last + 1e-300);
    return last * std::min(fall / (1.0 - std::min(fall, 0.9)), 10.0);
  }

  /// Carries contacts from points (x, y) in [-1, 1]^2. False: one of them cannot be tabulated.
  template <class Points> bool carry(const lanes::ContactPiece& piece, const Points& points) {
    const double w = oscillator_[lanes::frequency];
    entries_.clear();
    for (const auto& [x, y] : points) {
      const double u = piece.time + x / piece.per_time, v = piece.speed + y / piece.per_speed;
      if (!whole_) {
        entries_.push_back({std::cos(w * u), std::sin(w * u), v, longest_});
        continue;
      }
      const double before = time_before_end(u, v);
      if (!(before > 0.0)) return false;
      entries_.push_back({std::cos(w * before), -std::sin(w * before), v, before});
    }
    exits_.assign(entries_.size(), {});
    kernels_.contacts({&oscillator_, step_tolerance, most_steps, entries_.data(), entries_.size(), exits_.data()});
    out_.contacts += entries_.size();
    return std::all_of(exits_.begin(), exits_.end(), [&](const lanes::ContactExit& exit) {
      return whole_ ? !exit.ended && exit.y >= 0.0 : exit.ended && exit.v < 0.0;
    });
  }

  /// Time from entry to the end of the period, if this is the part sin^2(angle/2) of the contact; 0: not covered. The
  /// fixed-point iteration contracts, because the duration varies slowly with the time of entry.
  double time_before_end(double angle, double v) const {
    const double T = oscillator_[lanes::period], part_of_it = std::pow(std::sin(0.5 * angle), 2);
    double before = 0.0;
    for (int i = 0; i < 60; ++i) {
      const auto contact = whole_->at(before > 0.0 ? T - before : 0.0, v);
      if (!contact) return 0.0;
      const double next = part_of_it * contact->duration;
      if (std::abs(next - before) <= 1e-16 * T) return next;
      before = next;
    }
    return before;
  }

  /// Makes one piece of a rectangle. False: the rectangle must be bisected.
  bool try_piece(const Rectangle& r) {
    const double octave = std::ldexp(1.0, static_cast<int>(place_.band)), row = octave / ContactPatch::rows;
    const double column = (whole_ ? std::numbers::pi : oscillator_[lanes::period]) / lanes::time_cells;
    lanes::ContactPiece piece;
    piece.time = column * (static_cast<double>(place_.column + r.column) + 0.5 * static_cast<double>(r.columns));
    piece.per_time = 2.0 / (column * static_cast<double>(r.columns));
    piece.speed = octave + row * (static_cast<double>(r.row) + 0.5 * static_cast<double>(r.rows));
    piece.per_speed = 2.0 / (row * static_cast<double>(r.rows));
    slow_time_ = slow_speed_ = 0.0;
    if (!lines_fit(piece) || !interpolate(piece)) return false;
    const std::size_t before = out_.terms.size();
    piece.values = keep(0, values);
    piece.tangent = keep(values, quantities);
    if (!checked(piece)) {
      out_.terms.resize(before);
      return false;
    }
    const auto number = static_cast<std::uint16_t>(out_.pieces.size());
    out_.pieces.push_back(piece);
    for (std::size_t i = 0; i < r.columns; ++i)
      for (std::size_t j = 0; j < r.rows; ++j) out_.cells[(r.column + i) * ContactPatch::rows + r.row + j] = number;
    return true;
  }

  /// Checks the two lines through the centre, which reveal most rectangles that are too large.
  bool lines_fit(const lanes::ContactPiece& piece) {
    const auto& T = polynomials_at_nodes();
    std::array<std::array<double, 2>, 2 * polynomials> points;
    for (std::size_t i = 0; i < polynomials; ++i) {
      points[i] = {T[1][i], 0.0};
      points[polynomials + i] = {0.0, T[1][i]};
    }
    if (!carry(piece, points)) return false;
    set_scales();
    for (std::size_t f = 0; f < quantities; ++f)
      for (const bool by_time : {true, false}) {
        const std::size_t begin = by_time ? 0 : polynomials;
        std::array<double, 4> last{};
        for (std::size_t j = 0; j < last.size(); ++j) {
          double sum = 0.0;
          for (std::size_t n = 0; n < polynomials; ++n) sum += quantity(exits_[begin + n], f) * T[polynomials - 4 + j][n];
          last[j] = std::abs(sum) * 2.0 / polynomials;
        }
        double& slow = by_time ? slow_time_ : slow_speed_;
        slow = std::max(slow, remainder(last[0] + last[1], last[2] + last[3]) / allowed(f));
      }
    return std::max(slow_time_, slow_speed_) <= 1.0;
  }

  double allowed(std::size_t f) const {
    return (f < values ? ContactTable::value_error : ContactTable::tangent_error) * scale_[f];
  }

  /// Sets the scales from the contacts carried last.
  void set_scales() {
    double norm = 0.0;
    for (std::size_t f = 0; f < quantities; ++f) {
      double largest = 0.0;
      for (const lanes::ContactExit& exit : exits_) largest = std::max(largest, std::abs(quantity(exit, f)));
      scale_[f] = 1.0 + largest;
      if (f >= values) norm = std::max(norm, largest);
    }
    for (std::size_t f = values; f < quantities; ++f) scale_[f] = 1.0 + norm;
  }

  /// Computes the coefficients c_. False: they do not fall off.
  bool interpolate(const lanes::ContactPiece& piece) {
    const auto& T = polynomials_at_nodes();
    std::array<std::array<double, 2>, nodes> points;
    for (std::size_t i = 0; i < polynomials; ++i)
      for (std::size_t j = 0; j < polynomials; ++j) points[i * polynomials + j] = {T[1][i], T[1][j]};
    if (!carry(piece, points)) return false;
    set_scales();
    for (std::size_t f = 0; f < quantities; ++f) {
      Coefficients half;
      for (std::size_t i = 0; i < polynomials; ++i)
        for (std::size_t j = 0; j < polynomials; ++j) {
          double sum = 0.0;
          for (std::size_t n = 0; n < polynomials; ++n) sum += quantity(exits_[i * polynomials + n], f) * T[j][n];
          half[i][j] = sum * (j == 0 ? 1.0 : 2.0) / polynomials;
        }
      for (std::size_t k = 0; k < polynomials; ++k)
        for (std::size_t j = 0; j < polynomials; ++j) {
          double sum = 0.0;
          for (std::size_t n = 0; n < polynomials; ++n) sum += half[n][j] * T[k][n];
          c_[f][k][j] = sum * (k == 0 ? 1.0 : 2.0) / polynomials;
        }
      std::array<double, 2> by_time{}, by_speed{};
      for (std::size_t i = 0; i < polynomials; ++i)
        for (std::size_t j = 0; j < 4; ++j) {
          by_time[j / 2] += std::abs(c_[f][polynomials - 4 + j][i]);
          by_speed[j / 2] += std::abs(c_[f][i][polynomials - 4 + j]);
        }
      slow_time_ = std::max(slow_time_, remainder(by_time[0], by_time[1]) / allowed(f));
      slow_speed_ = std::max(slow_speed_, remainder(by_speed[0], by_speed[1]) / allowed(f));
    }
    return std::max(slow_time_, slow_speed_) <= 1.0;
  }

  lanes::PieceTerms keep(std::size_t first, std::size_t last) {
    lanes::PieceTerms kept;
    kept.first = static_cast<std::uint32_t>(out_.terms.size());
    const auto matters = [&](std::size_t k, std::size_t j) {
      for (std::size_t f = first; f < last; ++f)
        if (std::max(std::abs(c_[f][2 * k][j]), std::abs(c_[f][2 * k + 1][j])) > negligible * allowed(f)) return true;
      return false;
    };
    std::size_t rows = polynomials / 2;
    for (std::size_t k = 0; k < rows; ++k) {
      std::size_t count = polynomials;
      while (count > 0 && !matters(k, count - 1)) --count;
      if (count == 0) break;
      kept.count[k] = static_cast<std::uint8_t>(count);
      for (std::size_t j = 0; j < count; ++j) {
        lanes::TermPair pair{};
        for (std::size_t f = first; f < last; ++f) {
          pair.at[f - first] = c_[f][2 * k][j];
          pair.at[4 + f - first] = c_[f][2 * k + 1][j];
        }
        out_.terms.push_back(pair);
      }
    }
    return kept;
  }

  /// Compares a piece with newly carried contacts, at points between the nodes and on the border.
  bool checked(const lanes::ContactPiece& piece) {
    constexpr std::size_t few = 5;
    std::array<std::array<double, 2>, few * few> points;
    for (std::size_t i = 0; i < few; ++i)
      for (std::size_t j = 0; j < few; ++j) {
        // Half-way between nodes, where T_16 is 1 or -1. For parts of contacts without the very ends, where there is nothing to
        // carry, and without the highest speed, which may be that of the table.
        constexpr std::array<int, few> where = {0, 3, 8, 11, 16}, inside = {1, 4, 8, 11, 15};
        const auto between = [&](int k) { return std::cos(std::numbers::pi * k / static_cast<double>(polynomials)); };
        const auto& at = whole_ ? inside : where;
        points[i * few + j] = {between(at[i]), between(at[j])};
      }
    if (!carry(piece, points)) return false;
    double worst_value = 0.0, worst_tangent = 0.0;
    for (std::size_t n = 0; n < points.size(); ++n) {
      lanes::ContactExit exit = evaluate(piece, out_.terms.data(), points[n][0], points[n][1]);
      exit.ended = exits_[n].ended;
      for (std::size_t f = 0; f < quantities; ++f) {
        const double exact = quantity(exits_[n], f), error = std::abs(quantity(exit, f) - exact);
        double& worst = f < values ? worst_value : worst_tangent;
        worst = std::max(worst, error / (f < values ? 1.0 + std::abs(exact) : scale_[f]));
      }
    }
    if (!(worst_value <= ContactTable::value_error && worst_tangent <= ContactTable::tangent_error)) return false;
    out_.value_error = std::max(out_.value_error, worst_value);
    out_.tangent_error = std::max(out_.tangent_error, worst_tangent);
    return true;
  }

  const lanes::Coefficients& oscillator_;
  LaneKernels kernels_;
  PatchPlace place_;
  const ContactTable* whole_;  // null: whole contacts are tabulated
  double longest_;             // longest duration of a tabulated contact
  std::array<Coefficients, quantities> c_ = {};
  std::array<double, quantities> scale_ = {};  // 1 + |value|; of the tangent 1 + |Phi|
  std::vector<lanes::ContactEntry> entries_ = {};
  std::vector<lanes::ContactExit> exits_ = {};
  double slow_time_ = 0.0, slow_speed_ = 0.0;  // remainder of the last rectangle
  ContactPatch out_;
};

}  // namespace

lanes::ContactExit evaluate(const lanes::ContactPiece& piece, const lanes::TermPair* terms, double x, double y) {
  double T_time[polynomials], T_speed[polynomials], four[4];
  lanes::chebyshev(x, T_time);
  lanes::chebyshev(y, T_speed);
  lanes::ContactExit exit;
  lanes::add_up<double>(terms, piece.values, T_time, T_speed, 1, four);
  exit.duration = four[0];
  exit.y = std::sqrt(std::max(0.0, four[0]));
  exit.v = four[1];
  exit.divergence = four[2];
  lanes::add_up<double>(terms, piece.tangent, T_time, T_speed, 1, four);
  std::copy(four, four + 4, exit.Phi.begin());
  exit.ended = false;
  return exit;
}

ContactPatch contact_patch(const lanes::Coefficients& oscillator, LaneWidth width, const PatchPlace& place,
                           const ContactTable* whole) {
  return Builder(oscillator, width, place, whole).build();
}

}  // namespace graze
