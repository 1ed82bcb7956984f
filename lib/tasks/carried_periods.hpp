// SPDX-License-Identifier: GPL-3.0-or-later
// CarriedPeriods: the periods of a motion carried for a task, in the same words whether lanes or a Propagator carried it.
#pragma once

#include <graze/lib/motion/lane_carrier.hpp>
#include <graze/lib/motion/transition.hpp>
#include <graze/lib/numerics/log_product.hpp>

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace graze {

/// The periods of a motion in the order of time. Once the motion has ended, all further ones have the same termination. Valid
/// until the next request of the task.
class CarriedPeriods {
 public:
  explicit CarriedPeriods(std::span<const PeriodResult> in_lanes) : in_lanes_(in_lanes) {}
  /// By a Propagator of the system, which must outlive this.
  CarriedPeriods(std::span<const Transition> alone, const HybridSystem& system) : alone_(alone), system_(&system) {}

  std::size_t size() const { return in_lanes_.size() + alone_.size(); }
  /// `count` of them, from `begin` on.
  CarriedPeriods part(std::size_t begin, std::size_t count) const {
    return system_ ? CarriedPeriods(alone_.subspan(begin, count), *system_) : CarriedPeriods(in_lanes_.subspan(begin, count));
  }

  Termination termination(std::size_t k) const { return system_ ? alone_[k].termination : in_lanes_[k].termination; }
  /// Writes the state at the end of period k: at forcing phase 0, or right after a return.
  void state(std::size_t k, Vector& x) const {
    if (system_)
      x = alone_[k].x1;
    else
      x << in_lanes_[k].x, in_lanes_[k].v;
  }

  // Of a request with tangent:

  /// Writes the first-order map of period k from state to state (n x n).
  void map(std::size_t k, Matrix& out) const {
    if (system_) {
      out = period_map(alone_[k]);
      return;
    }
    const auto& Phi = in_lanes_[k].Phi;
    out.resize(2, 2);
    out << Phi[0], Phi[1], Phi[2], Phi[3];
  }
  Matrix map(std::size_t k) const {
    Matrix out;
    map(k, out);
    return out;
  }
  /// Its first-order map from beginning to end at fixed times: that of tangent vectors. With two states, row by row.
  Matrix tangent_map(std::size_t k) const { return system_ ? alone_[k].Phi : map(k); }
  std::array<double, 4> tangent_map_of_two(std::size_t k) const {
    if (!system_) return in_lanes_[k].Phi;
    const Matrix& Phi = alone_[k].Phi;
    return {Phi(0, 0), Phi(0, 1), Phi(1, 0), Phi(1, 1)};
  }
  /// Multiplies a product by |det| of that map, factor by factor; NaN if it is lost to cancellation.
  void multiply_determinant(std::size_t k, LogProduct& product) const {
    system_ ? product.multiply_exp(alone_[k].log_det) : product.multiply(in_lanes_[k].det);
  }
  /// ln|det| of that map from Liouville's identity.
  double liouville(std::size_t k) const { return system_ ? alone_[k].liouville : in_lanes_[k].liouville; }
  /// Transition::lost.
  int lost(std::size_t k) const { return system_ ? alone_[k].lost : 0; }
  /// Whether it was carried by a Propagator: alone, or because the lanes left it to one.
  bool by_propagator(std::size_t k) const { return system_ || in_lanes_[k].by_propagator; }
  /// Impacts and entries into contact.
  int impacts(std::size_t k) const { return system_ ? contacts_among(alone_[k].event_sequence, *system_) : in_lanes_[k].impacts; }
  /// Of the period of an autonomous system; of a forced one it may be 0.
  double duration(std::size_t k) const { return system_ ? alone_[k].duration : 0.0; }

 private:
  std::span<const PeriodResult> in_lanes_;
  std::span<const Transition> alone_;
  const HybridSystem* system_ = nullptr;  ///< null: in lanes
};

/// Appends the states at the ends of the periods from number `begin` on, up to the end of the motion.
inline void append_states(const CarriedPeriods& periods, std::size_t begin, std::vector<Vector>& states) {
  constexpr Eigen::Index in_lanes = 2;  // by a Propagator, state() sets the size
  for (std::size_t k = begin; k < periods.size() && periods.termination(k) == Termination::time; ++k)
    periods.state(k, states.emplace_back(in_lanes));
}

/// Those of several motions, the same number of each.
class CarriedMotions {
 public:
  CarriedMotions(CarriedPeriods all, std::size_t periods) : all_(all), periods_(periods) {}
  CarriedPeriods of(std::size_t motion) const { return all_.part(motion * periods_, periods_); }

 private:
  CarriedPeriods all_;
  std::size_t periods_;
};

}  // namespace graze
