// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/vector.hpp>

int main() {
  const graze::Vector start = graze::Vector::Ones(2);
  return start.sum() == 2.0 ? 0 : 1;
}
