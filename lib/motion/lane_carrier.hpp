// SPDX-License-Identifier: GPL-3.0-or-later
// LaneCarrier: carries many motions (different starts, different parameters) over whole forcing periods, side by side in the
// lanes of the widest SIMD registers of the processor (SSE2, AVX2 or AVX-512 on x86, detected when the program starts).
//
// The lanes support an oscillator with one barrier at its right. The oscillator is linear (underdamped, forced at no less than
// 1/286 of its undamped natural frequency) or has a cubic spring (a cantilever). The barrier is rigid with a coefficient of
// restitution, or follows Hertz's law (damped or not, k_H b_H up to 3e4), or is linear elastic (for a linear oscillator the
// same bounds then hold for the motion in contact: k_S up to about 80000 eta^2).
//
// The lanes use the formulas of LinearFlow, CubicFlow and HertzFlow, with series of their own order. The result is the same to
// the last bit for any number of lanes and, without tables of contacts, for any division of the periods between calls. Delicate
// periods go to the Propagator: a grazing, an impact slower than 1e-4, a chattering or sticking mass. The lanes therefore miss
// nothing that the Propagator would not miss. Both agree within 1e-12 (1 + |Phi|) over a period.
#pragma once

#include <graze/lib/lanes/contact_table.hpp>
#include <graze/lib/lanes/lane_width.hpp>
#include <graze/lib/motion/propagator.hpp>
#include <graze/lib/motion/transition.hpp>

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace graze {

struct MotionStart {
  std::size_t parameters = 0;  ///< index returned by add_parameters
  double x = 0.0, v = 0.0;     ///< at forcing phase 0
};

/// Result of one forcing period of a motion. Termination::time means success.
using PeriodResult = lanes::Period;

/// Speeds of impacts and of entries into contact, in the order of time.
class ImpactSpeeds : public lanes::SpeedRecorder {
 public:
  ImpactSpeeds();
  /// The recorded speeds.
  std::vector<double> list() const { return {list_.begin(), list_.begin() + static_cast<std::ptrdiff_t>(count)}; }

 private:
  std::vector<double> list_;
};

/// Adds the speeds of the impacts and entries into contact among these events.
void record_contacts(const std::vector<EventRecord>& events, lanes::SpeedRecorder& speeds);

/// Observer of one motion: called after its periods (lanes::PeriodWatch says which), also after a failed one; returns whether
/// to continue.
using PeriodObserver = lanes::PeriodObserver;
using StateEllipse = lanes::Ellipse;

/// A motion to be carried over `periods` forcing periods, with the storage for its results.
struct MotionRun {
  MotionStart start;
  std::size_t periods = 0;
  PeriodResult* results = nullptr;
  ImpactSpeeds* speeds = nullptr;  ///< speeds of its impacts and entries into contact; may be null
  std::size_t carried = 0;         ///< periods carried so far
  /// May be null. If set, `results` has one entry, for the last period, and no table is made for the motion.
  PeriodObserver* watch = nullptr;
  /// In carry_while_full: carried over all its periods at once; if it joins later, it goes ahead of the others.
  bool goes_first = false;
  /// The state after the periods carried so far.
  MotionStart now() const {
    if (carried == 0) return start;
    const PeriodResult& last = results[carried - 1];
    return {start.parameters, last.x, last.v};
  }
};

/// Supplies further runs as others finish, to keep the lanes full.
class RunSupply {
 public:
  /// Called when a run finishes, uses up its quota or stops; `periods` is the number of periods carried since the last call.
  /// The supply may let other runs, or the same one again, join (LaneCarrier::join).
  void (*through)(RunSupply& self, MotionRun& run, std::size_t periods) = nullptr;
};

class LaneCarrier {
 public:
  /// Whether the lanes support the system at these parameters with these options.
  static bool applies(const HybridSystem& system, const Vector& p, const FlowOptions& options = {});

  explicit LaneCarrier(const SharedSystem& system, const FlowOptions& options = {}, LaneWidth width = LaneWidth::widest);
  ~LaneCarrier();
  const SharedSystem& system() const { return system_; }
  const FlowOptions& options() const { return options_; }

  /// Adds a parameter set and returns its index. @throws std::invalid_argument if applies() is false, or if the contact law
  /// differs from that of the sets before.
  std::size_t add_parameters(const Vector& p);
  /// Overwrites a set that is no longer needed or was taken. @throws as add_parameters, and for an unknown index.
  void change_parameters(std::size_t parameters, const Vector& p);
  const Vector& parameters(std::size_t parameters) const;

  /// A parameter set with its tables, moved out for another LaneCarrier of the same system and options.
  class Taken;
  Taken take(std::size_t parameters);
  /// Adds a taken set at the index `place` of a set that was taken here, or as a new one; returns its index.
  std::size_t add(Taken taken, std::optional<std::size_t> place = std::nullopt);

  /// Announces that about `periods` forcing periods will be carried with a parameter set. From `periods_for_table` on, a table
  /// of its contacts pays off (Hertz's law, tolerance >= 1e-13). The table covers the speeds met in the first contacts and
  /// serves all later ones.
  void expect(std::size_t parameters, std::int64_t periods);
  /// A table costs 70 ms. It saves 0.7 us of a chaotic period at b = 0.05, eta = 0.711, and 1.5 us with the tangent: it breaks
  /// even at 100000 and 47000 periods.
  static constexpr std::int64_t periods_for_table = 100000;

  /// Whether a table is still pending. carry() checks every `periods_between_looks` periods whether it can be made.
  bool awaits_table(std::size_t parameters) const;
  static constexpr std::size_t periods_between_looks = 64;
  /// Makes a pending table if enough contacts have been met. carry_while_full makes none by itself.
  void make_pending_table(std::size_t parameters);

  /// Uses an existing table of contacts, made for the same parameters. @throws std::invalid_argument if it was
  /// made for others.
  void use(std::size_t parameters, std::shared_ptr<const ContactTable> table);
  /// The table in use, or null.
  std::shared_ptr<const ContactTable> table(std::size_t parameters) const;

  /// From now on, observers are also called after each period that ends in one of these ellipses.
  void set_reported_ellipses(std::vector<StateEllipse> ellipses) { ellipses_ = std::move(ellipses); }

  /// From now on, many motions are distributed over all threads of the caller's arena (oneTBB).
  void use_all_threads() { all_threads_ = true; }

  /// Carries each motion over `periods` forcing periods. The result of period k of motion m is at m * periods + k. A motion
  /// that cannot be carried further stops, and its remaining results have the same termination. @throws std::invalid_argument
  /// for unknown parameters.
  void carry(const std::vector<MotionStart>& starts, std::size_t periods, bool tangent, std::vector<PeriodResult>& results);
  /// The same with a number of periods for each run.
  void carry(std::span<MotionRun> runs, bool tangent);
  /// Carries each run for up to `most` periods (with a table of contacts, for all that remain) while most lanes are busy. Then
  /// the runs under way stop, each at the end of its current period. Makes no tables.
  void carry_while_full(std::span<MotionRun* const> runs, bool tangent, std::size_t most, RunSupply& supply);
  /// Lets a run join the others; to be called by the supply when it is notified. False: the run must wait for another call,
  /// because its flight is of the other kind (linear or cubic), its parameters have or await a table of contacts, or there is
  /// no room.
  bool join(MotionRun& run);

  /// Number of periods left to the Propagator so far.
  std::size_t left_over() const { return left_over_; }
  std::size_t carried() const { return carried_; }

 private:
  struct Set;
  struct Going;
  struct DeleteSet {
    void operator()(Set* set) const;
  };
  using OwnSet = std::unique_ptr<Set, DeleteSet>;
  void check_set(std::size_t parameters) const;
  Set& set_of(std::size_t parameters) const;
  OwnSet make_set(const Vector& p);
  void make_pending_table(Set& set);
  static bool is_linear(const Going& one);
  lanes::Motion next_of(const Going& one) const;
  void go_on(bool tangent);
  /// Carries runs with the same kind of flight and stores their progress.
  void carry_alike(std::span<const Going> going, bool tangent);
  void carry_in_lanes(std::size_t begin, std::size_t end, bool tangent);
  void finish(std::size_t number);
  /// Carries a period that the lanes gave up, by the Propagator. False: the motion ends in it.
  bool carry_by_propagator(const lanes::Motion& motion, std::size_t period, bool tangent);

  SharedSystem system_;
  FlowOptions options_;
  LaneWidth width_;
  std::optional<lanes::Law> law_;  ///< common to all sets
  std::vector<OwnSet> sets_;       ///< null: taken
  std::vector<Going> going_;       ///< runs of the current call; the storage is reused
  std::vector<Going> together_;    ///< runs in the lanes, with their motions and progress there, entry by entry
  std::vector<lanes::Motion> motions_;
  std::vector<lanes::Carried> carried_each_;
  bool linear_ = true;  ///< kind of their flights (stored, because the parameters of a finished run may have changed)
  std::vector<StateEllipse> ellipses_;
  RunSupply* supply_ = nullptr;  ///< set during carry_while_full()
  std::size_t most_ = 0, room_ = 0, taken_ = 0;
  Transition transition_;
  std::mutex left_over_lock_;  ///< several threads may leave periods to the Propagator at once
  bool all_threads_ = false;
  std::size_t left_over_ = 0, carried_ = 0;
};

/// Number of motions that one thread carries at once: several in lanes (of the widest registers), or one by a Propagator.
inline constexpr std::size_t motions_in_lanes = 8;
std::size_t motions_at_once(const HybridSystem& system, const Vector& p, const FlowOptions& options = {});

/// A carrier of motions in lanes, with these parameter sets at the indices 0, 1, ...; null if the lanes do not support the system
/// at each of them: Propagators carry such motions.
std::unique_ptr<LaneCarrier> make_lane_carrier(const SharedSystem& system, std::span<const Vector> sets,
                                               const FlowOptions& options = {});

class LaneCarrier::Taken {
  friend class LaneCarrier;
  explicit Taken(OwnSet set) : set_(std::move(set)) {}
  OwnSet set_;
};

}  // namespace graze
