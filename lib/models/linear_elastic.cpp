// SPDX-License-Identifier: GPL-3.0-or-later
// Linear elastic stop: F = k_S (x - r) for x >= r. State and field are continuous at x = r.
#include <graze/lib/models/laws.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/models/soft.hpp>

namespace graze {

namespace {

using namespace oscillator_parameter;
constexpr std::size_t k_S = law;

void attach(HybridSystem& system) {
  const Mode free = system.modes.front();
  Mode contact = free;
  contact.field = [free](double t, const Vector& x, const Vector& p, Vector& f) {
    free.field(t, x, p, f);
    f[1] -= p[k_S] * (x[0] - p[r]);
  };
  contact.field_dx = [free](double t, const Vector& x, const Vector& p, Matrix& J) {
    free.field_dx(t, x, p, J);
    J(1, 0) -= p[k_S];
  };
  contact.field_dp = [free](double t, const Vector& x, const Vector& p, Matrix& J) {
    free.field_dp(t, x, p, J);
    J(1, r) += p[k_S];
    J(1, k_S) = -(x[0] - p[r]);
  };
  contact.structure = [free](const Vector& p) -> ModeStructure {
    ModeStructure structure = free.structure(p);
    if (auto* linear = std::get_if<LinearOscillator>(&structure)) {
      linear->stiffness += p[k_S];
      linear->constant = p[k_S] * p[r];
      linear->dp(1, k_S) = 1.0;
      linear->dp(4, k_S) = p[r];
      linear->dp(4, r) = p[k_S];
    } else if (auto* cubic = std::get_if<CubicOscillator>(&structure)) {
      using C = CubicOscillator;
      cubic->value[C::stiffness] += p[k_S];
      cubic->value[C::constant] = p[k_S] * p[r];
      cubic->dp(C::stiffness, k_S) = 1.0;
      cubic->dp(C::constant, k_S) = p[r];
      cubic->dp(C::constant, r) = p[k_S];
    }
    return structure;
  };
  attach_soft_contact(system, std::move(contact));
}

}  // namespace

ContactLaw linear_elastic_law() {
  ContactLaw law;
  law.name = "linear";
  law.formula = "F = k_S (x - r) for x >= r";
  law.parameters = {
      {"k_S", 25.0, 0.0, std::numeric_limits<double>::infinity(), true, "dimensionless", "stiffness of the elastic stop"}};
  law.attach = attach;
  return law;
}

}  // namespace graze
