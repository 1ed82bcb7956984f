// SPDX-License-Identifier: GPL-3.0-or-later
// Motions in lanes, against the same motions one by one.
#pragma once

#include "support/checks.hpp"

#include <graze/lib/motion/lane_carrier.hpp>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

namespace graze::support {

inline std::vector<MotionStart> random_starts(std::size_t count, double r, std::size_t sets = 1) {
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<MotionStart> starts;
  for (std::size_t i = 0; i < count; ++i) starts.push_back({i % sets, r - 3.0 * unit(generator), 3.0 * unit(generator) - 1.5});
  return starts;
}

struct Difference {
  double state = 0.0, tangent = 0.0, volume = 0.0;
  int impacts = 0, other_endings = 0;
};

/// Largest differences from the Propagator; each period starts from the state in the lanes. The difference of the state is
/// relative to 1 + |Phi|. That of the tangent is relative to its square, because an error of the entry speed is amplified
/// twice.
inline Difference compare(const HybridSystem& system, const std::vector<Vector>& sets, const std::vector<MotionStart>& starts,
                          std::size_t periods, const std::vector<PeriodResult>& results, const FlowOptions& options = {}) {
  Difference worst;
  const auto take = [](double& so_far, double value) {
    if (!(value <= so_far)) so_far = std::isnan(value) ? std::numeric_limits<double>::infinity() : value;
  };
  for (std::size_t set = 0; set < sets.size(); ++set) {
    Propagator propagator(system, sets[set], {}, options);
    const double T = forcing_period(system, sets[set]);
    Transition one;
    for (std::size_t m = 0; m < starts.size(); ++m) {
      if (starts[m].parameters != set) continue;
      for (std::size_t k = 0; k < periods; ++k) {
        const PeriodResult& many = results[m * periods + k];
        const Vector x = k == 0 ? vector({starts[m].x, starts[m].v})
                                : vector({results[m * periods + k - 1].x, results[m * periods + k - 1].v});
        // With the events kept, the Propagator carries flight by flight, which is the reference for the lanes.
        carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::state, .keep_events = true}, one);
        worst.other_endings += one.termination != many.termination ? 1 : 0;
        if (many.termination != Termination::time || one.termination != Termination::time) break;
        const double size = 1.0 + one.Phi.norm();
        take(worst.state, std::hypot(many.x - one.x1[0], many.v - one.x1[1]) / size);
        for (Eigen::Index i = 0; i < 4; ++i)
          take(worst.tangent, std::abs(many.Phi[static_cast<std::size_t>(i)] - one.Phi(i / 2, i % 2)) / (size * size));
        if (std::isfinite(one.liouville)) take(worst.volume, std::abs(many.liouville - one.liouville));
        const double log_det = std::log(std::abs(many.det));
        if (std::isfinite(log_det)) take(worst.volume, std::abs(log_det - many.liouville));
        int impacts = 0;
        for (const std::size_t event : one.event_sequence) impacts += begins_contact(system.events[event].kind) ? 1 : 0;
        worst.impacts += impacts != many.impacts ? 1 : 0;
      }
    }
  }
  return worst;
}

/// Checks that motions from near grazing have the impacts of the Propagator, and that enough of them have some.
inline void check_near_grazing(const HybridSystem& system, const std::vector<Vector>& sets,
                               const std::vector<MotionStart>& starts, std::size_t periods) {
  LaneCarrier many(system);
  for (const Vector& p : sets) many.add_parameters(p);
  std::vector<PeriodResult> results;
  many.carry(starts, periods, true, results);
  int impacts = 0;
  for (const PeriodResult& one : results) impacts += one.impacts;
  CHECK(impacts > 50);
  const Difference worst = compare(system, sets, starts, periods, results);
  CHECK(worst.impacts == 0);
  CHECK(worst.other_endings == 0);
  CHECK(worst.state < 1e-12);
}

}  // namespace graze::support
