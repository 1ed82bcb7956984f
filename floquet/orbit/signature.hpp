// SPDX-License-Identifier: GPL-3.0-or-later
// Signature: the starting mode of an orbit and its sequence of events, in order. Prints as z = p/n.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

#include <optional>
#include <string>
#include <vector>

namespace graze {

struct Signature {
  std::size_t mode = 0;             ///< at phase 0
  std::vector<std::size_t> events;  ///< indices in HybridSystem::events, in order
  bool operator==(const Signature&) const = default;
};

/// Number of impacts (hard) or entries into contact (soft).
int impacts(const HybridSystem& system, const Signature& signature);

/// The first of these events of an orbit that does not lead to the mode in which the next one can follow (the last one: to that
/// of the first). Empty if all do: they are all events of an orbit.
std::optional<std::size_t> first_break(const HybridSystem& system, const std::vector<std::size_t>& events);

/// "p/n".
std::string label(int impacts, int period);
/// The same for an orbit that sticks, "4+∞/1": its impacts without those of complete chatters, of which there are infinitely
/// many (their computed number depends on the definition). `isolated`: PeriodicOrbit::isolated_impacts.
std::string label(int impacts, int isolated, int period);

}  // namespace graze
