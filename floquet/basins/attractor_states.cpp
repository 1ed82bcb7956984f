// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/basins/attractor_states.hpp>
#include <graze/floquet/basins/visited_cells.hpp>
#include <graze/floquet/exponents/running_average.hpp>
#include <graze/lib/tasks/task_pool.hpp>

namespace graze {

namespace {

constexpr std::size_t motions_in_chaos = 16, states_of_motion = VisitedCells::window;

}  // namespace

std::vector<Vector> attractor_states(const SharedSystem& system, const Vector& p, const Attractor& attractor, std::size_t count,
                                     const FlowOptions& flow, const std::shared_ptr<const ContactTable>& table) {
  const Vector& start = attractor.state;
  std::vector<Vector> states;
  const auto along_one = [&](TaskSlot& slot) -> MotionTask<> {
    states.push_back(start);
    for (bool goes_on = true; goes_on && states.size() < count;) {
      const std::size_t before = states.size(), periods = slot.batch(count - before);
      const CarriedPeriods carried = co_await slot.carry(states.back(), periods);
      append_states(carried, 0, states);
      goes_on = states.size() == before + periods;
    }
  };
  const auto along_several = [&](TaskSlot& slot) -> MotionTask<> {
    const std::size_t each =
        (count + motions_in_chaos * states_of_motion - 1) / (motions_in_chaos * states_of_motion) * states_of_motion;
    const std::vector<Vector> starts = neighbouring_starts(system, p, start, motions_in_chaos);
    const CarriedMotions motions = co_await slot.carry_all(starts, decorrelation_periods + each - 1, false);
    for (std::size_t i = 0; i < starts.size(); ++i) append_states(motions.of(i), decorrelation_periods - 1, states);
    if (states.empty()) states.push_back(start);
  };
  const auto cover = [&](std::size_t, TaskSlot& slot) -> MotionTask<> {
    slot.set_parameters(p);
    const bool several =
        slot.motions_at_once() > 1 && attractor.type == AttractorType::chaotic && count >= motions_in_chaos * states_of_motion;
    if (!several && !table) slot.set_parameters(p, true);  // one motion gains nothing from lanes without a table
    if (table) slot.use(table);
    if (several)
      co_await along_several(slot);
    else
      co_await along_one(slot);
  };
  run_tasks(system, flow, true, 1, cover);
  return states;
}

}  // namespace graze
