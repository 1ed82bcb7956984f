// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/contact_table.hpp>
#include <graze/lib/lanes/contact_sum.hpp>
#include <graze/lib/lanes/oscillator.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace graze {

namespace {

using lanes::polynomials, lanes::speed_cells, lanes::time_cells;

constexpr std::size_t nodes = polynomials * polynomials, quantities = 7, values = 3;

/// Of the steps through a contact: what they leave out is below rounding then.
constexpr double step_tolerance = 1e-15;
/// Terms below this, relative to what is allowed in all, are left out.
constexpr double negligible = 0.01;
/// First rectangles: quarters of a period, an octave of speeds.
constexpr std::size_t first_width = time_cells / 4;

/// A rectangle of cells.
struct Rectangle {
  std::size_t column, columns, row, rows;
  bool operator==(const Rectangle&) const = default;
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

}  // namespace

struct ContactTable::Builder {
  using Coefficients = std::array<std::array<double, polynomials>, polynomials>;  // of T_k(t) T_j(v)

  ContactTable& table;
  lanes::Coefficients oscillator;
  LaneKernels kernels;
  double longest = std::min(3.0 / oscillator[lanes::frequency], oscillator[lanes::period]);
  std::array<Coefficients, quantities> c = {};
  std::array<double, quantities> scale = {};  // 1 + |value|; of the tangent 1 + |Phi|
  std::vector<lanes::ContactEntry> entries = {};
  std::vector<lanes::ContactExit> exits = {};

  enum class Part { whole, begun };
  Part part = Part::whole;

  void build(std::size_t band, Part which) {
    part = which;
    for (std::size_t column = 0; column < time_cells; column += first_width) build(band, {column, first_width, 0, speed_cells});
  }

  void build(std::size_t band, const Rectangle& r) {
    if (try_piece(band, r)) return;
    // The variable with the larger last coefficients, or none of a contact that did not end: the other one if it cannot be.
    const bool by_time = (slow_time >= slow_speed && r.columns > 1) || r.rows == 1;
    if (by_time && r.columns == 1) return;
    const std::size_t half = (by_time ? r.columns : r.rows) / 2;
    Rectangle one = r, two = r;
    (by_time ? one.columns : one.rows) = (by_time ? two.columns : two.rows) = half;
    (by_time ? two.column : two.row) += half;
    build(band, one);
    build(band, two);
  }

  /// Bound of what comes after the last coefficients in a variable, relative to what is allowed: from the fall between the two
  /// last pairs of them.
  double slow_time = 0.0, slow_speed = 0.0;
  static double remainder(double before, double last) {
    const double fall = last / std::max(before, last + 1e-300);
    return last * std::min(fall / (1.0 - std::min(fall, 0.9)), 10.0);
  }

  /// Carries contacts from points (x, y) of [-1, 1]^2. False: one did not end.
  template <class Points> bool carry(const lanes::ContactPiece& piece, const Points& points) {
    const double w = oscillator[lanes::frequency];
    entries.clear();
    for (const auto& [x, y] : points) {
      const double u = piece.time + x / piece.per_time, v = piece.speed + y / piece.per_speed;
      if (part == Part::whole) {
        entries.push_back({std::cos(w * u), std::sin(w * u), v, longest});
        continue;
      }
      const double before = time_before_end(u, v);
      if (!(before > 0.0)) return false;
      entries.push_back({std::cos(w * before), -std::sin(w * before), v, before});
    }
    exits.assign(entries.size(), {});
    kernels.contacts({&oscillator, step_tolerance, entries.data(), entries.size(), exits.data()});
    table.report_.contacts += entries.size();
    return std::all_of(exits.begin(), exits.end(), [&](const lanes::ContactExit& exit) {
      return part == Part::whole ? exit.ended && exit.v < 0.0 : !exit.ended && exit.y >= 0.0;
    });
  }

  /// From entry to the end of the period, where this is the part sin^2(angle/2) of the contact; 0: not covered. The duration
  /// varies slowly with the time of entry: a contraction.
  double time_before_end(double angle, double v) const {
    const double T = table.period_, part_of_it = std::pow(std::sin(0.5 * angle), 2);
    double before = 0.0;
    for (int i = 0; i < 60; ++i) {
      const auto contact = table.at(before > 0.0 ? T - before : 0.0, v);
      if (!contact) return 0.0;
      const double next = part_of_it * contact->duration;
      if (std::abs(next - before) <= 1e-16 * T) return next;
      before = next;
    }
    return before;
  }

