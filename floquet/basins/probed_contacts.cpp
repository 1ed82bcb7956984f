// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/return_watch.hpp>
#include <graze/floquet/basins/probed_contacts.hpp>
#include <graze/floquet/basins/visited_cells.hpp>
#include <graze/lib/motion/lane_carrier.hpp>
#include <graze/lib/numerics/spread_order.hpp>

#include <algorithm>

namespace graze {

namespace {

/// The period in which the motion first nearly returns; all of them if it does not return, or if it ends.
std::size_t periods_to_settle(std::span<const PeriodResult> periods) {
  constexpr double nearly = 1e-3;  // relative to 1 + |x|
  ReturnWatch watch(nearly);
  for (std::size_t k = 0; k < periods.size() && periods[k].termination == Termination::time; ++k)
    if (watch.see(Vector{{periods[k].x, periods[k].v}}) > 0) return k + 1;
  return periods.size();
}

/// The states of the motions after `stretch` periods, without the motions that ended.
std::vector<MotionStart> ends_of(const std::vector<PeriodResult>& results, std::size_t stretch) {
  std::vector<MotionStart> ends;
  for (std::size_t end = stretch; end <= results.size(); end += stretch)
    if (const PeriodResult& last = results[end - 1]; last.termination == Termination::time) ends.push_back({0, last.x, last.v});
  return ends;
}

}  // namespace

std::shared_ptr<const ContactTable> probed_contacts(const SharedSystem& system, const Vector& p, const Matrix& starts,
                                                    const FlowOptions& flow) {
  constexpr std::size_t first = 64, stretch = LaneCarrier::periods_between_looks, most_stretches = 4;
  constexpr std::size_t longest = VisitedCells::window;  // until a chaotic motion is recognised
  const auto count = static_cast<std::size_t>(starts.cols());
  if (longest * count < LaneCarrier::periods_for_table || !ContactTable::applies(system, p)) return nullptr;
  const std::unique_ptr<LaneCarrier> many = make_lane_carrier(system, {&p, 1}, flow);
  if (!many) return nullptr;
  many->use_all_threads();
  std::vector<MotionStart> motions;
  const SpreadOrder order(count);
  for (std::size_t k = 0; k < std::min(first, count); ++k) {
    const auto start = starts.col(static_cast<Eigen::Index>(order[k]));
    motions.push_back({0, start[0], start[1]});
  }
  std::vector<PeriodResult> results;
  many->carry(motions, longest, false, results);
  std::size_t periods = 0;
  for (std::size_t i = 0; i < motions.size(); ++i) periods += periods_to_settle({&results[i * longest], longest});
  many->expect(0, static_cast<std::int64_t>(periods * count / motions.size()));
  motions = ends_of(results, longest);
  for (std::size_t i = 0; i < most_stretches && many->awaits_table(0); ++i) {
    many->carry(motions, stretch, false, results);
    motions = ends_of(results, stretch);
  }
  return many->table(0);
}

}  // namespace graze
