// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/grazing_turns.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>

namespace graze {

namespace {

constexpr int most_turns_counted = 16;

/// R_1 ... R_m for m = `turns`.
std::vector<double> responses(const TurnResponse& response, int turns) {
  const Eigen::Index n = response.turn.rows();
  Matrix power = Matrix::Identity(n, n);
  for (int k = 0; k < turns; ++k) power = response.turn * power;
  Vector deviation = (Matrix::Identity(n, n) - power).partialPivLu().solve(response.kick);
  std::vector<double> list;
  for (int k = 0; k < turns; ++k) {
    deviation = response.turn * deviation;
    list.push_back(response.gradient.dot(deviation));
  }
  return list;
}

/// See side_of_family; R holds R_1 ... R_m.
int side_of(const std::vector<double>& R, const std::vector<int>& struck) {
  const int turns = static_cast<int>(R.size());
  const auto between = [&](int i, int j) { return R[static_cast<std::size_t>((i - j + turns - 1) % turns)]; };
  const auto count = static_cast<Eigen::Index>(struck.size());
  Matrix A(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j)
      A(i, j) = between(struck[static_cast<std::size_t>(i)], struck[static_cast<std::size_t>(j)]);
  const Vector speeds = A.partialPivLu().solve(Vector::Constant(count, -1.0));  // at h_top = 1
  const int side = speeds[0] > 0.0 ? 1 : -1;
  if (!((side * speeds.array()) > 0.0).all()) return 0;
  std::size_t next = 0;
  for (int i = 0; i < turns; ++i) {
    if (next < struck.size() && struck[next] == i) {
      ++next;
      continue;
    }
    double h = 1.0;
    for (Eigen::Index j = 0; j < count; ++j) h += between(i, struck[static_cast<std::size_t>(j)]) * speeds[j];
    if (!(side * h < 0.0)) return 0;
  }
  return side;
}

}  // namespace

TurnResponse turn_response(const LocatedGrazing& grazing, int nodes) {
  TurnResponse response{grazing.round.front(), grazing.gradient, grazing.kick};
  for (int k = 1; k < nodes; ++k) response.turn = grazing.round[static_cast<std::size_t>(k)] * response.turn;
  response.turn = grazing.round.back() * response.turn;
  return response;
}

int side_of_family(const TurnResponse& response, int turns, const std::vector<int>& struck) {
  return side_of(responses(response, turns), struck);
}

int families_in_some_turns(const TurnResponse& response, int turns) {
  const std::vector<double> R = responses(response, turns);
  const std::uint32_t all = (1u << turns) - 1;
  int families = 0;
  // One bit per turn. Each family is represented by the smallest of its rotations, which has an impact in the first turn.
  for (std::uint32_t set = 1; set < all; set += 2) {
    const int count = std::popcount(set);
    if (count < 2 || count > turns - 2) continue;
    bool least = true;
    for (int by = 1; by < turns && least; ++by) least = set < (((set << by) | (set >> (turns - by))) & all);
    if (!least) continue;
    std::vector<int> struck;
    for (int i = 0; i < turns; ++i)
      if (set >> i & 1u) struck.push_back(i);
    families += side_of(R, struck) != 0 ? 1 : 0;
  }
  return families;
}

int families_not_followed(const LocatedGrazing& grazing, int nodes, int longest) {
  if (grazing.touches > 1 || grazing.round.empty() || longest < 4) return 0;
  const TurnResponse response = turn_response(grazing, nodes);
  int families = 0;
  for (int turns = 4; turns <= std::min(longest, most_turns_counted); ++turns)
    families += families_in_some_turns(response, turns);
  return families;
}

std::string others_text(int families, int longest) {
  return fmt::format("{} with the weak impact in some of {} turns (neither one nor all but one) {} here, to first order; "
                     "none is followed from here, some may have been found elsewhere",
                     families == 1 ? "1 family" : fmt::format("{} families", families),
                     longest > 4 ? fmt::format("4 to {}", std::min(longest, most_turns_counted)) : "4",
                     families == 1 ? "begins" : "begin");
}

}  // namespace graze
