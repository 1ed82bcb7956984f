// SPDX-License-Identifier: GPL-3.0-or-later
// Queue: gives the motions of a job to the lanes and keeps their progress.
#pragma once

#include <graze/lib/lanes/job.hpp>
#include <graze/lib/lanes/wide_registers.hpp>

#include <algorithm>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

template <std::size_t Lanes> class Queue {
 public:
  /// For this number of lanes, or fewer if there are fewer motions.
  explicit Queue(const Job& job) : job_(job), count_(job.count), lanes_(std::min(job.count, Lanes)) {
    for (std::size_t i = 0; i < job.count; ++i) look_at(job.motions[i]);
  }
  /// Whether any motion has a table of contacts, a histogram of speeds, a recorder of impacts, an observer.
  bool tables() const { return tables_; }
  bool met() const { return met_; }
  bool notes() const { return notes_; }
  bool watched() const { return watched_; }

  bool empty() const { return taken_ == count_; }
  /// Takes the next motion and returns its number.
  std::size_t take() { return taken_++; }
  void end(std::size_t number, const Carried& carried) {
    job_.carried[number] = carried;
    ++ended_;
    if (job_.more) ask_for_more(number);
  }
  /// Whether a motion stops at the end of its period although it has more (Job::while_full). With fewer than 7/8 of the lanes
  /// busy, this saves more steps than the lanes lose while they wait for the ends of the others' periods.
  bool stops(const Motion& motion) const {
    return job_.while_full && !motion.table && empty() && 8 * (taken_ - ended_) < 7 * lanes_;
  }

 private:
  void look_at(const Motion& motion) {
    tables_ = tables_ || motion.table;
    met_ = met_ || motion.met;
    notes_ = notes_ || motion.notes;
    watched_ = watched_ || motion.watch;
  }
  /// New motions stand behind the others, except that one may stand first among those not taken.
  void ask_for_more(std::size_t number) {
    WideRegisters::leave();
    const std::size_t before = count_;
    count_ = job_.more(job_.whom, number, taken_);
    for (std::size_t i = before; i < count_; ++i) look_at(job_.motions[i]);
    if (count_ > before) look_at(job_.motions[taken_]);
    lanes_ = std::max(lanes_, std::min(count_ - ended_, Lanes));
  }

  const Job& job_;
  std::size_t count_, lanes_, taken_ = 0, ended_ = 0;
  bool tables_ = false, met_ = false, notes_ = false, watched_ = false;
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
