// SPDX-License-Identifier: GPL-3.0-or-later
// SharedSystem: a hybrid system that is held by the objects that compute with it. It is made from a system, of which it takes a
// copy (a few microseconds), or takes it over if it is a temporary. Copies of a SharedSystem share one system, which does not
// change and lives as long as any of them; threads may share it.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

#include <memory>
#include <utility>

namespace graze {

class SharedSystem {
 public:
  // Conversions in both directions: a constructor that holds a system is called with a HybridSystem, a function that reads one
  // with either.
  SharedSystem(HybridSystem system)  // NOLINT(google-explicit-constructor,hicpp-explicit-conversions)
      : system_(std::make_shared<const HybridSystem>(std::move(system))) {}
  operator const HybridSystem&() const { return *system_; }  // NOLINT(google-explicit-constructor,hicpp-explicit-conversions)

  const HybridSystem& operator*() const { return *system_; }
  const HybridSystem* operator->() const { return system_.get(); }

 private:
  std::shared_ptr<const HybridSystem> system_;
};

}  // namespace graze
