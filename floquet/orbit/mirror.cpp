// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/mirror.hpp>

#include <algorithm>

namespace graze {

std::vector<Vector> mirror_image(const HybridSystem& system, const Vector& p, const std::vector<Vector>& states) {
  if (!is_forced(system)) return {};
  const double T = forcing_period(system, p);
  Propagator propagator(system, p);
  Transition transition;
  const auto carried = [&](const Vector& from, double time) {
    carry(propagator, 0.0, time, from, {.sensitivity = Sensitivity::state}, transition);
    return transition.termination == Termination::time;
  };
  std::vector<Vector> image;
  for (const Vector& state : states) {
    if (!carried(state, 0.5 * T)) return {};
    image.push_back(-transition.x1);
    if (!mode_at(system, 0.0, image.back(), p)) return {};
  }
  // Known no better than by what tangents make of the error of a state.
  constexpr double error = 1e-9;
  for (std::size_t k = 0; k < image.size(); ++k) {
    if (!carried(image[k], T)) return {};
    const Vector& next = image[(k + 1) % image.size()];
    const double tangent = std::max(1.0, transition.Phi.lpNorm<Eigen::Infinity>());
    if (!((transition.x1 - next).lpNorm<Eigen::Infinity>() < error * tangent * (1.0 + next.lpNorm<Eigen::Infinity>()))) return {};
  }
  return image;
}

}  // namespace graze
