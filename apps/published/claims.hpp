// SPDX-License-Identifier: GPL-3.0-or-later
// Claims that the source makes in words, tested by a criterion that is stated with the verdict.
#pragma once

#include <graze/apps/published/comparison.hpp>
#include <graze/apps/published/published.hpp>

#include <graze/floquet/follow/sweep.hpp>

#include <functional>
#include <string>
#include <vector>

namespace graze::apps {

struct Claim {
  std::string name;       ///< for files
  std::string statement;  ///< as the source makes it
  std::string criterion;  ///< condition under which the claim counts as right
  std::string computed;
  Verdict verdict = Verdict::differs;
  Json details = Json::object();  ///< the underlying numbers, from which the picture is drawn
};

struct ClaimOptions {
  int threads = 1;
  std::function<bool()> cancelled = {};
  std::function<void(double fraction)> progress = {};
};

/// "Near grazing the undamped Hertz contact and Newton's with k_r = 1 have the same exponents": both over eta around the
/// grazing of the motion without impact.
Claim claim_of_equal_exponents(const Published& published, const std::string& soft, const std::string& hard,
                               const ClaimOptions& options);

/// "Chaos is widest at clearance r = 2": the width of the chaotic windows in eta against r.
Claim claim_of_widest_chaos(const Published& published, const std::string& system, double clearance, const ClaimOptions& options);

const Columns<Claim>& claim_columns();
template <> struct JsonForm<Claim> : RecordForm<Claim, claim_columns> {};

}  // namespace graze::apps
