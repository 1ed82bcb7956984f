// SPDX-License-Identifier: GPL-3.0-or-later
// Input and output of the lanes: plain numbers, because code compiled for other processors may share nothing else with the rest
// of the program.
#pragma once

#include <graze/lib/system/hertz_contact.hpp>
#include <graze/lib/system/termination.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace graze::lanes {

/// Coefficients of a motion. The flight is x'' + 2 damping x' + stiffness x = amplitude cos(frequency t) + constant,
/// underdamped, with the particular solution cosine cos + sine sin + offset and rate^2 = stiffness - damping^2. The barrier is
/// at its right. A contact with a linear elastic stop is a flight of -x (side -1) with its own coefficients.
enum Coefficient : std::size_t {
  damping,
  rate,
  stiffness,
  frequency,
  amplitude,
  constant,
  cosine,
  sine,
  offset,
  root_k,        ///< square root of the stiffness
  inverse_rate,  ///< 1 / rate
  forced1,       ///< bound of the first derivative of the particular solution
  forced6,       ///< and of its sixth derivative
  barrier,
  side,             ///< 1; or -1: coefficients of -x
  slowest_impact,   ///< lowest speed of impact and of departure; slower ones are given up, because their rounding matters
  shortest_flight,  ///< shortest flight off the barrier; shorter ones are given up
  period,
  cells,  ///< cells of a period (Grid): their number, their length and its inverse
  cell,
  inverse_cell,
  restitution,
  rebound_volume,  ///< ln|det| of the saltation matrix of an impact with restitution
  contact_stiffness,
  contact_damping,
  cubic,   ///< beta: beta x^3 is added to the left side
  cell_p,  ///< closed-form flight: factors of P, Q (Field) and of the forcing's phase (c, s) in x one cell later
  cell_q,
  cell_c,
  cell_s,
  coefficients
};
using Coefficients = std::array<double, coefficients>;

/// A forcing period divided into cells of equal length, in which no angle turns by more than `widest_cell`, with tabulated
/// values at the points between them.
inline constexpr double widest_cell = 0.45;
inline constexpr std::size_t points_ahead = 24;
struct alignas(64) Grid {
  std::array<double, points_ahead> turn_c{}, turn_s{};  ///< after k cells: e^(-damping t) (cos, sin)(rate t)
  const double* forced = nullptr;                       ///< position of the particular solution; beyond the period: infinity
  const double* phase_c = nullptr;                      ///< cosine and sine of the forcing's phase
  const double* phase_s = nullptr;
};

struct ContactPieces;

/// Histogram of the speeds of impacts and of entries into contact. Band k counts speeds from 2^k to 2^(k + 1), k from `lowest`
/// on; speeds beyond the range count in the first or the last band.
struct SpeedHistogram {
  static constexpr std::int64_t lowest = -12, count = 20;
  std::array<std::int64_t, count> of_band{};
};

/// Recorder of the speeds of impacts and of entries into contact. The speeds of a period that is given up are overwritten.
struct SpeedRecorder {
  void (*add)(SpeedRecorder& notes, double speed) = nullptr;  ///< stores a speed as number `count`
  std::size_t count = 0, before = 0;                          ///< number of speeds now, and at the start of the period
};

/// Result of one forcing period of one motion.
struct Period {
  double x = 0.0, v = 0.0;      ///< at its end
  std::array<double, 4> Phi{};  ///< row by row, if asked for
  double det = 0.0;             ///< of Phi, if asked for, factor by factor; NaN if it is lost to cancellation
  double liouville = 0.0;       ///< ln|det Phi| from Liouville's identity, if Phi is asked for
  std::int32_t impacts = 0;     ///< impacts and entries into contact
  Termination termination = Termination::failed;
  bool by_propagator = false;  ///< the lanes left it to the Propagator
};

/// States (x0 + x, v0 + v) with xx x^2 + xv x v + vv v^2 <= 1.
struct Ellipse {
  double x0 = 0.0, v0 = 0.0, xx = 0.0, xv = 0.0, vv = 0.0;
};

/// Observer of a motion. Called after the periods that end in an ellipse of the job, those with number `next` (counted from 1)
/// or higher, and those that the lanes gave up; returns whether the motion continues.
struct PeriodObserver {
  bool (*see)(PeriodObserver& watch, std::size_t number, const Period& period) = nullptr;
  std::size_t next = 1;
};

