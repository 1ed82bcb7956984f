// SPDX-License-Identifier: GPL-3.0-or-later
// What `graze verify` says: of each orbit, and of the largest disagreement of each check among all of them.
#pragma once

#include <graze/apps/text/json.hpp>
#include <graze/apps/text/table.hpp>

#include <graze/floquet/verify/hard_limit.hpp>

#include <optional>
#include <string>
#include <vector>

namespace graze::apps {

/// One orbit at one value of the parameter, and what became of its checks.
struct Verification {
  double value = 0.0;
  VerifiedOrbit verified;
  std::optional<HardLimit> hard;
  std::vector<OrbitCheck> checks;  ///< of both
  bool agrees() const;
};

/// The worst of one check, in units of its bound; `at` is an index in the list.
struct Largest {
  OrbitCheck check;
  std::size_t at = 0;
};
std::vector<Largest> largest_of(const std::vector<Verification>& list);

/// As an element of "orbits" in graze.verify/1.
Json verification_json(const Verification& verification);
Json largest_json(const std::vector<Largest>& largest, const std::vector<Verification>& list);

/// One orbit at length: multipliers by three ways, checks, hard limit.
std::string verification_text(const Verification& verification);

/// Orbits of a range: a row each, the largest disagreements below, and the verdicts.
std::string range_text(const std::vector<Verification>& list, const std::string& parameter);

/// One row per orbit and check.
Table checks_table(const std::vector<Verification>& list, const std::string& parameter);

}  // namespace graze::apps