  /// False: to be bisected.
  bool try_piece(std::size_t band, const Rectangle& r) {
    const double octave = std::ldexp(1.0, static_cast<int>(table.lowest_band_ + static_cast<std::int64_t>(band)));
    const double column = (part == Part::whole ? table.period_ : std::numbers::pi) / time_cells, row = octave / speed_cells;
    lanes::ContactPiece piece;
    piece.time = column * (static_cast<double>(r.column) + 0.5 * static_cast<double>(r.columns));
    piece.per_time = 2.0 / (column * static_cast<double>(r.columns));
    piece.speed = octave + row * (static_cast<double>(r.row) + 0.5 * static_cast<double>(r.rows));
    piece.per_speed = 2.0 / (row * static_cast<double>(r.rows));
    slow_time = slow_speed = 0.0;
    if (!lines_fit(piece) || !interpolate(piece)) return false;
    const std::size_t before = table.terms_.size();
    piece.values = keep(0, values);
    piece.tangent = keep(values, quantities);
    if (!checked(piece) || table.pieces_.size() >= lanes::no_piece) {
      table.terms_.resize(before);
      return false;
    }
    const auto number = static_cast<std::uint16_t>(table.pieces_.size());
    table.pieces_.push_back(piece);
    for (std::size_t i = 0; i < r.columns; ++i)
      for (std::size_t j = 0; j < r.rows; ++j)
        (part == Part::whole ? table.whole_ : table.begun_)[(band * time_cells + r.column + i) * speed_cells + r.row + j] =
            number;
    return true;
  }

  /// Looks at the two lines through the centre: most rectangles that are too large are known by these.
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
          for (std::size_t n = 0; n < polynomials; ++n) sum += quantity(exits[begin + n], f) * T[polynomials - 4 + j][n];
          last[j] = std::abs(sum) * 2.0 / polynomials;
        }
        double& slow = by_time ? slow_time : slow_speed;
        slow = std::max(slow, remainder(last[0] + last[1], last[2] + last[3]) / allowed(f));
      }
    return std::max(slow_time, slow_speed) <= 1.0;
  }

  double allowed(std::size_t f) const { return (f < values ? value_error : tangent_error) * scale[f]; }

  /// From the contacts carried last.
  void set_scales() {
    double norm = 0.0;
    for (std::size_t f = 0; f < quantities; ++f) {
      double largest = 0.0;
      for (const lanes::ContactExit& exit : exits) largest = std::max(largest, std::abs(quantity(exit, f)));
      scale[f] = 1.0 + largest;
      if (f >= values) norm = std::max(norm, largest);
    }
    for (std::size_t f = values; f < quantities; ++f) scale[f] = 1.0 + norm;
  }

  /// The coefficients c. False: they do not fall off.
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
          for (std::size_t n = 0; n < polynomials; ++n) sum += quantity(exits[i * polynomials + n], f) * T[j][n];
          half[i][j] = sum * (j == 0 ? 1.0 : 2.0) / polynomials;
        }
      for (std::size_t k = 0; k < polynomials; ++k)
        for (std::size_t j = 0; j < polynomials; ++j) {
          double sum = 0.0;
          for (std::size_t n = 0; n < polynomials; ++n) sum += half[n][j] * T[k][n];
          c[f][k][j] = sum * (k == 0 ? 1.0 : 2.0) / polynomials;
        }
      std::array<double, 2> by_time{}, by_speed{};
      for (std::size_t i = 0; i < polynomials; ++i)
        for (std::size_t j = 0; j < 4; ++j) {
          by_time[j / 2] += std::abs(c[f][polynomials - 4 + j][i]);
          by_speed[j / 2] += std::abs(c[f][i][polynomials - 4 + j]);
        }
      slow_time = std::max(slow_time, remainder(by_time[0], by_time[1]) / allowed(f));
      slow_speed = std::max(slow_speed, remainder(by_speed[0], by_speed[1]) / allowed(f));
    }
    return std::max(slow_time, slow_speed) <= 1.0;
  }

  lanes::PieceTerms keep(std::size_t first, std::size_t last) {
    lanes::PieceTerms kept;
    kept.first = static_cast<std::uint32_t>(table.terms_.size());
    const auto matters = [&](std::size_t k, std::size_t j) {
      for (std::size_t f = first; f < last; ++f)
        if (std::max(std::abs(c[f][2 * k][j]), std::abs(c[f][2 * k + 1][j])) > negligible * allowed(f)) return true;
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
          pair.at[f - first] = c[f][2 * k][j];
          pair.at[4 + f - first] = c[f][2 * k + 1][j];
        }
        table.terms_.push_back(pair);
      }
    }
    return kept;
  }

  /// Against contacts carried anew, at points between the nodes and on the border.
  bool checked(const lanes::ContactPiece& piece) {
    constexpr std::size_t few = 5;
    std::array<std::array<double, 2>, few * few> points;
    for (std::size_t i = 0; i < few; ++i)
      for (std::size_t j = 0; j < few; ++j) {
        // Half-way between nodes: T_16 is 1 or -1 there. Of a part of a contact not the very ends, where there is nothing to
        // carry, nor the highest speed, which may be that of the table.
        constexpr std::array<int, few> where = {0, 3, 8, 11, 16}, inside = {1, 4, 8, 11, 15};
        const auto between = [&](int k) { return std::cos(std::numbers::pi * k / static_cast<double>(polynomials)); };
        const auto& at = part == Part::whole ? where : inside;
        points[i * few + j] = {between(at[i]), between(at[j])};
      }
    if (!carry(piece, points)) return false;
    double worst_value = 0.0, worst_tangent = 0.0;
    for (std::size_t n = 0; n < points.size(); ++n) {
      lanes::ContactExit exit = evaluate(piece, table.terms_.data(), points[n][0], points[n][1]);
      exit.ended = exits[n].ended;
      for (std::size_t f = 0; f < quantities; ++f) {
        const double exact = quantity(exits[n], f), error = std::abs(quantity(exit, f) - exact);
        double& worst = f < values ? worst_value : worst_tangent;
        worst = std::max(worst, error / (f < values ? 1.0 + std::abs(exact) : scale[f]));
      }
    }
    if (!(worst_value <= value_error && worst_tangent <= tangent_error)) return false;
    table.report_.value_error = std::max(table.report_.value_error, worst_value);
    table.report_.tangent_error = std::max(table.report_.tangent_error, worst_tangent);
    return true;
  }

  static lanes::ContactExit evaluate(const lanes::ContactPiece& piece, const lanes::TermPair* terms, double x, double y) {
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
};

