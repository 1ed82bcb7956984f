// SPDX-License-Identifier: GPL-3.0-or-later
// SweepStretches: the rows of one direction of a sweep during their computation. They form about sqrt(rows) stretches of about
// sqrt(rows) rows. A stretch does not wait for those before it. It starts after a guessed row: the result of the motion from
// the start of the sweep at that value. When the last row of the stretch before is known, the guess is accepted if both are on
// the same attractor (same_attractor.hpp); otherwise the stretch starts again after that row. The ends of the stretches depend
// only on the number of values, and the rows of a stretch only on each other and on the row before them. The result therefore
// depends neither on the order of computation nor on the rows known from an earlier run.
//
// Within a stretch a row can start when the one before has published its state. If that one ends on a stable orbit after all,
// the rows after it are rolled back.
#pragma once

#include <graze/floquet/follow/sweep_chain.hpp>

#include <atomic>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

namespace graze {

class SweepStretches {
 public:
  struct Stretch;
  struct Entry {
    SweepStretches* direction;
    Stretch* stretch;
    SweepChain::Begin begin;
    SweepRow* row;           ///< its place in rows_; row->end is the start of the next row once published
    bool published = false;  ///< the next row may begin
    bool done = false;
    std::atomic<bool> dropped = false;  ///< rolled back: an earlier row ended elsewhere
  };
  struct Stretch {
    std::size_t begin, end;  ///< its first row, and one past its last
    /// The row before the stretch. `lead` is the guess, until the last row of the stretch before is known and on another
    /// attractor. Null if there is none, or if the guess failed.
    std::shared_ptr<Entry> guess = {}, lead = {};
    SweepRow guessed = {}, known = {};  ///< the row of the guess, and of a lead that is not a guess
    bool joined = false;                ///< the stretch before is done, and this one starts on its attractor
    std::vector<std::shared_ptr<Entry>> entries = {};
    SweepChain::Block ahead = {};
    bool looks_ahead = false;   ///< a thread is predicting `ahead`
    bool ended = false;         ///< the motion could not be continued
    std::size_t open = 0;       ///< rows that are not done
    std::size_t rollbacks = 0;  ///< number of rollbacks
    std::size_t next() const { return begin + entries.size(); }
    bool done() const { return open == 0 && next() == end; }
    const Entry* last() const { return entries.empty() ? lead.get() : entries.back().get(); }
  };

  /// `so_far`: rows of an earlier run; those of this direction are kept.
  SweepStretches(SweepChain chain, const std::vector<SweepRow>& so_far);
  SweepStretches(const SweepStretches&) = delete;
  SweepStretches& operator=(const SweepStretches&) = delete;

  const SweepChain& chain() const { return chain_; }
  bool finished() const { return ended_ || kept_ == chain_.size(); }
  /// Number of finished rows.
  std::size_t done() const { return done_; }

  /// The first stretch that can continue. After a rejected guess, stretches behind unconfirmed guesses are returned only if
  /// work `speculative` is allowed.
  std::shared_ptr<Stretch> next(bool speculative);
  /// Starts a guess for the stretch after all others, if there is one and fewer than `most` guesses are unconfirmed.
  std::shared_ptr<Entry> guess(std::size_t most);
  /// The orbits of the rows before the stretch's next block, as long as they are alike, the last one last.
  std::vector<std::vector<Vector>> orbits_before(const Stretch& stretch) const;
  /// Appends the next row: known, or to be computed.
  std::shared_ptr<Entry> add(Stretch& stretch, std::optional<SweepRow> known);
  /// Publishes the state of a started row: the next row can start from there.
  void publish(Entry& entry, const Vector& state);
  /// Stores the result of a started row; `broken`: it could not be computed.
  void finish(Entry& entry, SweepRow row, bool broken);

  /// The rows up to the first that is not finished; nothing can change them any more.
  std::vector<SweepRow> so_far() const&;
  std::vector<SweepRow> so_far() &&;

 private:
  Stretch& add_stretch(std::size_t begin);
  bool can_go_on(const Stretch& stretch) const;
  void roll_back(Stretch& stretch, std::size_t from);
  void follow(const SweepRow& last, Stretch& behind);
  void join();
  void keep_first();
  std::size_t known() const;

  SweepChain chain_;
  std::size_t length_;                              ///< of a stretch
  std::vector<SweepRow> rows_;                      ///< up to the end of the last stretch; their addresses are stable
  std::size_t kept_ = 0;                            ///< rows of committed stretches
  std::deque<std::shared_ptr<Stretch>> stretches_;  ///< the stretches that were started and are not committed
  bool last_guess_accepted_ = true;                 ///< the last guess was accepted
  bool ended_ = false;                              ///< the motion could not be continued
  std::size_t done_ = 0;
};

}  // namespace graze
