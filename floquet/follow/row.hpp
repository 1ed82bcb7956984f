// SPDX-License-Identifier: GPL-3.0-or-later
// Row: attractors at consecutive values of a parameter during their computation, each point from the end state of the one before
// (RowChain). A sweep in one direction is a row, and so is a followed row of a map.
//
// A point can start when the one before has published its state, which it may do long before it is decided (a chaotic average).
// If that point ends elsewhere after all, on a stable orbit or nowhere, the points after it are rolled back.
//
// A row is divided into stretches of RowChain::stretch points. A stretch does not wait for those before it: it starts after a
// guessed point, the result of the motion from the start of the row at that value. When the last point of the stretch before is
// known, the guess is accepted if both are on the same attractor (same_attractor.hpp); otherwise the stretch starts again after
// that point. On smooth branches the orbits of a block of points can be predicted (predicted_orbits.hpp). The ends of stretches
// and blocks depend only on the number of points, and the points of a stretch only on each other and on the point before them.
// The result therefore depends neither on the order of computation nor on the points known from an earlier run.
#pragma once

#include <graze/floquet/follow/predicted_orbits.hpp>
#include <graze/floquet/follow/sweep.hpp>
#include <graze/lib/tasks/task.hpp>

#include <atomic>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace graze {

class TaskSlot;

struct RowPoint : FollowedAttractor {  ///< an empty `end`: the next point starts as the first one does
  bool inadmissible = false;           ///< its start lies inside a barrier
  Vector quantities;                   ///< of the attractor; a map's (MapOptions::measure)
};

/// How the points of a row are computed. Its functions are called from any thread.
class RowChain {
 public:
  virtual ~RowChain() = default;

  struct Begin {
    std::size_t number = 0;  ///< of the point, in the order of the row
    Vector state;            ///< final or published state of the point before; empty: the start of the row
    bool settled = true;     ///< the point before is periodic
    bool compared = false;   ///< the point will be compared with another: it needs samples of a nonperiodic attractor
  };
  struct Found {
    RowPoint point;
    bool revokes = false;  ///< the state that the point has published does not hold
    bool failed = false;   ///< it could not be computed: the row ends before it
  };

  virtual std::size_t size() const = 0;
  /// Number of points in a stretch: a multiple of the block of predictions, or at least size().
  virtual std::size_t stretch() const = 0;
  /// If more points of a stretch than this are open or follow an open one, the next will probably be rolled back.
  virtual std::size_t many() const { return std::numeric_limits<std::size_t>::max(); }
  /// Computes a point. `publish` receives the start of the next point as soon as it is known, if this point is not yet known to
  /// be periodic. With `cancelled`, the result may be anything that is marked as failed.
  virtual MotionTask<Found> find(TaskSlot& slot, Begin begin, std::function<bool()> cancelled,
                                 std::function<void(const Vector& state)> publish) const = 0;
  /// Whether orbits are predicted, and the orbits of these points: see predicted_orbits.
  virtual bool predicts() const { return false; }
  virtual std::vector<PredictedOrbit> predict(std::size_t begin, std::size_t end,
                                              const std::vector<std::vector<Vector>>& before) const;
};

class Row {
 public:
  struct Stretch;
  struct Entry {
    Entry(Stretch& of, RowChain::Begin from) : stretch(&of), begin(std::move(from)) {}
    Stretch* stretch;
    RowChain::Begin begin;
    RowPoint point;          ///< point.end is the start of the next point once published
    bool published = false;  ///< the next point may begin
    bool done = false;
    std::atomic<bool> dropped = false;  ///< rolled back: an earlier point ended elsewhere
  };
  struct Stretch {
    Stretch(std::size_t first, std::size_t past) : begin(first), end(past) {}
    std::size_t begin, end;  ///< its first point, and one past its last
    /// The point before the stretch. `lead` is the guess, until the last point of the stretch before is known and on another
    /// attractor. Null if there is none, or if the guess failed.
    std::shared_ptr<Entry> guess = {}, lead = {};
    bool joined = false;  ///< the stretch before is done, and this one starts on its attractor
    std::vector<std::shared_ptr<Entry>> entries = {};
    std::optional<std::size_t> predicted_block = {};    ///< first point of the block that was predicted last
    std::vector<PredictedOrbit> predicted_orbits = {};  ///< of its points
    bool predicting = false;                            ///< a thread is predicting them
    bool ended = false;                                 ///< the motion could not be continued
    std::size_t open = 0;                               ///< points that are not done
    std::size_t rollbacks = 0;                          ///< number of rollbacks
    std::size_t next() const { return begin + entries.size(); }
    bool done() const { return open == 0 && next() == end; }
    const Entry* last() const { return entries.empty() ? lead.get() : entries.back().get(); }
  };

