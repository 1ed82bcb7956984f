// SPDX-License-Identifier: GPL-3.0-or-later
// LyapunovSpectrum: all exponents of a motion by time average, with the same flows and saltation matrices as the monodromy
// matrix.
//
//     Phi_k Q_k = Q_{k+1} R_k   (QR, every `interval` forcing periods),   lambda_i = <ln (R_k)_ii> / (interval T)
// Of an autonomous system a period is a return, after the time T_k: lambda_i = <ln (R_k)_ii> / <T_k>. One of its exponents is
// zero, that along the flow, but for what its average leaves open.
//
// (Benettin, Galgani, Giorgilli & Strelcyn, Meccanica 15 (1980) 9; Mueller 1995 for the jumps). Standard errors are those of
// batch means: the mean over a batch much longer than the correlation time is as good as independent of the next. By Liouville's
// identity the exponents' sum is known for itself; what is left between the two is given.
//
// An exponent is -infinity where the motion forgets a direction altogether (k_r = 0, sticking). Exponents per unit of
// dimensionless time.
#pragma once

#include <graze/lib/lanes/contact_table.hpp>
#include <graze/lib/motion/transition.hpp>

#include <functional>

namespace graze {

enum class LyapunovStop {
  not_run,
  standard_error,  ///< every standard error is below the bound, and the first exponent's sign is known if that was asked for
  change,          ///< the source's rule: all exponents changed by less than LyapunovOptions::change
  budget,          ///< max_periods were carried out
  interrupted,
  failed  ///< the motion could not be carried on; see LyapunovSpectrum::termination
};

std::string_view lyapunov_stop_text(LyapunovStop reason);

/// A motion to be averaged over.
struct AverageStart {
  Vector p;
  Vector state;  ///< at forcing phase 0
};

struct LyapunovOptions {
  int interval = 1;  ///< forcing periods between two orthonormalisations
  /// > 1: averages over so many motions on the attractor side by side, in SIMD lanes, where they know the oscillator.
  int motions = 1;
  std::int64_t aligning = 0;     ///< forcing periods carried first, whose growth is not counted: the tangent vectors align
  double standard_error = 3e-4;  ///< bound, for all exponents; 0: the budget is used up
  double significance = 0.0;     ///< > 0: goes on until the first exponent also differs from zero by so many standard errors
  double change = 0.0;           ///< > 0: stop where all exponents change by less than this from one interval to the next
  std::int64_t min_periods = 2000;
  std::int64_t max_periods = 200000;  ///< of all motions together, as min_periods
  FlowOptions flow = {};
  /// With several motions: those are carried on all threads of the caller's arena (oneTBB; so is what is done in lanes to tell an
  /// attractor), and contacts are looked up in a table of these parameters, made before. The result does not depend on the
  /// former, and on the latter by its errors.
  bool all_threads = false;
  const ContactTable* table = nullptr;
  std::function<bool()> cancelled = {};  ///< asked once per interval
  std::function<void(std::int64_t periods)> progress = {};
};

/// @throws std::invalid_argument for options out of range.
void validate(const LyapunovOptions& options);

struct LyapunovSpectrum {
  LyapunovStop stop = LyapunovStop::not_run;
  Termination termination = Termination::failed;  ///< of the last period carried out
  std::vector<double> exponents;                  ///< by size, largest first
  std::vector<double> standard_errors;            ///< of each
  std::vector<double> correlation_times;          ///< of each one's growth, in forcing periods (1/2 for independent periods)
  double kaplan_yorke = 0.0;                      ///< dimension j + (lambda_1 + ... + lambda_j) / |lambda_{j+1}|
  double liouville_residual = -1.0;               ///< largest |sum ln R_ii - Liouville's identity| per period; -1: not applicable
  double log_growth = 0.0;  ///< ln of what a tangent vector has grown by along a motion: the mean of the motions
  double log_volume = 0.0;  ///< Liouville's sum along a motion, likewise: exactly zero where nothing dissipates
  std::int64_t periods = 0;
  double duration = 0.0;       ///< of an autonomous motion: the time that these periods took
  std::int64_t impacts = 0;    ///< impacts and entries into contact on the way
  Vector state;                ///< at forcing phase 0, at the end
  std::vector<Vector> others;  ///< of the motions beside it (LyapunovOptions::motions), likewise
  /// Volumes stay as they are along the motion: nothing attracts it, and it attracts nothing.
  bool conservative() const { return periods > 0 && log_volume == 0.0; }
  /// Of each motion.
  std::int64_t periods_each() const { return periods / static_cast<std::int64_t>(1 + others.size()); }
  bool converged() const { return stop == LyapunovStop::standard_error || stop == LyapunovStop::change; }
};

/// The spectrum along the motion from `state` at forcing phase 0 (no transient is taken off here).
/// @throws std::invalid_argument for an inadmissible start, or options out of range.
LyapunovSpectrum lyapunov_spectrum(const HybridSystem& system, const Vector& p, const Vector& state,
                                   const LyapunovOptions& options = {});

/// Time of a period of the motion that was averaged: the forcing period, or the mean time of its returns.
double period_time(const HybridSystem& system, const Vector& p, const LyapunovSpectrum& average);

/// Kaplan and Yorke's dimension of exponents in order: 0 if the first is negative.
double kaplan_yorke_dimension(const std::vector<double>& exponents);

}  // namespace graze
