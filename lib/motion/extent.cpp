// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/motion/extent.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

namespace graze {

namespace {

/// Degree of the series. A period of a harmonic motion then takes eight panels at rounding accuracy.
constexpr std::size_t degree = 16;
constexpr std::size_t points = degree + 1;
constexpr double panels_of_run = 8.0;  // at least; shorter features are found because the series do not converge
/// A series has converged if its last coefficients are below this, relative to the largest value so far. For the value, this is
/// ten times the default tolerance of the flows. For the rate, it is far less than an extremum needs, which depends on the
/// square.
constexpr double value_tolerance = 1e-12, rate_tolerance = 1e-8;
/// A panel in which a function changes less than this, relative to its size, is not halved even if its series do not converge:
/// at the start of a square root.
constexpr double least_change = 1e-12;
/// Events are located to 2^-45 of a stretch.
constexpr int most_halvings = 45;
/// Limit for one run. The start of a square root takes 90 panels.
constexpr std::size_t most_panels = 20000;
/// A singularity that remains in a panel of the least width is integrable if the panel holds less than this of the integral.
constexpr double least_share = 1e-10;
constexpr std::size_t looks = 64;  // samples of a rate's series in a panel, to find changes of sign
/// An argument of a nonsmooth function below this, relative to its largest value so far, has no sign: this is the accuracy of
/// its series.
constexpr double sign_tolerance = value_tolerance;

using Series = std::array<double, points>;

/// Coefficients of Chebyshev polynomials, from the values at the points -cos(pi j / N), j = 0 ... N.
Series coefficients(const Series& values) {
  static const auto matrix = [] {
    std::array<Series, points> out;
    for (std::size_t k = 0; k <= degree; ++k)
      for (std::size_t j = 0; j <= degree; ++j) {
        const double angle = std::numbers::pi * (1.0 - static_cast<double>(j) / degree);
        const double weight = (j == 0 || j == degree ? 0.5 : 1.0) * (k == 0 || k == degree ? 1.0 : 2.0) / degree;
        out[k][j] = weight * std::cos(static_cast<double>(k) * angle);
      }
    return out;
  }();
  Series series{};
  for (std::size_t k = 0; k <= degree; ++k)
    for (std::size_t j = 0; j <= degree; ++j) series[k] += matrix[k][j] * values[j];
  return series;
}

/// The series at s in [-1, 1], by Clenshaw's recurrence.
double value_at(const Series& series, double s) {
  double a = 0.0, b = 0.0;
  for (std::size_t k = degree; k > 0; --k) {
    const double next = series[k] + 2.0 * s * a - b;
    b = a;
    a = next;
  }
  return series[0] + s * a - b;
}

/// The zero of the series between s = low and s = high, where it has different signs.
double zero_between(const Series& series, double low, double high) {
  const bool negative = value_at(series, low) < 0.0;
  for (double middle = 0.5 * (low + high); low < middle && middle < high; middle = 0.5 * (low + high))
    ((value_at(series, middle) < 0.0) == negative ? low : high) = middle;
  return low;
}

/// The points s where the rate of a function changes its sign.
std::vector<double> turns(const Series& rates) {
  std::vector<double> list;
  double from = -1.0, rate_from = value_at(rates, from);
  for (std::size_t look = 1; look <= looks; ++look) {
    const double to = -1.0 + 2.0 * static_cast<double>(look) / looks, rate_to = value_at(rates, to);
    if ((rate_from < 0.0) != (rate_to < 0.0)) list.push_back(zero_between(rates, from, to));
    from = to;
    rate_from = rate_to;
  }
  return list;
}

/// Integral of the series over s from -1 to 1.
double integral_of(const Series& series) {
  double sum = 0.0;
  for (std::size_t k = 0; k <= degree; k += 2) sum += 2.0 * series[k] / (1.0 - static_cast<double>(k * k));
  return sum;
}

double largest(const Series& values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

/// The last two coefficients, in modulus: every second one vanishes for an even or an odd function.
double remainder(const Series& series) { return std::abs(series[degree]) + std::abs(series[degree - 1]); }

double instant(std::size_t j) { return -std::cos(std::numbers::pi * static_cast<double>(j) / degree); }

class ExtentIntegrator {
 public:
  ExtentIntegrator(Propagator& propagator, const equations::MotionFunctions& functions, const std::vector<bool>& wanted)
      : propagator_(propagator), functions_(functions), wanted_(wanted), out_(functions.size()),
        all_(functions.size() + functions.arguments()), value_(all_), rate_(all_), size_(all_, 0.0), rate_size_(all_, 0.0),
        absolute_(functions.size(), 0.0), unresolved_(functions.size(), 0.0) {
    for (std::size_t k = 0; k < out_.size(); ++k)
      if (!wanted[k]) out_[k] = not_known;
  }
  bool is_exhausted() const { return panels_ >= most_panels; }

  std::vector<Extent> measure(const Trajectory& run) {
    if (run.segments.empty()) return lost();
    const double longest = (run.segments.back().t1 - run.segments.front().t0) / panels_of_run;
    for (std::size_t i = 0; i < run.segments.size(); ++i) {
      const Segment& segment = run.segments[i];
      segment_ = &segment;
      functions_.evaluate(propagator_.system(), segment.mode, segment.t0, segment.x0, propagator_.parameters(), value_.data(),
                          rate_.data());
      // After complete chatter the run continues from the accumulation point, a moment later.
      if (i > 0)
        for (std::size_t k = 0; k < out_.size(); ++k) out_[k].integral += (segment.t0 - run.segments[i - 1].t1) * value_[k];
      if (segment.t1 > segment.t0) {
        const double length = segment.t1 - segment.t0;
        const double count = std::max(1.0, std::ceil(length / longest));
        HybridState state{segment.t0, segment.x0, segment.mode};
        for (double panel = 0.0; panel < count; ++panel)
          if (!add(state, panel + 1.0 == count ? segment.t1 : segment.t0 + length * ((panel + 1.0) / count), 0)) return lost();
      } else {
        widen();
      }
    }
    for (std::size_t k = 0; k < out_.size(); ++k)
      if (!std::isfinite(out_[k].integral) || unresolved_[k] > least_share * absolute_[k] || is_exhausted()) out_[k] = not_known;
    return std::move(out_);
  }

 private:
  using Signs = std::vector<int>;
  using Points = std::array<HybridState, points>;
  /// A function or an argument in a panel.
  struct Piece {
    Series values{}, rates{};  // at the points
    Series value_series{}, rate_series{};
  };

  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  static constexpr Extent not_known{nan, nan, nan};
  std::vector<Extent> lost() const { return std::vector<Extent>(out_.size(), not_known); }

  void evaluate(const HybridState& at, const Signs& signs) {
    functions_.evaluate(propagator_.system(), at.mode, at.t, at.x, propagator_.parameters(), signs, value_.data(), rate_.data());
    // On a branch, abs(a) is a rounding error below zero where it ends, and a power of it is not defined there.
    const auto is_finite = [](double value) { return std::isfinite(value); };
    const auto end = value_.begin() + static_cast<std::ptrdiff_t>(out_.size());
    if (signs.empty() || std::all_of(value_.begin(), end, is_finite)) return;
    plain_value_.resize(out_.size());
    plain_rate_.resize(out_.size());
    functions_.evaluate(propagator_.system(), at.mode, at.t, at.x, propagator_.parameters(), plain_value_.data(),
                        plain_rate_.data());
    for (std::size_t k = 0; k < out_.size(); ++k) {
      if (std::isfinite(value_[k])) continue;
      value_[k] = plain_value_[k];
      rate_[k] = plain_rate_[k];
    }
  }

  /// Widens the extents by the present values.
  void widen() {
    for (std::size_t k = 0; k < out_.size(); ++k) {
      if (!wanted_[k]) continue;
      out_[k].largest = std::max(out_[k].largest, value_[k]);
      out_[k].smallest = std::min(out_[k].smallest, value_[k]);
    }
  }

  /// Carries `state` to t within the stretch, whose end is known. A flow that ends with its contact may end a rounding error
  /// too early.
  bool go_to(HybridState& state, double t) {
    if (!(t > state.t)) return true;
    const double rounding = guard_tolerance * (1.0 + std::abs(segment_->t1));
    if (t < segment_->t1 && propagator_.coast(state, t)) return true;
    if (segment_->t1 - t > rounding) return false;
    state.t = t;
    state.x = segment_->x1;
    return true;
  }

  /// The state at t, carried from the last point before it.
  std::optional<HybridState> state_at(const Points& at, double t) {
    std::size_t before = 0;
    while (before < degree && at[before + 1].t <= t) ++before;
    HybridState state = at[before];
    return go_to(state, t) ? std::optional(std::move(state)) : std::nullopt;
  }

  /// Computes the series of a function or an argument from its values and returns whether they converge.
  bool expand(std::size_t k, Piece& piece, double half) {
    piece.value_series = coefficients(piece.values);
    piece.rate_series = coefficients(piece.rates);
    const double steepest = largest(piece.rates);
    size_[k] = std::max(size_[k], largest(piece.values));
    if (std::isfinite(steepest)) rate_size_[k] = std::max(rate_size_[k], steepest);
    // Halving does not help if the function is nowhere defined.
    const bool undefined = std::none_of(piece.values.begin(), piece.values.end(), [](double v) { return std::isfinite(v); });
    return undefined ||
           (remainder(piece.value_series) <= value_tolerance * size_[k] &&
            remainder(piece.rate_series) <= rate_tolerance * rate_size_[k]) ||
           half * steepest <= least_change * size_[k];
  }

  /// Adds the panel from `state` to t1 and moves `state` there. False: the motion cannot be carried so far.
  bool add(HybridState& state, double t1, int halvings) {
    ++panels_;
    const double t0 = state.t, half = 0.5 * (t1 - t0);
    Points at;
    at[0] = state;
    for (std::size_t j = 1; j <= degree; ++j) {
      at[j] = at[j - 1];
      if (!go_to(at[j], j == degree ? t1 : t0 + half * (1.0 + instant(j)))) return false;
    }
    bool converged = true;
    double cut = t1;
    Signs signs(functions_.arguments(), 0);
    for (std::size_t i = 0; i < signs.size(); ++i) {
      const std::size_t k = out_.size() + i;
      Piece argument;
      for (std::size_t j = 0; j <= degree; ++j) {
        evaluate(at[j], signs);
        argument.values[j] = value_[k];
        argument.rates[j] = rate_[k];
      }
      const bool smooth = expand(k, argument, half);
      converged = converged && smooth;
      const std::optional<double> s = find_sign(argument, sign_tolerance * size_[k], signs[i]);
      if (!smooth || !s) continue;
      double t = t0 + half * (1.0 + *s);
      const std::optional<HybridState> there = state_at(at, t);
      if (!there) return false;
      evaluate(*there, signs);
      if (const double polished = t - value_[k] / rate_[k]; std::abs(polished - t) < sign_tolerance * half) t = polished;
      cut = std::min(cut, t);
    }
    const bool may_divide = panels_ < most_panels;
    if (converged && may_divide && t0 < cut && cut < t1) return add(state, cut, halvings) && add(state, t1, halvings);
    std::vector<Piece> pieces(out_.size());
    for (std::size_t j = 0; j <= degree; ++j) {
      evaluate(at[j], signs);
      widen();
      for (std::size_t k = 0; k < out_.size(); ++k) {
        pieces[k].values[j] = value_[k];
        pieces[k].rates[j] = rate_[k];
      }
    }
    std::vector<bool> smooth(out_.size(), true);
    for (std::size_t k = 0; k < out_.size(); ++k) {
      if (wanted_[k]) smooth[k] = expand(k, pieces[k], half);
      converged = converged && smooth[k];
    }
    if (!converged && halvings < most_halvings && may_divide) {
      HybridState middle = at[degree / 2];
      if (!add(state, middle.t, halvings + 1) || !add(middle, t1, halvings + 1)) return false;
      state = std::move(middle);
      return true;
    }
    for (std::size_t k = 0; k < out_.size(); ++k) {
      if (!wanted_[k]) continue;
      double size = 0.0;
      for (const double value : pieces[k].values)
        if (std::isfinite(value)) size = std::max(size, half * std::abs(value));
      absolute_[k] += size;
      if (!smooth[k]) unresolved_[k] = std::max(unresolved_[k], size);
      if (const double part = half * integral_of(pieces[k].value_series); smooth[k] || std::isfinite(part))
        out_[k].integral += part;
      if (!look_for_extrema(k, pieces[k], t0, half, at, signs)) return false;
    }
    state = at[degree];
    return true;
  }

  /// Finds the first sign of an argument, and returns the s where it changes. Values below the tolerance have no sign.
  static std::optional<double> find_sign(const Piece& argument, double tolerance, int& sign) {
    std::vector<double> ends = turns(argument.rate_series);  // between them the argument is monotone
    ends.insert(ends.begin(), -1.0);
    ends.push_back(1.0);
    for (std::size_t i = 0; i < ends.size(); ++i) {
      const double value = value_at(argument.value_series, ends[i]);
      if (!(std::abs(value) > tolerance)) continue;
      const int own = value > 0.0 ? 1 : -1;
      if (sign != 0 && own != sign) {
        const bool before = value_at(argument.value_series, ends[i - 1]) * sign > 0.0;
        return before ? zero_between(argument.value_series, ends[i - 1], ends[i]) : ends[i - 1];
      }
      sign = own;
    }
    return std::nullopt;
  }

  bool look_for_extrema(std::size_t k, const Piece& piece, double t0, double half, const Points& at, const Signs& signs) {
    for (const double s : turns(piece.rate_series)) {
      const double there = value_at(piece.value_series, s);
      if (!(there > out_[k].largest || there < out_[k].smallest)) continue;
      const std::optional<HybridState> state = state_at(at, t0 + half * (1.0 + s));
      if (!state) return false;
      evaluate(*state, signs);
      widen();
    }
    return true;
  }

  Propagator& propagator_;
  const Segment* segment_ = nullptr;  // the present stretch
  const equations::MotionFunctions& functions_;
  const std::vector<bool>& wanted_;
  std::vector<Extent> out_;
  std::size_t all_;                       // number of functions, then arguments
  std::vector<double> value_, rate_;      // at the last state
  std::vector<double> size_, rate_size_;  // the largest magnitudes so far
  std::vector<double> plain_value_, plain_rate_;
  // Of each function: a bound of the integral of its magnitude, and its largest part in a panel whose series do not converge.
  std::vector<double> absolute_, unresolved_;
  std::size_t panels_ = 0;
};

}  // namespace

std::vector<Extent> extents(Propagator& propagator, const Trajectory& run, const equations::MotionFunctions& functions,
                            const std::vector<bool>& wanted) {
  ExtentIntegrator together(propagator, functions, wanted);
  std::vector<Extent> out = together.measure(run);
  if (!together.is_exhausted() || std::count(wanted.begin(), wanted.end(), true) < 2) return out;
  // One of them takes all panels: each by itself.
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    if (!wanted[k]) continue;
    std::vector<bool> alone(wanted.size(), false);
    alone[k] = true;
    out[k] = ExtentIntegrator(propagator, functions, alone).measure(run)[k];
  }
  return out;
}

}  // namespace graze
