// SPDX-License-Identifier: GPL-3.0-or-later
// LaneCarrier: many motions (other starts, other parameters) carried over whole forcing periods side by side, in the lanes of the
// SIMD registers that the processor has (SSE2, AVX2 or AVX-512 on x86; found out when the program starts).
//
// For an oscillator, linear (underdamped, and forced at no less than 1/286 of the frequency at which it would swing undamped by
// itself) or with a cubic spring (a cantilever), before one barrier at its right, rigid with a coefficient of restitution, of
// Hertz's law (damped or not, k_H b_H up to 3e4), or linear elastic (for a linear one the same bounds hold for the motion against
// it: k_S up to some 80000 eta^2). The lanes use the formulas of LinearFlow, CubicFlow and HertzFlow (series of
// their own order), and give the same result to the last bit whatever their number, and, where no table of contacts is in use,
// however the periods are divided between calls. They leave to the Propagator what is delicate (a grazing, an impact slower than
// 1e-4, a chattering or sticking mass): nothing is missed there that the Propagator would not miss. Against it they agree within
// 1e-12 (1 + |Phi|) over a period.
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
  std::size_t parameters = 0;  ///< what add_parameters gave
  double x = 0.0, v = 0.0;     ///< at forcing phase 0
};

/// What one forcing period did to a motion; termination `time`: all is well.
using PeriodResult = lanes::Period;

/// Speeds of impacts and of entries into contact, one after the other.
class ImpactSpeeds : public lanes::ImpactNotes {
 public:
  ImpactSpeeds();
  /// Those written down.
  std::vector<double> list() const { return {list_.begin(), list_.begin() + static_cast<std::ptrdiff_t>(count)}; }

 private:
  std::vector<double> list_;
};

/// Who is told what periods did to a motion (of one that cannot be carried, too), and says whether it goes on.
using PeriodWatch = lanes::PeriodWatch;
using StateEllipse = lanes::Ellipse;

/// A motion to be carried over so many forcing periods, and where it is written down what each of them did.
struct MotionRun {
  MotionStart start;
  std::size_t periods = 0;
  PeriodResult* results = nullptr;
  ImpactSpeeds* speeds = nullptr;  ///< and at what speeds it hit the barrier; may be null
  std::size_t carried = 0;         ///< of the periods
  PeriodWatch* watch = nullptr;    ///< may be null; else there is one of `results`, for the last (and no table is made for it)
  bool goes_first = false;         ///< in carry_while_full: over all of them at once, and where it joins, before the others
  /// Where those carried have brought it.
  MotionStart now() const {
    if (carried == 0) return start;
    const PeriodResult& last = results[carried - 1];
    return {start.parameters, last.x, last.v};
  }
};

/// Who has more motions ready as others come through, so that the lanes do not run dry.
class RunSupply {
 public:
  /// Told of each run that is through, has had its share of periods, or has stopped, `periods` later. It may let others, or the
  /// same again, join (LaneCarrier::join).
  void (*through)(RunSupply& self, MotionRun& run, std::size_t periods) = nullptr;
};

class LaneCarrier {
 public:
  /// Whether the lanes know such a system at these parameters, with these options.
  static bool applies(const HybridSystem& system, const Vector& p, const FlowOptions& options = {});

  /// The system is copied by reference: keep it alive.
  explicit LaneCarrier(const HybridSystem& system, const FlowOptions& options = {}, LaneWidth width = LaneWidth::widest);
  ~LaneCarrier();

  /// A set of parameters that motions may have. @throws std::invalid_argument where applies() is false.
  std::size_t add_parameters(const Vector& p);
  /// A set that is no longer wanted, or that was taken, becomes one of these. @throws the same, and for an unknown set.
  void change_parameters(std::size_t parameters, const Vector& p);
  const Vector& parameters(std::size_t parameters) const;

  /// A set with what is known of it (tables), for another LaneCarrier of the same system and options.
  class Taken;
  Taken take(std::size_t parameters);
  /// In the place of a set that was taken, or as a new one.
  std::size_t add(Taken taken, std::optional<std::size_t> place = std::nullopt);

