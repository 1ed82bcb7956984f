// SPDX-License-Identifier: GPL-3.0-or-later
// CubicSeries: Taylor series of order 16 in time of a cubic oscillator, of its tangent and of its derivatives in the
// coefficients (cubic_recurrence.hpp), by the fastest kernels for the processor. Nothing is allocated.
#pragma once

#include <graze/lib/flow/series_kernels.hpp>
#include <graze/lib/system/mode_structure.hpp>

#include <algorithm>
#include <span>
#include <vector>

namespace graze::detail {

template <std::size_t Quads> class CubicSeries {
 public:
  using C = CubicOscillator;
  using Terms = CubicTerms<Quads>;
  using State = CubicState<Quads>;
  static constexpr bool same(C::Coefficient a, typename Terms::Coefficient b) { return std::size_t{a} == std::size_t{b}; }
  static_assert(same(C::damping, Terms::damping) && same(C::stiffness, Terms::stiffness) && same(C::cubic, Terms::cubic) &&
                same(C::amplitude, Terms::amplitude) && same(C::frequency, Terms::frequency) &&
                same(C::constant, Terms::constant));

  /// `sources`: coefficients for the derivatives in columns 2, 3, ... of the tangent; x0: position at which State::moved is 0.
  CubicSeries(const C& oscillator, const std::vector<std::size_t>& sources, double x0,
              const SeriesKernels& kernels = series_kernels())
      : kernel_(kernels) {
    std::copy(oscillator.value.begin(), oscillator.value.end(), terms_.q);
    terms_.sources = sources.data();
    terms_.source_count = sources.size();
    terms_.x0 = x0;
    double turn = 1.0;
#pragma GCC unroll 32
    for (std::size_t n = 0; n <= cubic_order; ++n) {
      terms_.turn[n] = turn;
      terms_.force[n] = terms_.q[C::amplitude] * turn;
      turn *= terms_.q[C::frequency] * (1.0 / static_cast<double>(n + 1));
    }
  }

  /// The series of the motion through z at time t.
  void expand(double t, const State& z) {
    terms_.t = t;
    terms_.start = z;
    kernel_.expand(terms_);
  }
  /// Its sum h later.
  State at(double h) const {
    State z;
    kernel_.at(terms_, h, z);
    return z;
  }
  /// Coefficients of x.
  std::span<const double, cubic_order + 1> position() const { return terms_.x; }
  /// Sums of the coefficients of the last order and of the one before, each relative to 1 + |its quantity|; not finite if one
  /// of them is not.
  double last() const { return terms_.last; }
  double before() const { return terms_.before; }

 private:
  Kernel<Terms> kernel_;
  Terms terms_;
};

}  // namespace graze::detail
