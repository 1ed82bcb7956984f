// SPDX-License-Identifier: GPL-3.0-or-later
// CubicTangentSeries: the series of cubic_series.hpp of order 16 with the two columns of Phi and no others, by the kernel that
// the processor has (cubic_tangent.hpp); the numbers are the same.
#pragma once

#include <graze/lib/detail/cubic_tangent.hpp>
#include <graze/lib/mode_structure.hpp>

#include <array>
#include <cmath>

namespace graze::detail {

class CubicTangentSeries {
 public:
  using C = CubicOscillator;
  /// As CubicState<1>, number by number.
  struct State {
    double moved = 0.0, v = 0.0;
    std::array<std::array<double, 2>, 1> dx{}, dv{};
  };
  using Series = double[cubic_order + 1];

  CubicTangentSeries(const C& oscillator, const std::vector<std::size_t>&, double x0, const CubicKernel& kernel = cubic_kernel())
      : kernel_(kernel), frequency_(oscillator.value[C::frequency]) {
    terms_.x0 = x0;
    terms_.damping = oscillator.value[C::damping];
    terms_.stiffness = oscillator.value[C::stiffness];
    terms_.cubic = oscillator.value[C::cubic];
    terms_.constant = oscillator.value[C::constant];
    double force = oscillator.value[C::amplitude];
#pragma GCC unroll 32
    for (std::size_t n = 0; n <= cubic_order; ++n) {
      terms_.force[n] = force;
      force *= frequency_ * (1.0 / static_cast<double>(n + 1));
    }
  }
  void expand(double t, const State& z) {
    terms_.cosine = std::cos(frequency_ * t);
    terms_.sine = std::sin(frequency_ * t);
    terms_.moved = z.moved;
    terms_.v = z.v;
    for (std::size_t i = 0; i < 2; ++i) {
      terms_.dx[i] = z.dx[0][i];
      terms_.dv[i] = z.dv[0][i];
    }
    kernel_.expand(terms_);
  }
  State at(double h) const {
    alignas(32) double z[8];
    kernel_.at(terms_, h, z);
    return {z[0], z[4], {{{z[1], z[2]}}}, {{{z[5], z[6]}}}};
  }
  const Series& position() const { return terms_.x; }
  double size(std::size_t k) const { return k == cubic_order ? terms_.last : terms_.before; }

 private:
  CubicKernel kernel_;
  double frequency_;
  CubicTerms terms_;
};

}  // namespace graze::detail