bool ContactTable::applies(const HybridSystem& system, const Vector& p) {
  const auto oscillator = lanes::lane_oscillator(system, p);
  return oscillator && oscillator->law == lanes::Law::hertz;
}

ContactTable::ContactTable(const HybridSystem& system, const Vector& p, const SpeedRange& speeds, LaneWidth width) {
  check_parameters(system.parameters, p);
  const auto oscillator = lanes::lane_oscillator(system, p);
  if (!oscillator || oscillator->law != lanes::Law::hertz)
    throw std::invalid_argument(
        fmt::format("{} at these parameters is not a linear oscillator with a Hertz stop; a table of its contacts cannot be made",
                    system.name));
  constexpr int widest = 20;
  if (!(speeds.lowest >= std::ldexp(1.0, -widest) && speeds.highest >= speeds.lowest &&
        speeds.highest <= std::ldexp(1.0, widest)))
    throw std::invalid_argument(fmt::format("speeds of entry from {} to {} were given; from 2^-{} to 2^{} are allowed",
                                            speeds.lowest, speeds.highest, widest, widest));
  oscillator_ = oscillator->coefficients;
  period_ = oscillator_[lanes::period];
  lowest_band_ = lanes::band_of<double>(speeds.lowest);
  bands_ = lanes::band_of<double>(speeds.highest) - lowest_band_ + 1;
  for (auto* cells : {&whole_, &begun_})
    cells->assign(static_cast<std::size_t>(bands_) * time_cells * speed_cells, lanes::no_piece);
  Builder builder{*this, oscillator_, lane_kernels(width)};
  for (const auto part : {Builder::Part::whole, Builder::Part::begun})
    for (std::int64_t band = 0; band < bands_; ++band) builder.build(static_cast<std::size_t>(band), part);
  terms_.shrink_to_fit();
  report_.pieces = pieces_.size();
  report_.bytes = terms_.size() * sizeof(lanes::TermPair) + pieces_.size() * sizeof(lanes::ContactPiece) + 4 * whole_.size();
  const auto covered = [](const std::vector<std::uint16_t>& cells) {
    return 1.0 - static_cast<double>(std::count(cells.begin(), cells.end(), lanes::no_piece)) / static_cast<double>(cells.size());
  };
  report_.covered = covered(whole_);
  report_.covered_begun = covered(begun_);
}

lanes::ContactPieces ContactTable::pieces() const {
  return {time_cells / period_, lowest_band_, bands_, whole_.data(), begun_.data(), pieces_.data(), terms_.data()};
}

std::optional<lanes::ContactExit> ContactTable::at(double t, double v) const {
  const lanes::ContactPiece* piece = lanes::find_piece<double>(pieces(), whole_.data(), t * (time_cells / period_), v);
  if (!piece) return std::nullopt;
  lanes::ContactExit exit =
      Builder::evaluate(*piece, terms_.data(), (t - piece->time) * piece->per_time, (v - piece->speed) * piece->per_speed);
  exit.ended = true;
  return exit;
}

}  // namespace graze
