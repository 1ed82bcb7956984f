// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/attractor_task.hpp>
#include <graze/floquet/follow/map_chain.hpp>
#include <graze/floquet/follow/sweep_chain.hpp>
#include <graze/lib/motion/rest.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace graze {

namespace {

constexpr int shortest_average = 200;
/// Rows up to this length are not divided: a stretch begins with a guess, whose orbit differs from the one that is followed in
/// the last digits.
constexpr std::size_t short_row = 512;
/// States of a nonperiodic attractor by which it is compared with another.
constexpr int samples = 200;

bool is_lost(const Attractor& attractor) {
  return attractor.termination != Termination::time ||
         (attractor.type != AttractorType::periodic && attractor.time_average.stop == LyapunovStop::failed);
}

}  // namespace

MapSetting map_setting(const HybridSystem& system, const Vector& p, const ParameterGrid& grid,
                       const std::vector<MapLayer>& layers, const MapOptions& options) {
  check_map(system, p, grid, layers, options);
  MapSetting out{system, p, grid, layers, options, {}, {}, {}, {}};
  out.column_parameter = static_cast<Eigen::Index>(parameter_index(system.parameters, grid.columns.parameter));
  out.row_parameter = static_cast<Eigen::Index>(parameter_index(system.parameters, grid.rows.parameter));
  AttractorOptions& from_start = out.from_start;
  from_start.transient = options.settle;
  from_start.max_period = options.max_period;
  from_start.recurrence = usual_recurrence;
  from_start.periods_on_orbit = 0;  // the multipliers contain everything
  from_start.lyapunov.standard_error = options.standard_error;
  from_start.lyapunov.max_periods = options.periods;
  from_start.lyapunov.min_periods = std::min(options.periods, shortest_average);
  from_start.lyapunov.aligning = shortest_average;
  from_start.lyapunov.flow = options.flow;
  out.from_neighbour = from_start;
  out.from_neighbour.transient = options.transient;
  return out;
}

int MapChain::column(std::size_t number) const {
  const int place = static_cast<int>(number);
  return column_ + (layer().follow == MapDirection::down ? count_ - 1 - place : place);
}

std::size_t MapChain::stretch() const { return size() <= short_row ? size() : Row::stretch_of(size()); }

std::size_t MapChain::many() const { return 4; }

MotionTask<RowChain::Found> MapChain::find(TaskSlot& slot, Begin begin, std::function<bool()> cancelled,
                                           std::function<void(const Vector& state)> publish) const {
  Found out;
  out.failed = cancelled();
  if (out.failed) co_return out;
  Vector p = map_->p;
  p[map_->row_parameter] = map_->grid.rows.at(row_);
  p[map_->column_parameter] = map_->grid.columns.at(column(begin.number));
  if (begin.state.size() > 0) {
    Vector before = p;
    before[map_->column_parameter] = map_->grid.columns.at(column(begin.number - 1));
    keep_held(map_->system, 0.0, before, p, begin.state);
  }
  // The layer's start serves where there is no state of a neighbour, or where that now lies inside a barrier.
  const bool goes_on = begin.state.size() > 0 && mode_at(map_->system, 0.0, begin.state, p);
  const Vector start = goes_on ? begin.state : layer().start(p);
  out.point.inadmissible = !goes_on && !mode_at(map_->system, 0.0, start, p);
  out.revokes = out.point.inadmissible;
  if (out.point.inadmissible) co_return out;
  AttractorOptions finding = goes_on ? map_->from_neighbour : map_->from_start;
  finding.lyapunov.cancelled = cancelled;
  Attractor& attractor = out.point.attractor;
  attractor = co_await approach_attractor(slot, p, start, finding);
  if (attractor.termination == Termination::time && attractor.type != AttractorType::periodic) {
    out.point.end = attractor.state;
    publish(attractor.state);
  }
  co_await average_on_attractor(slot, p, attractor, finding);
  const bool periodic = attractor.type == AttractorType::periodic, lost = is_lost(attractor);
  // A signal may have cut the average short, which an undecided attractor does not show.
  out.failed = !periodic && cancelled();
  out.revokes = periodic || lost;
  if (lost) out.point.end = Vector();
  if (periodic) out.point.end = attractor.state;
  if (lost || out.failed) co_return out;
  if (map_->options.measure) out.point.quantities = map_->options.measure(p, attractor);
  if (!periodic && begin.compared) co_await sample_attractor(slot, p, samples, out.point);
  if (periodic) out.point.states = attractor.orbit->states;
  attractor.orbit.reset();
  co_return out;
}

MapPoint map_point(const HybridSystem& system, const RowPoint& point) {
  MapPoint out;
  const Attractor& attractor = point.attractor;
  out.state = Vector::Constant(static_cast<Eigen::Index>(system.states), std::nan(""));
  out.type = MapType::lost;
  if (point.inadmissible) out.type = MapType::inadmissible;
  if (point.inadmissible || is_lost(attractor)) return out;
  out.type = attractor.type == AttractorType::periodic  ? MapType::periodic
             : attractor.type == AttractorType::chaotic ? MapType::chaotic
                                                        : MapType::undecided;
  out.period = attractor.period;
  out.impacts = attractor.impacts;
  out.state = attractor.state;
  out.quantities = point.quantities;
  if (attractor.exponents.empty()) return out;
  out.lambda_1 = attractor.exponents.front();
  out.standard_error = attractor.standard_errors.front();
  return out;
}

}  // namespace graze
