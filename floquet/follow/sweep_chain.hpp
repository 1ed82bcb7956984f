// SPDX-License-Identifier: GPL-3.0-or-later
// SweepChain: how the values of one direction of a sweep are computed. The motion continues from its state at the previous
// value. If it has not been recognised as periodic, its state is published early; classifying it takes long and proceeds in
// parallel with the following values. On a smooth branch the orbits of a block of values are predicted.
#pragma once

#include <graze/floquet/follow/row.hpp>

#include <functional>
#include <vector>

namespace graze {

class SweepChain : public RowChain {
 public:
  SweepChain(const SharedSystem& system, Vector p, Vector start, SweepOptions options, SweepDirection direction);

  double value(std::size_t number) const { return values_[number]; }

  std::size_t size() const override { return values_.size(); }
  std::size_t stretch() const override { return Row::stretch_of(size()); }
  MotionTask<Found> find(TaskSlot& slot, Begin begin, std::function<bool()> cancelled,
                         std::function<void(const Vector& state)> publish) const override;
  /// Never with a time average on orbits, which a prediction lacks; nor without forcing, where the states of orbits lie on a
  /// guard, which moves with the parameter.
  bool predicts() const override { return options_.attractor.periods_on_orbit == 0 && is_forced(system_); }
  std::vector<PredictedOrbit> predict(std::size_t begin, std::size_t end,
                                      const std::vector<std::vector<Vector>>& before) const override;

 private:
  Vector parameters(std::size_t number) const;
  Vector off_guards(const Vector& p, const Vector& state) const;
  Vector start_of(const Begin& begin, const Vector& p) const;
  MotionTask<RowPoint> follow(TaskSlot& slot, const Begin& begin, AttractorOptions finding,
                              const std::function<void(const Vector& state)>& publish) const;
  MotionTask<std::optional<Vector>> carry_on(TaskSlot& slot, const Vector& p, const Vector& state, int periods) const;

  SharedSystem system_;
  SweepOptions options_;
  std::size_t parameter_;
  Vector p_, start_;
  std::vector<double> values_;
};

/// Records the states and impact speeds of an attractor: those of its orbit, or those of `samples` periods from its state.
MotionTask<> sample_attractor(TaskSlot& slot, const Vector& p, int samples, FollowedAttractor& at);

}  // namespace graze
