// SPDX-License-Identifier: GPL-3.0-or-later
// Attractor: what a motion settles on, and its exponents.
//
// Periodic is what Newton's method proves: the settled state is near a stable orbit, and goes on coming closer at the rate of its
// multipliers. Its exponents are then ln|mu_i| / (n T) to all digits, and the time average stands beside them. Chaotic: the first
// exponent is positive by several standard errors, and the tangent has grown by more than shear makes it. Else undecided.
//
// Of an autonomous system all periods are returns (returns_of), and the states are those right behind them.
//
// Where nothing dissipates there are no attractors. What a motion is by itself is then told beside its type: on or next to an
// elliptic orbit (neutral: periodic), on an island (quasi-periodic: its type is undecided), in the chaotic sea.
#pragma once

#include <graze/floquet/exponents/lyapunov.hpp>
#include <graze/floquet/orbit/periodic_orbit.hpp>

#include <complex>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace graze {

enum class AttractorType { undecided, periodic, chaotic };

/// "undecided", "periodic", "chaotic".
std::string_view attractor_type_name(AttractorType type);

enum class ConservativeMotion { unknown, neutral, island, chaotic_sea };

/// "undecided", "neutral", "island", "chaotic sea".
std::string_view conservative_motion_name(ConservativeMotion motion);

struct AttractorOptions {
  int transient = 1000;  ///< forcing periods
  /// > 0: for many attractors in little time. A stable orbit is then looked for already during the transient, where the motion
  /// returns this closely relative to 1 + |x|; the same proof by Newton's method ends it. Newton's method, which costs most where
  /// there is nothing to find, is tried for the three closest returns only, within twenty times this distance. And an average
  /// that stopped as soon as it was positive has to be confirmed by a second one, if it took fewer periods than confirmed_below.
  double recurrence = 0.0;
  std::int64_t confirmed_below = std::numeric_limits<std::int64_t>::max();
  int max_period = 64;          ///< longest period that is recognised (with `recurrence`: beyond 64 once the motion has settled)
  double significance = 5.0;    ///< standard errors by which the first exponent must exceed zero in chaos
  int periods_on_orbit = 2000;  ///< of the time average on a periodic attractor; 0: none
  LyapunovOptions lyapunov = {};
};

struct Attractor {
  AttractorType type = AttractorType::undecided;
  int period = 0, impacts = 0;  ///< n and p of a periodic one
  int isolated_impacts = 0;     ///< as in PeriodicOrbit
  bool rests = false;           ///< likewise
  double duration = 0.0;        ///< of a periodic one of an autonomous system: the time of its n returns
  bool conservative = false;    ///< Liouville's sum is zero along the motion; then it is of this kind:
  ConservativeMotion motion = ConservativeMotion::unknown;
  Vector state;                                   ///< on it, at forcing phase 0
  std::vector<std::complex<double>> multipliers;  ///< of a periodic one
  /// In full. Null where there is none, or no more (there may be a million of them), or what is above is all that was kept.
  std::shared_ptr<const PeriodicOrbit> orbit;
  std::vector<double> exponents, standard_errors;  ///< of a periodic one from its multipliers, without error
  LyapunovSpectrum time_average;
  Termination termination = Termination::failed;  ///< of the transient; time: all is well
};

/// The attractor reached from `start` at forcing phase 0. @throws std::invalid_argument as lyapunov_spectrum does.
Attractor find_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options = {});

/// Its two halves. The first lets the transient die out, and knows a stable orbit by Newton's method; the second takes the time
/// average from the state reached, looks for an orbit once more (what looked like chaos may have been a long transient), goes on
/// where the motion lingers (laminar_phase.hpp), and tells chaotic from undecided.
Attractor approach_attractor(const HybridSystem& system, const Vector& p, const Vector& start,
                             const AttractorOptions& options = {});
void average_on_attractor(const HybridSystem& system, const Vector& p, Attractor& attractor,
                          const AttractorOptions& options = {});

/// Makes it the periodic attractor that a stable orbit is.
void settle_on(Attractor& attractor, PeriodicOrbit orbit);
/// The same, without the orbit in full.
void describe_orbit(Attractor& attractor, const PeriodicOrbit& orbit);

/// find_attractor from each start, where options.recurrence > 0 and options.periods_on_orbit = 0 side by side in SIMD lanes, if
/// they know the oscillator; else one after the other.
std::vector<Attractor> find_each_attractor(const HybridSystem& system, const std::vector<AverageStart>& starts,
                                           const AttractorOptions& options = {});

}  // namespace graze
