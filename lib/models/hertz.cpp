// SPDX-License-Identifier: GPL-3.0-or-later
// Hertz and damped Hertz contact: F = k_H (x - r)^(3/2) (1 + b_H x') for x >= r (Serweta et al. 2014). State and field are
// continuous at x = r.
#include <graze/lib/models/laws.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/models/soft.hpp>

#include <cmath>

namespace graze {

namespace {

using namespace oscillator_parameter;
constexpr std::size_t k_H = law, b_H = law + 1;

/// Depth, clipped so that a stage just outside the contact does not take the root of a negative number.
double root_depth(const Vector& x, const Vector& p) { return std::sqrt(std::max(0.0, x[0] - p[r])); }

void attach(HybridSystem& system) {
  const Mode free = system.modes.front();
  Mode contact = free;
  contact.field = [free](double t, const Vector& x, const Vector& p, Vector& f) {
    free.field(t, x, p, f);
    const double y = root_depth(x, p);
    f[1] -= p[k_H] * y * y * y * (1.0 + p[b_H] * x[1]);
  };
  contact.field_dx = [free](double t, const Vector& x, const Vector& p, Matrix& J) {
    free.field_dx(t, x, p, J);
    const double y = root_depth(x, p);
    J(1, 0) -= 1.5 * p[k_H] * y * (1.0 + p[b_H] * x[1]);
    J(1, 1) -= p[k_H] * y * y * y * p[b_H];
  };
  contact.field_dp = [free](double t, const Vector& x, const Vector& p, Matrix& J) {
    free.field_dp(t, x, p, J);
    const double y = root_depth(x, p);
    J(1, r) += 1.5 * p[k_H] * y * (1.0 + p[b_H] * x[1]);
    J(1, k_H) = -y * y * y * (1.0 + p[b_H] * x[1]);
    J(1, b_H) = -p[k_H] * y * y * y * x[1];
  };
  contact.structure = [](const Vector& p) -> ModeStructure {
    HertzContact hertz;
    hertz.parameter = {b, beta, xi, eta, r, k_H, b_H};
    for (std::size_t i = 0; i < HertzContact::count; ++i) hertz.value[i] = p[static_cast<Eigen::Index>(hertz.parameter[i])];
    return hertz;
  };
  attach_soft_contact(system, std::move(contact));
}

}  // namespace

ContactLaw hertz_law() {
  const double infinity = std::numeric_limits<double>::infinity();
  ContactLaw law;
  law.name = "hertz";
  law.formula = "F = k_H (x - r)^(3/2) (1 + b_H x') for x >= r";
  law.parameters = {{"k_H", 100.0, 0.0, infinity, true, "dimensionless", "contact stiffness"},
                    {"b_H", 0.0, 0.0, infinity, false, "dimensionless", "contact damping (0: undamped Hertz)"}};
  law.attach = attach;
  return law;
}

}  // namespace graze
