// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/settling_orbit.hpp>
#include <graze/floquet/tangent_growth.hpp>
#include <graze/lib/many_motions.hpp>

namespace graze {

std::vector<Vector> that_may_settle(const HybridSystem& system, const Vector& p, const std::vector<Vector>& states,
                                    const FlowOptions& flow) {
  struct Motion {
    const Vector* begin;
    MotionStart at;
    Eigen::Matrix2d growth = Eigen::Matrix2d::Identity();
    bool ended = false;
  };
  constexpr int stretch = long_enough / 4;
  ManyMotions many(system, flow);
  const std::size_t set = many.add_parameters(p);
  std::vector<Motion> motions;
  for (const Vector& state : states) motions.push_back({&state, {set, state[0], state[1]}});
  std::vector<MotionStart> starts;
  std::vector<PeriodResult> results;
  for (int carried = 0; carried < long_enough;) {
    starts.clear();
    for (const Motion& motion : motions) starts.push_back(motion.at);
    many.carry(starts, stretch, true, results);
    carried += stretch;
    const PeriodResult* next = results.data();
    for (Motion& motion : motions) {
      for (int k = 0; k < stretch; ++k, ++next)
        motion.growth = Eigen::Matrix2d{{next->Phi[0], next->Phi[1]}, {next->Phi[2], next->Phi[3]}} * motion.growth;
      motion.at = {set, next[-1].x, next[-1].v};
      motion.ended = next[-1].termination != Termination::time;
    }
    // What has grown by the square of it on the way will not have shrunk at the end.
    const double most = carried == long_enough ? hopeless_growth : hopeless_growth * hopeless_growth;
    std::erase_if(motions, [&](const Motion& motion) { return motion.ended || spectral_radius(motion.growth) > most; });
  }
  std::vector<Vector> out;
  for (const Motion& motion : motions) out.push_back(*motion.begin);
  return out;
}

}  // namespace graze
