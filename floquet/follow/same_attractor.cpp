// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/follow/same_attractor.hpp>
#include <graze/floquet/orbit/state_distance.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze {

namespace {

using States = std::vector<Vector>;

constexpr double as_near = 1e-8;
/// Bound for two samples of one chaotic attractor: mean distance from the states of one to those of the other, relative to the
/// mean distance within a sample.
constexpr double much_farther = 2.0;
constexpr std::size_t fewest_states = 32;
constexpr double standard_errors = 5.0;

/// Distance to the nearest of the states, except the one with index `except`.
double distance(const Vector& x, const States& states, std::size_t except) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < states.size(); ++k)
    if (k != except) least = std::min(least, state_distance(states[k], x));
  return least;
}

double farthest(const States& from, const States& to) {
  double most = 0.0;
  for (const Vector& x : from) most = std::max(most, nearest_distance(to, x) / (1.0 + state_size(x)));
  return most;
}

double mean_distance(const States& from, const States& to) {
  double sum = 0.0;
  for (std::size_t k = 0; k < from.size(); ++k) sum += distance(from[k], to, &from == &to ? k : to.size());
  return sum / static_cast<double>(from.size());
}

bool exponents_agree(const Attractor& a, const Attractor& b) {
  for (std::size_t i = 0; i < a.exponents.size(); ++i) {
    const double error = std::hypot(a.standard_errors[i], b.standard_errors[i]);
    if (a.exponents[i] != b.exponents[i] && !(std::abs(a.exponents[i] - b.exponents[i]) <= standard_errors * error)) return false;
  }
  return true;
}

}  // namespace

bool on_same_attractor(const FollowedAttractor& a, const FollowedAttractor& b) {
  const Attractor &one = a.attractor, &other = b.attractor;
  if (one.type != other.type || one.type == AttractorType::undecided) return false;
  if (one.type == AttractorType::periodic)
    return one.period == other.period && one.impacts == other.impacts && farthest(a.states, b.states) < as_near;
  if (std::min(a.states.size(), b.states.size()) < fewest_states || !exponents_agree(one, other)) return false;
  const double across = std::max(mean_distance(a.states, b.states), mean_distance(b.states, a.states));
  return across < much_farther * std::max(mean_distance(a.states, a.states), mean_distance(b.states, b.states));
}

}  // namespace graze
