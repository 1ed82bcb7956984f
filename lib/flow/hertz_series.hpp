// SPDX-License-Identifier: GPL-3.0-or-later
// HertzSeries: Taylor series of order 16 of a Hertz contact in regularising variables, of its tangent and of its derivatives in
// the parameters (hertz_recurrence.hpp), by the fastest kernels for the processor. Nothing is allocated.
#pragma once

#include <graze/lib/flow/series_kernels.hpp>

#include <algorithm>
#include <vector>

namespace graze::detail {

template <std::size_t Quads> class HertzSeries {
 public:
  using C = HertzContact;
  using Terms = HertzTerms<Quads>;
  using State = HertzState<Quads>;

  /// `sources`: coefficients for the derivatives in columns 2, 3, ... of the tangent; t0: time at which HertzState::time is 0.
  HertzSeries(const C& contact, const std::vector<std::size_t>& sources, double t0,
              const SeriesKernels& kernels = series_kernels())
      : kernel_(kernels) {
    std::copy(contact.value.begin(), contact.value.end(), terms_.q);
    terms_.with_cubic = contact.value[C::beta] != 0.0 || std::find(sources.begin(), sources.end(), C::beta) != sources.end();
    terms_.sources = sources.data();
    terms_.source_count = sources.size();
    terms_.t0 = t0;
  }

  /// The series of the contact through z.
  void expand(const State& z) {
    terms_.start = z;
    kernel_.expand(terms_);
  }
  /// Its sum at s.
  State at(double s) const {
    State z;
    kernel_.at(terms_, s, z);
    return z;
  }
  double depth(double s) const { return one(0, s); }
  double speed(double s) const { return one(1, s); }
  double time(double s) const { return one(2, s); }
  /// Largest coefficient of the last order and of the one before, each relative to 1 + |its quantity|; not finite if one of
  /// them is not.
  double last() const { return terms_.last; }
  double before() const { return terms_.before; }

 private:
  double one(std::size_t quantity, double s) const {
    const double square = s * s;
    double even = terms_.motion[hertz_order][quantity], odd = terms_.motion[hertz_order - 1][quantity];
    for (std::size_t k = hertz_order; k > 2; k -= 2) {
      even = terms_.motion[k - 2][quantity] + square * even;
      odd = terms_.motion[k - 3][quantity] + square * odd;
    }
    return terms_.motion[0][quantity] + square * even + s * odd;
  }

  Kernel<Terms> kernel_;
  Terms terms_;
};

}  // namespace graze::detail
