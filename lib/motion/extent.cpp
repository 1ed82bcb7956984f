// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/motion/extent.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace graze {

namespace {

/// Of the series. A period of a harmonic motion then takes eight panels at rounding accuracy.
constexpr std::size_t degree = 16;
constexpr std::size_t points = degree + 1;
constexpr double panels_of_run = 8.0;  // at least; what is shorter is found because the series do not converge
/// Last coefficients of a series that has converged, relative to the largest value so far: for the value a tenth of what the
/// flows keep, for the rate far less than what an extremum feels, which is the square.
constexpr double value_tolerance = 1e-12, rate_tolerance = 1e-8;
/// A panel in which a function changes less than this, relative to its size, is not halved, whatever its series do: at a bend.
constexpr double least_change = 1e-12;
/// At a jump, where halving does not help: 2^-45 of a stretch is what an event is located to.
constexpr int most_halvings = 45;
/// In one run. A bend takes 90 of them; beyond, the accuracy is that of the first panels.
constexpr std::size_t most_panels = 20000;
constexpr std::size_t looks = 64;  // at the series of a rate in a panel, for changes of sign

using Series = std::array<double, points>;

/// Values at the points -cos(pi j / N), j = 0 ... N, to coefficients of Chebyshev polynomials.
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

/// By Clenshaw's recurrence; s from -1 to 1.
double value_at(const Series& series, double s) {
  double a = 0.0, b = 0.0;
  for (std::size_t k = degree; k > 0; --k) {
    const double next = series[k] + 2.0 * s * a - b;
    b = a;
    a = next;
  }
  return series[0] + s * a - b;
}

/// Over s from -1 to 1.
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

/// Of the last coefficients: of an even or an odd function every second one vanishes.
double remainder(const Series& series) { return std::abs(series[degree]) + std::abs(series[degree - 1]); }

double instant(std::size_t j) { return -std::cos(std::numbers::pi * static_cast<double>(j) / degree); }

class Measuring {
 public:
  Measuring(Propagator& propagator, const equations::MotionFunctions& functions)
      : propagator_(propagator), functions_(functions), out_(functions.size()), value_(functions.size()), rate_(functions.size()),
        size_(functions.size(), 0.0), rate_size_(functions.size(), 0.0) {}

  std::vector<Extent> measure(const Trajectory& run) {
    if (run.segments.empty()) return lost();
    const double longest = (run.segments.back().t1 - run.segments.front().t0) / panels_of_run;
    for (std::size_t i = 0; i < run.segments.size(); ++i) {
      const Segment& segment = run.segments[i];
      take(segment.mode, segment.t0, segment.x0);
      // Where a chatter is complete, the run goes on from its accumulation point a moment later.
      if (i > 0)
        for (std::size_t k = 0; k < out_.size(); ++k) out_[k].integral += (segment.t0 - run.segments[i - 1].t1) * value_[k];
      segment_ = &segment;
      if (segment.t1 > segment.t0) {
        const double length = segment.t1 - segment.t0;
        const double count = std::max(1.0, std::ceil(length / longest));
        HybridState state{segment.t0, segment.x0, segment.mode};
        for (double panel = 0.0; panel < count; ++panel)
          if (!add(state, panel + 1.0 == count ? segment.t1 : segment.t0 + length * ((panel + 1.0) / count), 0)) return lost();
      }
      take(segment.mode, segment.t1, segment.x1);
    }
    for (Extent& extent : out_)
      if (!std::isfinite(extent.integral)) extent = not_known;
    return std::move(out_);
  }

 private:
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  static constexpr Extent not_known{nan, nan, nan};
  std::vector<Extent> lost() const { return std::vector<Extent>(out_.size(), not_known); }

  void take(std::size_t mode, double t, const Vector& x) {
    functions_.evaluate(propagator_.system(), mode, t, x, propagator_.parameters(), value_.data(), rate_.data());
    for (std::size_t k = 0; k < out_.size(); ++k) {
      out_[k].largest = std::max(out_[k].largest, value_[k]);
      out_[k].smallest = std::min(out_[k].smallest, value_[k]);
    }
  }

