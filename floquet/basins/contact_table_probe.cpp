// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/return_watch.hpp>
#include <graze/floquet/basins/contact_table_probe.hpp>
#include <graze/floquet/basins/visited_cells.hpp>
#include <graze/floquet/exponents/running_average.hpp>
#include <graze/floquet/orbit/stroboscopic_states.hpp>
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

ContactTableProbe::ContactTableProbe(const SharedSystem& system, const Vector& p, const Matrix& starts, const FlowOptions& flow)
    : system_(system), p_(p), flow_(flow), many_(make_lane_carrier(system, {&p, 1}, flow)) {
  if (!many_) return;
  many_->use_all_threads();
  constexpr std::size_t first = 64, stretch = LaneCarrier::periods_between_looks, most_stretches = 4;
  const auto count = static_cast<std::size_t>(starts.cols());
  constexpr std::size_t longest = VisitedCells::window;  // until a chaotic motion is recognised
  if (!ContactTable::applies(system, p) || longest * count < LaneCarrier::periods_for_table) return;
  std::vector<MotionStart> motions;
  const SpreadOrder order(count);
  for (std::size_t k = 0; k < std::min(first, count); ++k) {
    const auto start = starts.col(static_cast<Eigen::Index>(order[k]));
    motions.push_back({0, start[0], start[1]});
  }
  std::vector<PeriodResult> results;
  many_->carry(motions, longest, false, results);
  std::size_t periods = 0;
  for (std::size_t i = 0; i < motions.size(); ++i) periods += periods_to_settle({&results[i * longest], longest});
  many_->expect(0, static_cast<std::int64_t>(periods * count / motions.size()));
  motions = ends_of(results, longest);
  for (std::size_t i = 0; i < most_stretches && many_->awaits_table(0); ++i) {
    many_->carry(motions, stretch, false, results);
    motions = ends_of(results, stretch);
  }
  table_ = many_->table(0);
}

std::vector<Vector> ContactTableProbe::states(const Vector& start, std::size_t count) const {
  if (!table_) {
    Propagator propagator(system_, p_, {}, flow_);
    return stroboscopic_states(propagator, start, count);
  }
  std::vector<PeriodResult> results;
  many_->carry({{0, start[0], start[1]}}, std::max<std::size_t>(count, 1) - 1, false, results);
  std::vector<Vector> states{start};
  for (const PeriodResult& one : results)
    if (one.termination == Termination::time) states.push_back(Vector{{one.x, one.v}});
  return states;
}

std::vector<Vector> ContactTableProbe::states(const Attractor& attractor, std::size_t count) const {
  constexpr std::size_t motions = 16, whole = VisitedCells::window;
  const Vector& start = attractor.state;
  const std::size_t each = (count + motions * whole - 1) / (motions * whole) * whole, periods = decorrelation_periods + each - 1;
  if (!many_ || attractor.type != AttractorType::chaotic || count < motions * whole) return states(start, count);
  std::vector<PeriodResult> results;
  many_->carry(neighbouring_starts(0, start, static_cast<int>(motions)), periods, false, results);
  std::vector<Vector> states;
  for (std::size_t i = 0; i < motions; ++i)
    for (std::size_t k = decorrelation_periods - 1; k < periods; ++k)
      if (const PeriodResult& one = results[i * periods + k]; one.termination == Termination::time)
        states.push_back(Vector{{one.x, one.v}});
  return states.empty() ? std::vector<Vector>{start} : states;
}

}  // namespace graze