  /// Announces that about so many forcing periods will be carried of a parameter set. From `periods_for_table` on a table of its
  /// contacts pays (Hertz's law, tolerance >= 1e-13): it is made of the speeds met in the first contacts, for all that follow.
  void expect(std::size_t parameters, std::int64_t periods);
  /// (A table costs 70 ms and saves 0.7 us of a chaotic period at b = 0.05, eta = 0.711, with the tangent 1.5 us: even at 100000
  /// and 47000.)
  static constexpr std::int64_t periods_for_table = 100000;

  /// Whether one is still to be made. That is found out in carry(), after so many periods each time,
  bool awaits_table(std::size_t parameters) const;
  static constexpr std::size_t periods_between_looks = 64;
  /// and, where motions are carried by carry_while_full, here.
  void look_for_table(std::size_t parameters);

  /// A table of contacts made before, of the same parameters: keep it alive. @throws std::invalid_argument where it is of others.
  void use(std::size_t parameters, const ContactTable& table);
  /// The table in use; none: null.
  const ContactTable* table(std::size_t parameters) const;

  /// Watches are told of periods that end in one of these from now on, wherever they come first.
  void tell_of(std::vector<StateEllipse> ellipses) { ellipses_ = std::move(ellipses); }

  /// Motions are carried on all threads of the caller's arena (oneTBB) from now on, where they are many.
  void use_all_threads() { all_threads_ = true; }

  /// Carries each motion over `periods` forcing periods; what period k did to motion m is at m * periods + k. A motion that
  /// cannot be carried on stops there: what would follow has the same termination. @throws std::invalid_argument for unknown
  /// parameters.
  void carry(const std::vector<MotionStart>& starts, std::size_t periods, bool tangent, std::vector<PeriodResult>& results);
  /// The same, of each motion as many as it asks for.
  void carry(std::span<MotionRun> runs, bool tangent);
  /// Goes on with each of them for `most` periods (with a table of contacts for all that are left), as long as that keeps most
  /// lanes busy: then the motions stop that are still on their way, each at the end of a period. No tables are made.
  void carry_while_full(std::span<MotionRun* const> runs, bool tangent, std::size_t most, RunSupply& supply);
  /// When the supply is told of one: lets a motion go on with the others. False: it has to wait for another call (its flight is
  /// of the other kind, there is a table of its contacts or one to be made, or no room).
  bool join(MotionRun& run);

  /// Periods that the lanes left to the Propagator, of all so far.
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
  void look_for_table(Set& set);
  static bool is_linear(const Going& one);
  lanes::Motion next_of(const Going& one) const;
  void go_on(bool tangent);
  /// Those that are alike: what is done to them, and written down of each.
  void carry_alike(std::span<const Going> going, bool tangent);
  void carry_in_lanes(std::size_t begin, std::size_t end, bool tangent);
  void finish(std::size_t number);
  /// A period that the lanes give up, by the Propagator. False: the motion ends in it.
  bool do_left_over(const lanes::Motion& motion, std::size_t period, bool tangent);

  const HybridSystem* system_;
  FlowOptions options_;
  LaneWidth width_;
  std::optional<lanes::Law> law_;  ///< of all sets
  std::vector<OwnSet> sets_;       ///< those taken: null
  std::vector<Going> going_;       ///< of carry(): they keep their memory from one call to the next
  std::vector<Going> together_;    ///< in the lanes now, with their motions there and how far these came
  std::vector<lanes::Motion> motions_;
  std::vector<lanes::Carried> carried_each_;
  bool linear_ = true;  ///< their flights (the parameters of those that are through may have changed meanwhile)
  std::vector<StateEllipse> ellipses_;
  RunSupply* supply_ = nullptr;  ///< of carry_while_full()
  std::size_t most_ = 0, room_ = 0, taken_ = 0;
  Transition transition_;
  std::mutex left_over_lock_;  ///< the lanes of several threads leave something over
  bool all_threads_ = false;
  std::size_t left_over_ = 0, carried_ = 0;
};

class LaneCarrier::Taken {
  friend class LaneCarrier;
  explicit Taken(OwnSet set) : set_(std::move(set)) {}
  OwnSet set_;
};

}  // namespace graze
