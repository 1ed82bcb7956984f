// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/mirror.hpp>

#include <algorithm>

namespace graze {

std::optional<Vector> mirrored_state(Propagator& propagator, const Symmetry& symmetry, const Vector& x) {
  if (symmetry.shift == 0.0) return Vector(symmetry.matrix * x);
  const double T = forcing_period(propagator.system(), propagator.parameters());
  Transition transition;
  carry(propagator, 0.0, symmetry.shift * T, x, {.sensitivity = Sensitivity::none}, transition);
  if (transition.termination != Termination::time) return std::nullopt;
  return Vector(symmetry.matrix * transition.x1);
}

std::vector<Vector> mirror_image(const HybridSystem& system, const Vector& p, const Symmetry& symmetry,
                                 const std::vector<Vector>& states) {
  Propagator propagator(system, p);
  Transition transition;
  std::vector<Vector> image;
  for (const Vector& state : states) {
    const std::optional<Vector> mirrored = mirrored_state(propagator, symmetry, state);
    if (!mirrored || !mode_at(system, 0.0, *mirrored, p)) return {};
    image.push_back(*mirrored);
  }
  if (!is_forced(system)) return image;  // S x(t) is a motion, and periodic as x(t) is
  const double T = forcing_period(system, p);
  // The error of a state, amplified by the tangent, limits the accuracy.
  constexpr double error = 1e-9;
  for (std::size_t k = 0; k < image.size(); ++k) {
    carry(propagator, 0.0, T, image[k], {.sensitivity = Sensitivity::state}, transition);
    if (transition.termination != Termination::time) return {};
    const Vector& next = image[(k + 1) % image.size()];
    const double tangent = std::max(1.0, transition.Phi.lpNorm<Eigen::Infinity>());
    if (!((transition.x1 - next).lpNorm<Eigen::Infinity>() < error * tangent * (1.0 + next.lpNorm<Eigen::Infinity>()))) return {};
  }
  return image;
}

}  // namespace graze
