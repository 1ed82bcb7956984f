// SPDX-License-Identifier: GPL-3.0-or-later
// Two orders of products of series at once, against the sums themselves.
#include <graze/lib/lanes/two_orders.hpp>

#include <catch2/catch.hpp>

#include <array>
#include <utility>

using namespace graze::lanes;

namespace {

using Series = std::array<double, 16>;
// Whole numbers, so that sums are exact.
constexpr Series a = {3, -1, 4, 1, -5, 9, 2, -6, 5, 3, -5, 8, 9, -7, 9, 3},
                 b = {2, 7, -1, 8, 2, 8, -1, 8, 2, 8, 4, -5, 9, 0, 4, 5}, c = {1, -4, 1, 4, 2, 1, -3, 5, 6, 2, 3, 7, -3, 0, 9, 5};

/// Coefficient n of a product.
double coefficient(const Series& x, const Series& y, std::size_t n) {
  double sum = 0.0;
  for (std::size_t i = 0; i <= n; ++i) sum += x[i] * y[n - i];
  return sum;
}

template <std::size_t Known> void check() {
  INFO(Known << " known");
  const TwoOrders<double, Known, 2, true> two(a.data(), b.data(), c.data());
  const TwoOrders<double, Known, 1, false> one(b.data(), c.data());
  if (Known > 0) {
    CHECK(two.first(0) == coefficient(a, b, Known - 1));
    CHECK(two.first(1) == coefficient(a, c, Known - 1));
    CHECK(two.first_square() == 0.5 * coefficient(a, a, Known - 1));
    CHECK(one.first() == coefficient(b, c, Known - 1));
  }
  CHECK(two.second(0) == coefficient(a, b, Known));
  CHECK(two.second(1) == coefficient(a, c, Known));
  CHECK(two.second_square() == 0.5 * coefficient(a, a, Known));
  CHECK(one.second() == coefficient(b, c, Known));
}

}  // namespace

TEST_CASE("two orders of products at once are the sums of products") {
  [&]<std::size_t... known>(std::index_sequence<known...>) { (check<known>(), ...); }
  (std::make_index_sequence<16>());
}