  /// Within the stretch, whose end is known. A flow that ends with its contact may do so a rounding error before.
  bool go_to(HybridState& state, double t) {
    if (!(t > state.t)) return true;
    const double rounding = guard_tolerance * (1.0 + std::abs(segment_->t1));
    if (t < segment_->t1 && propagator_.coast(state, t)) return true;
    if (segment_->t1 - t > rounding) return false;
    state.t = t;
    state.x = segment_->x1;
    return true;
  }

  /// The panel from `state` to t1, where the state is then. False: it cannot be carried so far.
  bool add(HybridState& state, double t1, int halvings) {
    ++panels_;
    const double t0 = state.t, half = 0.5 * (t1 - t0);
    std::array<HybridState, points> at;
    std::vector<Series> values(out_.size()), rates(out_.size());
    at[0] = state;
    for (std::size_t j = 0; j <= degree; ++j) {
      if (j > 0) {
        at[j] = at[j - 1];
        const double t = j == degree ? t1 : t0 + half * (1.0 + instant(j));
        if (!go_to(at[j], t)) return false;
      }
      take(state.mode, at[j].t, at[j].x);
      for (std::size_t k = 0; k < out_.size(); ++k) {
        values[k][j] = value_[k];
        rates[k][j] = rate_[k];
      }
    }
    std::vector<Series> value_series(out_.size()), rate_series(out_.size());
    bool converged = true;
    for (std::size_t k = 0; k < out_.size(); ++k) {
      value_series[k] = coefficients(values[k]);
      rate_series[k] = coefficients(rates[k]);
      const double steepest = largest(rates[k]);
      size_[k] = std::max(size_[k], largest(values[k]));
      if (std::isfinite(steepest)) rate_size_[k] = std::max(rate_size_[k], steepest);
      const bool lost = !std::isfinite(value_series[k][0]);  // and stays so however small the panels are
      converged = converged && (lost ||
                                (remainder(value_series[k]) <= value_tolerance * size_[k] &&
                                 remainder(rate_series[k]) <= rate_tolerance * rate_size_[k]) ||
                                half * steepest <= least_change * size_[k]);
    }
    if (!converged && halvings < most_halvings && panels_ < most_panels) {
      HybridState middle = at[degree / 2];
      if (!add(state, middle.t, halvings + 1) || !add(middle, t1, halvings + 1)) return false;
      state = std::move(middle);
      return true;
    }
    for (std::size_t k = 0; k < out_.size(); ++k) {
      out_[k].integral += half * integral_of(value_series[k]);
      if (!look_for_extrema(k, value_series[k], rate_series[k], t0, half, at)) return false;
    }
    state = at[degree];
    return true;
  }

  bool look_for_extrema(std::size_t k, const Series& values, const Series& rates, double t0, double half,
                        const std::array<HybridState, points>& at) {
    double from = -1.0, rate_from = value_at(rates, from);
    for (std::size_t look = 1; look <= looks; ++look) {
      const double to = -1.0 + 2.0 * static_cast<double>(look) / looks, rate_to = value_at(rates, to);
      if ((rate_from < 0.0) != (rate_to < 0.0)) {
        double low = from, high = to;
        for (double middle = 0.5 * (low + high); low < middle && middle < high; middle = 0.5 * (low + high))
          ((value_at(rates, middle) < 0.0) == (rate_from < 0.0) ? low : high) = middle;
        const double there = value_at(values, low);
        if (there > out_[k].largest || there < out_[k].smallest) {
          const double t = t0 + half * (1.0 + low);
          std::size_t before = 0;
          while (before < degree && at[before + 1].t <= t) ++before;
          HybridState state = at[before];
          if (!go_to(state, t)) return false;
          take(state.mode, state.t, state.x);
        }
      }
      from = to;
      rate_from = rate_to;
    }
    return true;
  }

  Propagator& propagator_;
  const Segment* segment_ = nullptr;  // the stretch at hand
  const equations::MotionFunctions& functions_;
  std::vector<Extent> out_;
  std::vector<double> value_, rate_;      // where take() was last
  std::vector<double> size_, rate_size_;  // the largest magnitudes so far
  std::size_t panels_ = 0;
};

}  // namespace

std::vector<Extent> extents(Propagator& propagator, const Trajectory& run, const equations::MotionFunctions& functions) {
  return Measuring(propagator, functions).measure(run);
}

}  // namespace graze
