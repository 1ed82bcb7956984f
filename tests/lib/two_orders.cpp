// SPDX-License-Identifier: GPL-3.0-or-later
// Two orders of products of series at once, against the plain sums.
#include <graze/lib/lanes/two_orders.hpp>

#include <catch2/catch.hpp>

#include <array>

using namespace graze::lanes;

namespace {

using Series = std::array<double, 16>;
// Integers, so that sums are exact.
constexpr Series a = {3, -1, 4, 1, -5, 9, 2, -6, 5, 3, -5, 8, 9, -7, 9, 3},
                 b = {2, 7, -1, 8, 2, 8, -1, 8, 2, 8, 4, -5, 9, 0, 4, 5}, c = {1, -4, 1, 4, 2, 1, -3, 5, 6, 2, 3, 7, -3, 0, 9, 5};

/// Coefficient n of a product.
double coefficient(const Series& x, const Series& y, std::size_t n) {
  double sum = 0.0;
  for (std::size_t i = 0; i <= n; ++i) sum += x[i] * y[n - i];
  return sum;
}

template <Known Number> void check(std::size_t known) {
  INFO(known << " known");
  const TwoOrders<double, Number, 2, true> two(known, a.data(), b.data(), c.data());
  const TwoOrders<double, Number, 1, false> one(known, b.data(), c.data());
  if (known > 0) {
    CHECK(two.first(0) == coefficient(a, b, known - 1));
    CHECK(two.first(1) == coefficient(a, c, known - 1));
    CHECK(two.first_square() == 0.5 * coefficient(a, a, known - 1));
    CHECK(one.first() == coefficient(b, c, known - 1));
  }
  CHECK(two.second(0) == coefficient(a, b, known));
  CHECK(two.second(1) == coefficient(a, c, known));
  CHECK(two.second_square() == 0.5 * coefficient(a, a, known));
  CHECK(one.second() == coefficient(b, c, known));
}

}  // namespace

TEST_CASE("two orders of products at once agree with the sums of products") {
  check<Known::none>(0);
  for (std::size_t known = 2; known < 16; known += 2) check<Known::even>(known);
  for (std::size_t known = 1; known < 16; known += 2) check<Known::odd>(known);
}
