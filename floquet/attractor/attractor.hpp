// SPDX-License-Identifier: GPL-3.0-or-later
// Attractor: the attractor that a motion reaches, and its Lyapunov exponents.
//
// Periodic: Newton's method finds a stable orbit near the settled state, and the motion keeps approaching it at the rate of the
// orbit's multipliers. The exponents are then ln|mu_i| / (n T) to full precision; the time average is given beside them.
// Chaotic: the first exponent is positive by several standard errors, and the tangent has grown more than shear can make it
// grow. Otherwise undecided.
//
// For an autonomous system all periods are returns (returns_of), and the states are those immediately after a return.
//
// A conservative system has no attractors. The kind of motion is then given beside the type: on or next to an elliptic orbit
// (neutral: periodic), on an island (quasi-periodic: its type is undecided), or in the chaotic sea.
#pragma once

#include <graze/floquet/exponents/lyapunov.hpp>
#include <graze/floquet/orbit/stable_orbit.hpp>

#include <complex>
#include <cstdint>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

namespace graze {

enum class AttractorType { undecided, periodic, chaotic };

/// "undecided", "periodic", "chaotic".
std::string_view attractor_type_name(AttractorType type);

enum class ConservativeMotion { unknown, neutral, island, chaotic_sea };

/// "undecided", "neutral", "island", "chaotic sea".
std::string_view conservative_motion_name(ConservativeMotion motion);

/// AttractorOptions::recurrence of sweeps, maps and searches. Chaos returns this closely only rarely. A motion that settles does
/// so long before its distance from the orbit is rounding, and Newton's method then converges from there.
inline constexpr double usual_recurrence = 1e-4;

struct AttractorOptions {
  int transient = 1000;  ///< forcing periods
  /// > 0: fast mode for many attractors. The search for a stable orbit then begins during the transient, when the motion
  /// returns this closely relative to 1 + |x|; the same proof by Newton's method ends the transient. Newton's method is most
  /// expensive where there is no orbit to find. It is therefore tried only for the three closest returns, within twenty times
  /// this distance. An average that stopped as soon as it was positive needs confirmation by a second one if it took fewer
  /// periods than confirmed_below.
  double recurrence = 0.0;
  std::int64_t confirmed_below = std::numeric_limits<std::int64_t>::max();
  int max_period = 64;          ///< longest period recognised (with `recurrence`: beyond 64 only after settling)
  double significance = 5.0;    ///< standard errors by which the first exponent must exceed zero in chaos
  int periods_on_orbit = 2000;  ///< length of the time average on a periodic attractor; 0: none
  LyapunovOptions lyapunov = {};
};

struct Attractor {
  AttractorType type = AttractorType::undecided;
  int period = 0, impacts = 0;  ///< n and p of a periodic attractor
  int isolated_impacts = 0;     ///< as in PeriodicOrbit
  bool rests = false;           ///< as in PeriodicOrbit
  double duration = 0.0;        ///< periodic attractor of an autonomous system: time of its n returns
  bool conservative = false;    ///< Liouville's sum is zero along the motion; `motion` is then its kind
  ConservativeMotion motion = ConservativeMotion::unknown;
  Vector state;                                   ///< on the attractor, at forcing phase 0
  std::vector<std::complex<double>> multipliers;  ///< of a periodic attractor
  /// The orbit. Null if there is none, or if only the fields above were kept (there may be a million attractors).
  std::shared_ptr<const StableOrbit> orbit;
  std::vector<double> exponents, standard_errors;  ///< periodic: from the multipliers, without error
  LyapunovSpectrum time_average;
  Termination termination = Termination::failed;  ///< of the transient; time: success
};

/// The attractor reached from `start` at forcing phase 0. @throws std::invalid_argument as lyapunov_spectrum does.
Attractor find_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options = {});

/// The two halves of find_attractor. The first runs the transient and detects a stable orbit with Newton's method. The second
/// takes the time average from the state reached and looks for an orbit again, because apparent chaos may have been a long
/// transient. It continues a motion in a laminar phase (laminar_phase.hpp), and finally decides between chaotic and undecided.
Attractor approach_attractor(const HybridSystem& system, const Vector& p, const Vector& start,
                             const AttractorOptions& options = {});
void average_on_attractor(const HybridSystem& system, const Vector& p, Attractor& attractor,
                          const AttractorOptions& options = {});

/// Makes `attractor` the periodic attractor that a stable orbit is.
void settle_on(Attractor& attractor, StableOrbit orbit);
/// The same without storing the orbit.
void describe_orbit(Attractor& attractor, const StableOrbit& orbit);

}  // namespace graze
