// SPDX-License-Identifier: GPL-3.0-or-later
// SweepStretches: the rows of one direction of a sweep while they are being found, in about as many stretches as there are rows
// in each. A stretch need not wait for those before it: it begins behind a row that is a guess, what the motion from the start of
// the sweep comes to at that value. Once the last row of the stretch before is known, the guess stands if the two are on the same
// attractor (same_attractor.hpp); else the stretch begins anew behind that row. Stretches end where the number of values says,
// and each is found from its own rows and the one before it alone: what comes out depends neither on what is found first, nor on
// how much of it was known from an earlier run.
//
// Within a stretch a row may begin when the one before has handed its motion on. Should that end on a stable orbit after all, the
// rows behind it are taken back.
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
    SweepRow* row;           ///< in its place; its end is where the next one begins, once it is handed on
    bool handed_on = false;  ///< the next row may begin
    bool done = false;
    std::atomic<bool> dropped = false;  ///< a row before it has turned out another
  };
  struct Stretch {
    std::size_t begin, end;  ///< its first row, and that behind its last
    /// The row before it: a guess, until that of the stretch before is known and is on another attractor. Null where there is
    /// none, or the guess failed.
    std::shared_ptr<Entry> guess = {}, lead = {};
    SweepRow guessed = {}, known = {};  ///< the rows of the guess, and of a lead that is none
    bool joined = false;                ///< the stretch before is done, and this one begins on its attractor
    std::vector<std::shared_ptr<Entry>> entries = {};
    SweepChain::Block ahead = {};
    bool looks_ahead = false;    ///< a thread does so, for `ahead`
    bool ended = false;          ///< the motion could not be carried on
    std::size_t open = 0;        ///< rows that are not done
    std::size_t taken_back = 0;  ///< how often
    std::size_t next() const { return begin + entries.size(); }
    bool done() const { return open == 0 && next() == end; }
    const Entry* last() const { return entries.empty() ? lead.get() : entries.back().get(); }
  };

  /// `so_far`: rows of an earlier run, of which its own are kept.
  SweepStretches(SweepChain chain, const std::vector<SweepRow>& so_far);
  SweepStretches(const SweepStretches&) = delete;
  SweepStretches& operator=(const SweepStretches&) = delete;

  const SweepChain& chain() const { return chain_; }
  bool finished() const { return ended_ || kept_ == chain_.size(); }
  /// Rows that are done.
  std::size_t done() const { return done_; }

  /// The first stretch that can go on. After a guess that did not stand, those behind other guesses only if that may be in vain.
  std::shared_ptr<Stretch> next(bool in_vain);
  /// Where fewer guesses than that are not yet confirmed, one for the stretch behind all others, if there is one.
  std::shared_ptr<Entry> guess(std::size_t most);
  /// The orbits of the rows before its next block that are alike, the last one last.
  std::vector<std::vector<Vector>> orbits_before(const Stretch& stretch) const;
  /// Its next row: known, or to be found.
  std::shared_ptr<Entry> add(Stretch& stretch, std::optional<SweepRow> known);
  /// The row behind one that was begun may begin, there.
  void hand_on(Entry& entry, const Vector& state);
  /// What a row is that was begun; `broken`: it could not be found.
  void finish(Entry& entry, SweepRow row, bool broken);

  /// Its rows up to the first that is not done, as far as nothing can change them any more.
  std::vector<SweepRow> so_far() const&;
  std::vector<SweepRow> so_far() &&;

 private:
  Stretch& add_stretch(std::size_t begin);
  bool can_go_on(const Stretch& stretch) const;
  void take_back(Stretch& stretch, std::size_t from);
  void follow(const SweepRow& last, Stretch& behind);
  void join();
  void keep_first();
  std::size_t known() const;

  SweepChain chain_;
  std::size_t length_;                              ///< of a stretch
  std::vector<SweepRow> rows_;                      ///< to the end of the last stretch; they stay where they are
  std::size_t kept_ = 0;                            ///< of them, those of stretches that nothing can change any more
  std::deque<std::shared_ptr<Stretch>> stretches_;  ///< the others that were begun
  bool guesses_well_ = true;                        ///< the last guess stood
  bool ended_ = false;                              ///< the motion could not be carried on
  std::size_t done_ = 0;
};

}  // namespace graze