  struct Listener {
    /// Receives the points in their order. Nothing can change them any more.
    std::function<void(std::size_t number, const RowPoint& point)> commit = {};
    /// Called once by a RowRunner, from any thread, after the row is finished.
    std::function<void()> finished = {};
    /// Called by a RowRunner after each point that is done, by one thread at a time; others may have to wait meanwhile.
    std::function<void(std::size_t number)> done = {};
  };
  /// Guesses of a row that may be unconfirmed, for this number of threads.
  static constexpr std::size_t usual_guesses(std::size_t threads) { return 8 + threads; }

  /// At most `most_guesses` guesses are unconfirmed at a time. `so_far`: the first points, known from an earlier run.
  Row(std::unique_ptr<const RowChain> chain, Listener listener, std::size_t most_guesses = 1, std::vector<RowPoint> so_far = {});
  Row(const Row&) = delete;
  Row& operator=(const Row&) = delete;

  const RowChain& chain() const { return *chain_; }
  const Listener& listener() const { return listener_; }
  /// Whether all points are committed, or the row has ended.
  bool finished() const { return ended_ || kept_ == chain_->size(); }
  /// Number of points that are done.
  std::size_t done() const { return done_; }

  /// The kind of point that can start next: one that will probably be kept, one that will probably be rolled back, a guess, or
  /// nothing.
  enum class Next { none, guess, unlikely, likely };
  Next next() const;
  Next queued = Next::none;  ///< for RowRunner: the queue in which it stands

  /// The stretch whose point can start next (likely or unlikely).
  std::shared_ptr<Stretch> stretch_to_continue() const;
  /// Starts a guess for the stretch after all others.
  std::shared_ptr<Entry> start_guess();
  /// Whether the orbits of the next point's block have yet to be predicted; the orbits before that block, as long as they have
  /// the same n and p, the last one last.
  bool needs_prediction(const Stretch& stretch) const;
  std::vector<std::vector<Vector>> orbits_before(const Stretch& stretch) const;
  /// End of the block that begins with this point.
  std::size_t end_of_block(std::size_t begin) const;
  /// Starts the next point of a stretch. It is done at once if its orbit was predicted.
  std::shared_ptr<Entry> start(Stretch& stretch);
  /// Publishes the state of a started point: the next one can start from there.
  void publish(Entry& entry, const Vector& state);
  /// Stores the result of a started point.
  void finish(Entry& entry, RowChain::Found found);

  static constexpr std::size_t block = 16;  ///< points whose orbits are predicted together
  /// First point of a point's block.
  static std::size_t block_of(std::size_t number) { return number / block * block; }
  /// A good length of the stretches of a long row: about their number, in whole blocks.
  static std::size_t stretch_of(std::size_t size);

 private:
  Stretch& add_stretch(std::size_t begin);
  std::shared_ptr<Entry> entry(Stretch& stretch, RowChain::Begin begin) const;
  bool can_go_on(const Stretch& stretch) const;
  bool likely(const Stretch& stretch) const;
  bool can_guess() const;
  std::optional<RowPoint> predicted(Stretch& stretch) const;
  void roll_back(Stretch& stretch, std::size_t from);
  void follow(const std::shared_ptr<Entry>& last, Stretch& behind);
  void join();
  void commit();
  void keep_first();

  std::unique_ptr<const RowChain> chain_;
  Listener listener_;
  std::size_t most_guesses_;
  std::vector<std::shared_ptr<Stretch>> stretches_;  ///< that were started and may change
  std::size_t kept_ = 0;                             ///< points of the stretches before these
  std::size_t committed_ = 0;
  bool last_guess_accepted_ = true;
  bool ended_ = false;  ///< the motion could not be continued
  std::size_t done_ = 0;
};

}  // namespace graze