struct Motion {
  double x = 0.0, v = 0.0;
  std::size_t parameters = 0;  ///< index of the parameter set
  const Coefficients* coefficients = nullptr;
  const Grid* grid = nullptr;
  const Coefficients* pressed = nullptr;  ///< coefficients of -x in contact with a linear elastic stop
  const Grid* pressed_grid = nullptr;
  std::size_t periods = 1;               ///< to be carried
  Period* results = nullptr;             ///< one for each period; of an observed motion one, for the last
  const ContactPieces* table = nullptr;  ///< table of contacts; may be null
  SpeedHistogram* met = nullptr;         ///< histogram for the speeds of entry; may be null
  SpeedRecorder* notes = nullptr;        ///< may be null
  PeriodObserver* watch = nullptr;       ///< may be null

  /// The result of a period.
  Period& result(std::size_t of_period) const { return results[watch ? 0 : of_period]; }
};

enum class Law { restitution, hertz, linear_elastic };

/// A motion with more impacts in a period is given up: the Propagator decides whether they are too many.
inline constexpr int most_impacts = 4000;

/// Progress of a motion.
struct Carried {
  std::size_t periods = 0;
  /// The next period failed, or was given up (an impact too weak for the lanes, the motion too close to the barrier) without a
  /// Job::carry_given_up to carry it.
  bool failed = false;
};

struct Job {
  Law law = Law::restitution;
  bool cubic = false;  ///< the flights have beta x^3, and no closed form; no tables
  double tolerance = 1e-13;
  std::size_t max_steps = 0;  ///< of a Hertz contact or a flight with beta x^3; after more a motion is given up
  bool tangent = true;
  const Motion* motions = nullptr;
  std::size_t count = 0;
  Carried* carried = nullptr;         ///< progress of each motion
  const Ellipse* ellipses = nullptr;  ///< Motion::watch is called after periods that end in one
  std::size_t ellipse_count = 0;
  /// If the queue is empty and fewer than 7/8 of the lanes are busy, the remaining motions stop at the end of their current
  /// period. (Motions with a table of contacts continue: their results depend on where they are started again.)
  bool while_full = false;
  /// Called when a motion has finished or stopped, with its number and the number of motions taken. It may add motions (without
  /// tables and histograms) to those not taken, if the arrays `motions` and `carried` stay where they are; returns the new
  /// number of motions. May be null.
  std::size_t (*more)(void* whom, std::size_t number, std::size_t taken) = nullptr;
  /// Carries a period that the lanes give up and stores its result; returns whether the motion continues. May be null.
  bool (*carry_given_up)(void* whom, const Job& job, const Motion& motion, std::size_t period) = nullptr;
  void* whom = nullptr;
};

/// A Hertz contact: the forcing's phase (c, s) and the speed at entry, and the longest time to follow it; and its state at the
/// end.
struct ContactEntry {
  double c = 1.0, s = 0.0, v = 0.0, longest = 0.0;
};
struct ContactExit {
  double duration = 0.0, y = 0.0, v = 0.0, divergence = 0.0;
  std::array<double, 4> Phi{};  ///< at fixed times, row by row
  bool ended = false;           ///< false: not within ContactEntry::longest, or not carried (NaN)
};
struct ContactJob {
  const Coefficients* coefficients = nullptr;
  double tolerance = 1e-13;
  std::size_t max_steps = 0;  ///< of a contact; one with more is not carried
  const ContactEntry* entries = nullptr;
  std::size_t count = 0;
  ContactExit* exits = nullptr;
};

namespace plain {  // for every processor of the architecture, in one lane and in two
void carry_one(const Job& job);
void carry_two(const Job& job);
void contacts_one(const ContactJob& job);
void contacts_two(const ContactJob& job);
}  // namespace plain
namespace fused {  // with fused multiply-add; in four lanes with AVX2, in eight with AVX-512
void carry_one(const Job& job);
void carry_two(const Job& job);
void carry_four(const Job& job);
void carry_eight(const Job& job);
void contacts_one(const ContactJob& job);
void contacts_two(const ContactJob& job);
void contacts_four(const ContactJob& job);
void contacts_eight(const ContactJob& job);
}  // namespace fused

}  // namespace graze::lanes
