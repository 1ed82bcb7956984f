// SPDX-License-Identifier: GPL-3.0-or-later
// Reproduction: every figure of a published study, recomputed, with the data of its pictures.
#pragma once

#include <graze/apps/published/claims.hpp>
#include <graze/apps/published/exponents.hpp>
#include <graze/apps/published/windows.hpp>

#include <functional>
#include <string>
#include <vector>

namespace graze::apps {

struct ReproductionOptions {
  int threads = 1;
  double sweep_error = 3e-4;  ///< standard error of the exponents along a diagram
  int sweep_periods = 200000;
  int samples = 300;  ///< stroboscopic states of a motion in a diagram that is not periodic
  ExponentsOptions exponents = {};
  bool claims = true;
  std::function<bool()> cancelled = {};
  /// Called by one thread at a time: the current item, and the completed share of the whole.
  std::function<void(const std::string& item, double fraction)> progress = {};
};

struct Reproduction {
  std::vector<Comparison> rows;  ///< points, exponents, windows; in the order of the file
  std::vector<Claim> claims;
  std::vector<SweptDiagram> diagrams;
  bool complete = false;
};

/// `so_far`: the results of an earlier run with the same options, which are kept and continued. @throws std::invalid_argument
/// for a file with unknown names.
Reproduction reproduce(const Published& published, const ReproductionOptions& options, const Reproduction& so_far = {});

}  // namespace graze::apps
