// SPDX-License-Identifier: GPL-3.0-or-later
// Approximate roots of numbers in lanes, from the bits of their doubles.
#pragma once

#include <graze/lib/lanes/real.hpp>

#include <bit>
#include <cstdint>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// Added to a whole number below 2^32, it puts that number into the lower half of the double.
inline constexpr double two_to_52 = 4503599627370496.0;

/// The upper half of a double read as a whole number: its logarithm to base 2 within 0.09, in units of 2^-20.
template <class Real> [[gnu::always_inline]] inline Real upper_half(const Real& x) {
  constexpr auto above = std::bit_cast<std::uint64_t>(two_to_52);
  if constexpr (width<Real> == 1) {
    return std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) >> 32 | above) - two_to_52;
  } else {
    using Whole = xsimd::batch<std::uint64_t, typename Real::arch_type>;
    return xsimd::bitwise_cast<Real>(Whole(xsimd::bitwise_cast<Whole>(x) >> 32 | Whole(above))) - Real(two_to_52);
  }
}
/// The double with this upper half, rounded to a whole number, and a lower half of zero.
template <class Real> [[gnu::always_inline]] inline Real from_upper_half(const Real& half) {
  if constexpr (width<Real> == 1) {
    return std::bit_cast<double>(std::bit_cast<std::uint64_t>(half + two_to_52) << 32);
  } else {
    using Whole = xsimd::batch<std::uint64_t, typename Real::arch_type>;
    return xsimd::bitwise_cast<Real>(Whole(xsimd::bitwise_cast<Whole>(Real(half + Real(two_to_52))) << 32));
  }
}

/// (x/y)^(1/order) to 4%, like detail::rough_root(), for y >= 0.
template <std::size_t order, class Real> [[gnu::always_inline]] inline Real rough_root(double x, const Real& y) {
  const double one = upper_half(1.0);
  constexpr double inverse = 1.0 / static_cast<double>(order);
  return 0.97 * from_upper_half(Real(one + inverse * (upper_half(x) - upper_half(y))));
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
