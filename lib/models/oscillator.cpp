// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/models/oscillator.hpp>

#include <cmath>
#include <stdexcept>

namespace graze {

using namespace oscillator_parameter;

const std::vector<ParameterInfo>& oscillator_parameters() {
  static const std::vector<ParameterInfo> list = [] {
    const double infinity = std::numeric_limits<double>::infinity();
    std::vector<ParameterInfo> p(law);
    p[b] = {"b", 0.05, 0.0, infinity, false, "dimensionless", "damping ratio, c / (2 sqrt(k m))"};
    p[beta] = {"beta", 0.0, -infinity, infinity, false, "dimensionless", "cubic stiffness (36/35 for the cantilever)"};
    p[xi] = {"xi", 1.0, -infinity, infinity, false, "dimensionless", "forcing amplitude"};
    p[eta] = {"eta", 0.95, 0.0, infinity, true, "dimensionless", "forcing frequency over the natural one; T = 2 pi / eta"};
    p[r] = {"r", 2.0, -infinity, infinity, false, "dimensionless", "clearance: the barrier is at x = r"};
    return p;
  }();
  return list;
}

const std::vector<OscillatorKind>& oscillator_kinds() {
  static const std::vector<OscillatorKind> list = {
      {"linear", "x'' + 2 b x' + x + F = xi cos(eta tau)", 0.0},
      {"cantilever", "x'' + 2 b x' + x + beta x^3 + F = xi cos(eta tau), beta = 36/35", 36.0 / 35.0},
  };
  return list;
}

const OscillatorKind& oscillator_kind(std::string_view name) {
  std::vector<std::string> names;
  for (const OscillatorKind& kind : oscillator_kinds()) {
    if (kind.name == name) return kind;
    names.push_back(kind.name);
  }
  throw std::invalid_argument(unknown_name("oscillator", name, names));
}

double barrier_acceleration(double t, const Vector& p) {
  return p[xi] * std::cos(p[eta] * t) - p[r] - p[beta] * p[r] * p[r] * p[r];
}

namespace {

Mode free_mode() {
  Mode mode;
  mode.name = "free";
  mode.field = [](double t, const Vector& x, const Vector& p, Vector& f) {
    f[0] = x[1];
    f[1] = p[xi] * std::cos(p[eta] * t) - 2.0 * p[b] * x[1] - x[0] - p[beta] * x[0] * x[0] * x[0];
  };
  mode.field_dx = [](double, const Vector& x, const Vector& p, Matrix& J) {
    J << 0.0, 1.0, -1.0 - 3.0 * p[beta] * x[0] * x[0], -2.0 * p[b];
  };
  mode.field_dp = [](double t, const Vector& x, const Vector& p, Matrix& J) {
    J.setZero();
    J(1, b) = -2.0 * x[1];
    J(1, beta) = -x[0] * x[0] * x[0];
    J(1, xi) = std::cos(p[eta] * t);
    J(1, eta) = -p[xi] * t * std::sin(p[eta] * t);
  };
  mode.field_dt = [](double t, const Vector&, const Vector& p, Vector& f) {
    f[0] = 0.0;
    f[1] = -p[xi] * p[eta] * std::sin(p[eta] * t);
  };
  mode.structure = [](const Vector& p) -> ModeStructure {
    if (p[beta] != 0.0) {
      using C = CubicOscillator;
      C cubic{{p[b], 1.0, p[beta], p[xi], p[eta], 0.0}, Matrix::Zero(C::count, p.size())};
      cubic.dp(C::damping, b) = cubic.dp(C::cubic, beta) = cubic.dp(C::amplitude, xi) = cubic.dp(C::frequency, eta) = 1.0;
      return cubic;
    }
    LinearOscillator linear;
    linear.damping = p[b];
    linear.amplitude = p[xi];
    linear.frequency = p[eta];
    linear.dp = Matrix::Zero(5, p.size());
    linear.dp(0, b) = linear.dp(2, xi) = linear.dp(3, eta) = 1.0;
    linear.not_differentiable_in = {beta};
    return linear;
  };
  return mode;
}

}  // namespace

HybridSystem make_oscillator(const OscillatorKind& kind, const ContactLaw& law) {
  HybridSystem system;
  system.name = kind.name + "-" + law.name;
  system.states = 2;
  system.parameters = oscillator_parameters();
  system.parameters[beta].default_value = kind.beta;
  system.parameters.insert(system.parameters.end(), law.parameters.begin(), law.parameters.end());
  system.forcing_frequency = eta;
  system.modes.push_back(free_mode());
  law.attach(system);
  validate(system);
  return system;
}

Vector steady_response(const Vector& p) {
  const double w = p[eta], stiffness = 1.0 - w * w, damping = 2.0 * p[b] * w;
  return p[xi] / (stiffness * stiffness + damping * damping) * Vector{{stiffness, damping * w}};
}

}  // namespace graze
