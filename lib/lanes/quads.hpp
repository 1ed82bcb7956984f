// SPDX-License-Identifier: GPL-3.0-or-later
// Quads: vectorise a single motion across its series instead of many motions across lanes. Several series stand side by side in
// a register, so that their products are summed at once. Each sum is that of the series by itself, to the last bit. (With
// several motions in a register quads are not used.)
#pragma once

#include <graze/lib/lanes/two_orders.hpp>

#include <array>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

#ifdef GRAZE_FUSED
template <class Real> inline constexpr bool in_quads = width<Real> == 1;
using Quad = xsimd::batch<double, xsimd::avx2>;
using Pair = xsimd::batch<double, xsimd::sse4_2>;

/// The numbers of a register, in order.
template <class Register> [[gnu::always_inline]] inline std::array<double, Register::size> numbers(const Register& all) {
  alignas(32) std::array<double, Register::size> out;
  all.store_aligned(out.data());
  return out;
}
#else
template <class Real> inline constexpr bool in_quads = false;
struct Quad {};
struct Pair {};
template <class Register> std::array<double, 4> numbers(const Register&);
#endif

/// The series of a Hertz contact (ContactSeries).
template <bool Used, std::size_t Order> struct ContactQuads {};
template <std::size_t Order> struct ContactQuads<true, Order> {
  Quad left[Order + 1], right[Order + 1];  ///< (y, y, y, u) and (c, s, y^4, y): entry k has order k + 1, but order k of c and s
  Pair roots[Order + 1];                   ///< (y, u), of order k + 1
  Quad factors[Order + 1], columns[Order + 1];  ///< (y, y, f, f) and (p_0, p_1, z_0, z_1)
};

/// The series of a flight with its tangent (FlightSeries).
template <bool Used, std::size_t Order> struct FlightQuads {};
template <std::size_t Order> struct FlightQuads<true, Order> {
  Quad bend[Order + 1], columns[Order + 1];  ///< -beta x^2 four times, and (x, dx_0, dx_1, 0)
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
