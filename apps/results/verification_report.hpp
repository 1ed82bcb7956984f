// SPDX-License-Identifier: GPL-3.0-or-later
// Report of `graze verify`: each orbit, and for each check the largest disagreement among all orbits.
#pragma once

#include <graze/apps/text/column.hpp>

#include <graze/floquet/verify/hard_limit.hpp>

#include <optional>
#include <string>
#include <vector>

namespace graze::apps {

/// One orbit at one parameter value, and the results of its checks.
struct Verification {
  double value = 0.0;
  VerifiedOrbit verified;
  std::optional<HardLimit> hard;
  std::vector<OrbitCheck> checks;  ///< of both
  bool agrees() const;
};

/// The worst result of one check, in units of its bound; `at` is its index in the list.
struct Largest {
  OrbitCheck check;
  std::size_t at = 0;
};
std::vector<Largest> largest_of(const std::vector<Verification>& list);

/// The columns of the elements of "orbits" and of "largest" in graze.verify/1, and of their members.
const Columns<OrbitCheck>& verified_columns();
const Columns<StiffnessStep>& step_columns();
const Columns<RestitutionPoint>& restitution_columns();
const Columns<HardLimit>& hard_limit_columns();
const Columns<Verification>& verification_columns();
Columns<Largest> largest_columns(const std::vector<Verification>& list);  ///< `list` must outlive the columns

template <> struct JsonForm<OrbitCheck> : RecordForm<OrbitCheck, verified_columns> {};
template <> struct JsonForm<StiffnessStep> : RecordForm<StiffnessStep, step_columns> {};
template <> struct JsonForm<RestitutionPoint> : RecordForm<RestitutionPoint, restitution_columns> {};
template <> struct JsonForm<HardLimit> : RecordForm<HardLimit, hard_limit_columns> {};
template <> struct JsonForm<Verification> : RecordForm<Verification, verification_columns> {};

/// One orbit in detail: multipliers by three methods, checks, hard limit.
std::string verification_text(const Verification& verification);

/// Orbits of a range: one row each, then the largest disagreements and the verdicts.
std::string range_text(const std::vector<Verification>& list, const std::string& parameter);

/// One row per orbit and check.
Table checks_table(const std::vector<Verification>& list, const std::string& parameter);

}  // namespace graze::apps
