// SPDX-License-Identifier: GPL-3.0-or-later
// SettlingChain: the stable orbits on which motions settle at the values of a parameter, each motion from the state reached at
// the value before. These orbits are seeds of a skeleton.
#pragma once

#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/follow/row.hpp>
#include <graze/floquet/orbit/shooting.hpp>

#include <functional>
#include <utility>
#include <vector>

namespace graze {

class SettlingChain : public RowChain {
 public:
  /// `parameters`: at each value. `rest`: start of the first motion, and of those for which the state before does not serve.
  /// `settling`: in fast mode, because chaotic transients are long. `shooting`: of the proof of an orbit that lanes have found.
  SettlingChain(const SharedSystem& system, std::vector<Vector> parameters, Vector rest, AttractorOptions settling,
                ShootingOptions shooting)
      : system_(system), parameters_(std::move(parameters)), rest_(std::move(rest)), settling_(std::move(settling)),
        shooting_(std::move(shooting)) {}

  std::size_t size() const override { return parameters_.size(); }
  std::size_t stretch() const override { return size(); }
  /// The orbit of a periodic point is whole.
  MotionTask<Found> find(TaskSlot& slot, Begin begin, std::function<bool()> cancelled,
                         std::function<void(const Vector& state)> publish) const override;

 private:
  SharedSystem system_;
  std::vector<Vector> parameters_;
  Vector rest_;
  AttractorOptions settling_;
  ShootingOptions shooting_;
};

}  // namespace graze
