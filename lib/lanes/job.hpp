// SPDX-License-Identifier: GPL-3.0-or-later
// What the lanes are given and what they give back: plain numbers, since this is all that the code compiled for other processors
// may share with the rest.
#pragma once

#include <graze/lib/system/hertz_contact.hpp>
#include <graze/lib/system/termination.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace graze::lanes {

/// Coefficients of a motion. The flight is x'' + 2 damping x' + stiffness x = amplitude cos(frequency t) + constant, underdamped,
/// with the particular solution cosine cos + sine sin + offset and rate^2 = stiffness - damping^2. The barrier is at its right: a
/// contact with a linear elastic stop is a flight of -x (side -1) with coefficients of its own.
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
  root_k,        ///< of the stiffness
  inverse_rate,  ///< one over the rate
  forced1,       ///< bound of the first derivative of the particular solution
  forced6,       ///< and of the sixth
  barrier,
  side,             ///< 1, or -1: they are those of -x
  slowest_impact,   ///< and speed of departure from the barrier; slower ones are given up (their rounding wants care),
  shortest_flight,  ///< and so are shorter flights off the barrier
  period,
  cells,  ///< of a period, see Grid; their length, and one over it
  cell,
  inverse_cell,
  restitution,
  rebound_volume,  ///< ln|det| of the tangent of an impact with it
  contact_stiffness,
  contact_damping,
  cubic,   ///< beta: beta x^3 is added to the left side
  cell_p,  ///< of a flight in closed form: what x a cell later is of P, Q (Field) and of the forcing's phase
  cell_q,
  cell_c,
  cell_s,
  coefficients
};
using Coefficients = std::array<double, coefficients>;

/// A forcing period in cells of equal length, in which no angle turns by more than `widest_cell`: what the lanes know of the
/// instants between them.
inline constexpr double widest_cell = 0.45;
inline constexpr std::size_t points_ahead = 24;
struct alignas(64) Grid {
  std::array<double, points_ahead> turn_c{}, turn_s{};  ///< over k cells: e^(-damping t) (cos, sin)(rate t)
  const double* forced = nullptr;                       ///< position of the particular solution; beyond the period: infinity
  const double* phase_c = nullptr;                      ///< cosine and sine of the forcing's phase
  const double* phase_s = nullptr;
};

struct ContactPieces;

/// How many impacts and contacts began at speeds from 2^k up to twice that, k from `lowest` on (those beyond: at the ends).
struct SpeedsMet {
  static constexpr std::int64_t lowest = -12, count = 20;
  std::array<std::int64_t, count> of_band{};
};

/// Where the speeds of impacts and of entries into contact are written down. (Those of a period that is given up are not: the
/// next comes in their place.)
struct ImpactNotes {
  void (*add)(ImpactNotes& notes, double speed) = nullptr;  ///< as number `count`
  std::size_t count = 0, before = 0;                        ///< and when the period began
};

/// What one forcing period did to one motion.
struct Period {
  double x = 0.0, v = 0.0;      ///< at its end
  std::array<double, 4> Phi{};  ///< row by row, if asked for
  double det = 0.0;             ///< of Phi, if asked for, factor by factor; NaN where rounding has taken it
  double liouville = 0.0;       ///< ln|det Phi| from Liouville's identity, if Phi is asked for
  std::int32_t impacts = 0;     ///< impacts and entries into contact
  Termination termination = Termination::failed;
  bool by_propagator = false;  ///< the lanes left it to the Propagator
};

/// States (x0 + x, v0 + v) with xx x^2 + xv x v + vv v^2 <= 1.
struct Ellipse {
  double x0 = 0.0, v0 = 0.0, xx = 0.0, xv = 0.0, vv = 0.0;
};

/// Who is told of those periods of a motion that end in one of the ellipses of the job, of those numbered `next` (from 1) or
/// higher, and of those that the lanes gave up, and says whether the motion goes on.
struct PeriodWatch {
  bool (*see)(PeriodWatch& watch, std::size_t number, const Period& period) = nullptr;
  std::size_t next = 1;
};

struct Motion {
  double x = 0.0, v = 0.0;
  std::size_t parameters = 0;  ///< which set they are
  const Coefficients* coefficients = nullptr;
  const Grid* grid = nullptr;
  const Coefficients* pressed = nullptr;  ///< of -x in contact with a linear elastic stop
  const Grid* pressed_grid = nullptr;
  std::size_t periods = 1;               ///< to be carried
  Period* results = nullptr;             ///< of as many periods; of one that is watched, for the last
  const ContactPieces* table = nullptr;  ///< of contacts; may be null
  SpeedsMet* met = nullptr;              ///< what to write the speeds of entry down in; may be null
  ImpactNotes* notes = nullptr;          ///< may be null
  PeriodWatch* watch = nullptr;          ///< may be null

  /// Where a period is written down.
  Period& result(std::size_t of_period) const { return results[watch ? 0 : of_period]; }
};

enum class Law { restitution, hertz, linear_elastic };

/// A motion with more impacts in a period is given up: whether they are too many the Propagator says.
inline constexpr int most_impacts = 4000;

/// How far a motion came.
struct Carried {
  std::size_t periods = 0;
  /// The next one failed, or was given up (an impact too weak for the lanes, the motion too close to the barrier) and there was
  /// nobody to do it.
  bool failed = false;
};

struct Job {
  Law law = Law::restitution;
  bool cubic = false;  ///< the flights have beta x^3, and no closed form; no tables
  double tolerance = 1e-13;
  std::size_t max_steps = 0;  ///< of a Hertz contact; after more a motion is given up
  bool tangent = true;
  const Motion* motions = nullptr;
  std::size_t count = 0;
  Carried* carried = nullptr;         ///< of each motion
  const Ellipse* ellipses = nullptr;  ///< Motion::watch is told of periods that end there
  std::size_t ellipse_count = 0;
  /// Where motions have come to their ends, none is left to begin, and not nearly all lanes have something to do, the others
  /// end with the periods that they are at. (With a table of contacts it matters where a motion is begun anew: those go on.)
  bool while_full = false;
  /// Told of each motion that is through, or has stopped, and how many lanes have taken. It may put others among those not taken
  /// of `motions` (and of `carried`), which stay where they are, without tables and counts of speeds; says how many there are
  /// now. May be null.
  std::size_t (*more)(void* whom, std::size_t number, std::size_t taken) = nullptr;
  /// Carries a period that the lanes give up, and writes it down; says whether the motion goes on. May be null.
  bool (*do_given_up)(void* whom, const Job& job, const Motion& motion, std::size_t period) = nullptr;
  void* whom = nullptr;
};

/// A Hertz contact: forcing's phase (c, s) and speed at entry, and how long to follow it; and how it stands then.
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

namespace plain {  // what every processor of the kind has, in one lane and in two
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
