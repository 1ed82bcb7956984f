// SPDX-License-Identifier: GPL-3.0-or-later
// Inputs for the fuzzer: damaged copies of valid ones. The same number gives the same input on every machine.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace graze::fuzz {

/// splitmix64: every state gives a good sequence.
class Dice {
 public:
  explicit Dice(std::uint64_t state) : state_(state) {}
  std::uint64_t roll();
  /// A number below `count`, which is at least 1.
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(roll() % count); }
  bool one_in(std::size_t count) { return below(count) == 0; }
  template <class List> auto& one_of(List& list) { return list[below(list.size())]; }

 private:
  std::uint64_t state_;
};

enum class Form { text, json, bytes };

/// One of the seeds after one to eight changes. `words`: words that occur in such a text.
std::string mutated(const std::vector<std::string>& seeds, Form form, const std::vector<std::string>& words, Dice& dice);

}  // namespace graze::fuzz
