// SPDX-License-Identifier: GPL-3.0-or-later
// The recurrences of the Taylor series, compiled once for every processor and once for those with AVX2 and fused multiply-add
// (series_generic.cpp, series_fused.cpp), and chosen at run time. The two differ by rounding.
#pragma once

#include <graze/lib/flow/cubic_recurrence.hpp>
#include <graze/lib/flow/hertz_recurrence.hpp>

namespace graze::detail {

/// expand: all coefficients, from the motion at the step's start; at: the motion h later, or a step of s later.
template <class Terms> struct Kernel {
  void (*expand)(Terms& terms);
  void (*at)(const Terms& terms, double h, typename Terms::State& to);
};

template <class... Terms> struct KernelsOf : Kernel<Terms>... {};
using SeriesKernels =
    KernelsOf<CubicTerms<1>, CubicTerms<2>, CubicTerms<3>, HertzTerms<0>, HertzTerms<1>, HertzTerms<2>, HertzTerms<3>>;

extern const SeriesKernels series_generic, series_fused;
/// The fastest kernels for this processor.
const SeriesKernels& series_kernels();

/// `Machine`: four numbers in registers, Quad, with + - * /, load, store, all (four times one number), set, first (a number and
/// three zeros), fma(a, b, c) = a b + c (of quads and of numbers), magnitude, sum, largest, swapped (a[1], a[0], b[2], b[3]),
/// high_less_low (a[2] - b[0], a[3] - b[1], and again).
template <class Machine> constexpr SeriesKernels kernels_for() {
  const auto cubic = []<std::size_t Quads>(CubicTerms<Quads>*) -> Kernel<CubicTerms<Quads>> {
    return {CubicRecurrence<Machine, Quads>::expand, CubicRecurrence<Machine, Quads>::at};
  };
  const auto hertz = []<std::size_t Quads>(HertzTerms<Quads>*) -> Kernel<HertzTerms<Quads>> {
    return {HertzRecurrence<Machine, Quads>::expand, HertzRecurrence<Machine, Quads>::at};
  };
  return {cubic(static_cast<CubicTerms<1>*>(nullptr)), cubic(static_cast<CubicTerms<2>*>(nullptr)),
          cubic(static_cast<CubicTerms<3>*>(nullptr)), hertz(static_cast<HertzTerms<0>*>(nullptr)),
          hertz(static_cast<HertzTerms<1>*>(nullptr)), hertz(static_cast<HertzTerms<2>*>(nullptr)),
          hertz(static_cast<HertzTerms<3>*>(nullptr))};
}

}  // namespace graze::detail
