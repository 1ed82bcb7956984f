// SPDX-License-Identifier: GPL-3.0-or-later
// Reproduction: every figure of a published study computed anew, and what its pictures are drawn from.
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
  /// By one thread at a time: what is being computed, and what share of the whole is done.
  std::function<void(const std::string& what, double fraction)> progress = {};
};

struct Reproduction {
  std::vector<Comparison> rows;  ///< points, exponents, windows; in the order of the file
  std::vector<Claim> claims;
  std::vector<SweptDiagram> diagrams;
  bool complete = false;
};

/// `so_far`: what an earlier run of the same options has left; it is kept, and gone on with.
/// @throws std::invalid_argument for a file that names what there is not.
Reproduction reproduce(const Published& published, const ReproductionOptions& options, const Reproduction& so_far = {});

}  // namespace graze::apps
