// SPDX-License-Identifier: GPL-3.0-or-later
// LyapunovSpectrum: all exponents of a motion by time average, with the same flows and saltation matrices as the monodromy
// matrix.
//
//     Phi_k Q_k = Q_{k+1} R_k   (QR, every `interval` forcing periods),   lambda_i = <ln (R_k)_ii> / (interval T)
//
// For an autonomous system a period is a return, with time T_k: lambda_i = <ln (R_k)_ii> / <T_k>. One of its exponents, that
// along the flow, is zero within the error of the average.
//
// Source: Benettin, Galgani, Giorgilli & Strelcyn, Meccanica 15 (1980) 9; Mueller 1995 for the jumps. Standard errors are those
// of batch means: the mean over a batch much longer than the correlation time is practically independent of the next one.
// Liouville's identity gives the sum of the exponents independently; the difference is reported.
//
// An exponent is -infinity where the motion loses a direction altogether (k_r = 0, sticking). Exponents are per unit of
// dimensionless time.
#pragma once

#include <graze/lib/motion/transition.hpp>

#include <functional>
#include <memory>

namespace graze {

class ContactTable;

enum class LyapunovStop {
  not_run,
  standard_error,  ///< all are below the bound, and the first exponent's sign is known if required
  change,          ///< the source's rule: all exponents changed by less than LyapunovOptions::change
  budget,          ///< max_periods were carried out
  interrupted,
  failed  ///< the motion could not be continued; see LyapunovSpectrum::termination
};

std::string_view lyapunov_stop_text(LyapunovStop reason);

/// Start of a motion to be averaged.
struct AverageStart {
  Vector p;
  Vector state;  ///< at forcing phase 0
};

struct LyapunovOptions {
  int interval = 1;  ///< forcing periods between two orthonormalisations
  /// > 1: averages over this many motions on the attractor, run together in SIMD lanes if these support the system, or else each
  /// by a Propagator.
  int motions = 1;
  std::int64_t aligning = 0;     ///< forcing periods without averaging at the start: the tangent vectors align
  double standard_error = 3e-4;  ///< bound for all exponents; 0: the average uses the whole budget
  double significance = 0.0;     ///< > 0: the first exponent must also differ from zero by this many standard errors
  double change = 0.0;           ///< > 0: stops when all exponents change by less than this from one interval to the next
  std::int64_t min_periods = 2000;
  std::int64_t max_periods = 200000;  ///< total over all motions, as min_periods
  FlowOptions flow = {};
  /// For motions > 1. all_threads: the motions, and work that classifies an attractor, use all threads of the caller's
  /// arena (oneTBB); the result does not depend on this. table: contacts come from this precomputed table for the same
  /// parameters; the result changes by the errors of the table.
  bool all_threads = false;
  std::shared_ptr<const ContactTable> table = nullptr;
  std::function<bool()> cancelled =
      {};  ///< called before each period, or before every 8 of several motions; in lanes every 32 to 256 periods
  std::function<void(std::int64_t periods)> progress = {};
};

/// @throws std::invalid_argument for options out of range.
void validate(const LyapunovOptions& options);

struct LyapunovSpectrum {
  LyapunovStop stop = LyapunovStop::not_run;
  Termination termination = Termination::failed;  ///< of the last period carried out
  std::vector<double> exponents;                  ///< largest first
  std::vector<double> standard_errors;            ///< of each
  std::vector<double> correlation_times;  ///< of the growth in each direction, in forcing periods (1/2 for independent periods)
  double kaplan_yorke = 0.0;              ///< dimension j + (lambda_1 + ... + lambda_j) / |lambda_{j+1}|
  double liouville_residual = -1.0;       ///< largest |sum ln R_ii - Liouville's identity| per period; -1: not applicable
  double log_growth = 0.0;                ///< ln of the growth of a tangent vector along a motion, averaged over the motions
  double log_volume = 0.0;                ///< Liouville's sum along a motion, likewise: exactly zero for a conservative system
  std::int64_t periods = 0;
  double duration = 0.0;       ///< of an autonomous motion: total time of these periods
  std::int64_t impacts = 0;    ///< impacts and entries into contact in these periods
  Vector state;                ///< final state at forcing phase 0
  std::vector<Vector> others;  ///< final states of the other motions (LyapunovOptions::motions)
  /// Volumes are preserved along the motion: nothing attracts it, and it attracts nothing.
  bool conservative() const { return periods > 0 && log_volume == 0.0; }
  /// Periods per motion.
  std::int64_t periods_each() const { return periods / static_cast<std::int64_t>(1 + others.size()); }
  bool converged() const { return stop == LyapunovStop::standard_error || stop == LyapunovStop::change; }
};

/// The spectrum along the motion from `state` at forcing phase 0 (without a transient).
LyapunovSpectrum lyapunov_spectrum(const HybridSystem& system, const Vector& p, const Vector& state,
                                   const LyapunovOptions& options = {});

/// Why the average ended, in words. An autonomous motion has returns in place of forcing periods.
std::string_view lyapunov_stop_text(const LyapunovSpectrum& average);

/// Mean time of a period of the averaged motion: the forcing period, or the mean time between its returns.
double period_time(const HybridSystem& system, const Vector& p, const LyapunovSpectrum& average);

/// Kaplan-Yorke dimension of exponents in decreasing order: 0 if the first is negative.
double kaplan_yorke_dimension(const std::vector<double>& exponents);

}  // namespace graze
