// SPDX-License-Identifier: GPL-3.0-or-later
// Derivative checks of whole systems, all through graze::check_jacobian. Each check returns one sentence per disagreement. A
// test requires an empty list:   REQUIRE_THAT(check_mode(...), all_agree());
#pragma once

#include <graze/lib/motion/transition.hpp>
#include <graze/lib/system/jacobian_check.hpp>

#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <numeric>
#include <random>

namespace graze::support {

using Violations = std::vector<std::string>;

/// Matches an empty list; otherwise prints its sentences.
class AllAgree : public Catch::MatcherBase<Violations> {
 public:
  bool match(const Violations& list) const override { return list.empty(); }
  std::string describe() const override { return "holds no violation"; }
};
inline AllAgree all_agree() { return {}; }

inline std::vector<std::size_t> all_parameters(const HybridSystem& system) {
  std::vector<std::size_t> list(system.parameters.size());
  std::iota(list.begin(), list.end(), std::size_t{0});
  return list;
}

inline Vector vector(std::initializer_list<double> values) {
  Vector v(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), v.data());
  return v;
}

/// Default parameters with some of them set by name.
inline Vector parameters(const HybridSystem& system, const std::vector<std::pair<const char*, double>>& set = {}) {
  Vector p = default_parameters(system.parameters);
  for (const auto& [name, value] : set) p[static_cast<Eigen::Index>(parameter_index(system.parameters, name))] = value;
  return p;
}

/// Fields and their values are sums of a few smooth terms. With a step of 2e-4 the extrapolated differences have a rounding
/// error of 1e-16 |f| / 2e-4 and a truncation error of h^4 d5f/dx5 / 120, each below 1e-10 for |f| and derivatives up to 100.
inline constexpr double field_step = 2e-4, field_tolerance = 1e-9;

inline void compare(Violations& list, const std::string& what, const std::function<Vector(const Vector&)>& f, const Vector& at,
                    const Matrix& jacobian, double step = field_step, double tolerance = field_tolerance) {
  const JacobianCheck check = check_jacobian(f, at, jacobian, step);
  if (!check.agrees(tolerance))
    list.push_back(fmt::format("{}: off by {:.3g}, differences good to {:.3g}: {}", what, check.disagreement,
                               check.error_estimate, check.message));
}

/// A function of (t, x, p) with `rows` entries and its three derivatives; a null derivative stands for zero.
inline void compare_all(Violations& list, const std::string& what, const VectorFunction& f, const MatrixFunction& dx,
                        const MatrixFunction& dp, const VectorFunction& dt, Eigen::Index rows, double t, const Vector& x,
                        const Vector& p) {
  const auto at = [&](double time, const Vector& state, const Vector& parameter) {
    Vector out(rows);
    f(time, state, parameter, out);
    return out;
  };
  Matrix J(rows, x.size()), Jp = Matrix::Zero(rows, p.size());
  Vector ft = Vector::Zero(rows);
  dx(t, x, p, J);
  if (dp) dp(t, x, p, Jp);
  if (dt) dt(t, x, p, ft);
  compare(
      list, what + " in x", [&](const Vector& z) { return at(t, z, p); }, x, J);
  compare(
      list, what + " in p", [&](const Vector& z) { return at(t, x, z); }, p, Jp);
  compare(
      list, what + " in t", [&](const Vector& z) { return at(z[0], x, p); }, Vector::Constant(1, t), ft);
}

/// The field of a mode at a point inside it.
inline Violations check_mode(const HybridSystem& system, std::size_t mode, double t, const Vector& x, const Vector& p) {
  Violations list;
  const Mode& m = system.modes[mode];
  compare_all(list, fmt::format("{}: field of mode {}", system.name, m.name), m.field, m.field_dx, m.field_dp, m.field_dt,
              x.size(), t, x, p);
  if (!m.structure) return list;
  const ModeStructure structure = m.structure(p);
  if (const auto* linear = std::get_if<LinearOscillator>(&structure)) {
    Matrix dp = linear->dp;
    const auto coefficients = [&](const Vector& z) {
      const ModeStructure there = m.structure(z);
      const auto* q = std::get_if<LinearOscillator>(&there);
      // The structure is no longer linear for beta != 0, and its derivative is then not requested.
      return q ? vector({q->damping, q->stiffness, q->amplitude, q->frequency, q->constant})
               : vector({linear->damping, linear->stiffness, linear->amplitude, linear->frequency, linear->constant});
    };
    compare(list, fmt::format("{}: coefficients of mode {}", system.name, m.name), coefficients, p, dp);
  }
  if (const auto* cubic = std::get_if<CubicOscillator>(&structure)) {
    const auto coefficients = [&](const Vector& z) {
      const ModeStructure there = m.structure(z);
      const auto& value = std::get<CubicOscillator>(there).value;
      return Vector(Eigen::Map<const Vector>(value.data(), static_cast<Eigen::Index>(value.size())));
    };
    Matrix dp = cubic->dp;
    compare(list, fmt::format("{}: coefficients of mode {}", system.name, m.name), coefficients, p, dp);
  }
  if (const auto* hertz = std::get_if<HertzContact>(&structure)) {
    Matrix dp = hertz->dp;
    const auto coefficients = [&](const Vector& z) {
      const ModeStructure there = m.structure(z);
      const auto& value = std::get<HertzContact>(there).value;
      return Vector(Eigen::Map<const Vector>(value.data(), static_cast<Eigen::Index>(value.size())));
    };
    compare(list, fmt::format("{}: coefficients of mode {}", system.name, m.name), coefficients, p, dp);
  }
  return list;
}

/// Guard, reset and accumulation point of an event at a point.
inline Violations check_event(const HybridSystem& system, std::size_t index, double t, const Vector& x, const Vector& p) {
  Violations list;
  const Event& event = system.events[index];
  const std::string name = fmt::format("{}: {} of event {}", system.name, "{}", event.name);
  const Guard& guard = event.guard;
  const auto value = [&](double time, const Vector& state, const Vector& parameter, Vector& out) {
    out[0] = guard.value(time, state, parameter);
  };
  const auto row = [](const VectorFunction& f) -> MatrixFunction {
    if (!f) return {};
    return [&f](double time, const Vector& state, const Vector& parameter, Matrix& out) {
      Vector g(out.cols());
      f(time, state, parameter, g);
      out.row(0) = g.transpose();
    };
  };
  VectorFunction dt;
  if (guard.dt)
    dt = [&](double time, const Vector& state, const Vector& parameter, Vector& out) {
      out[0] = guard.dt(time, state, parameter);
    };
  compare_all(list, fmt::format(fmt::runtime(name), "guard"), value, row(guard.dx), row(guard.dp), dt, 1, t, x, p);
  if (event.reset.map)
    compare_all(list, fmt::format(fmt::runtime(name), "reset"), event.reset.map, event.reset.dx, event.reset.dp, event.reset.dt,
                x.size(), t, x, p);
  if (event.accumulation) {
    const Reset& rest = event.accumulation->reset;
    compare_all(list, fmt::format(fmt::runtime(name), "accumulation point"), rest.map, rest.dx, rest.dp, rest.dt, x.size(), t, x,
                p);
  }
  return list;
}

/// Phi and Psi (every parameter) of the motion from (t0, x0) to t1, events included, against differences of the motion itself.
/// The differences must keep the same sequence of events: choose x0, and p inside its range, accordingly.
inline Violations check_transition(const HybridSystem& system, const Vector& p, double t0, double t1, const Vector& x0,
                                   double tolerance, double step = 1e-4, const FlowOptions& options = {}) {
  Violations list;
  Propagator propagator(system, p, all_parameters(system), options), probe(system, p, {}, options);
  Transition transition, moved;
  carry(propagator, t0, t1, x0, {.sensitivity = Sensitivity::state_and_parameters}, transition);
  if (transition.termination != Termination::time) {
    list.push_back(fmt::format("{}: {}", system.name, termination_text(transition.termination)));
    return list;
  }
  bool same_events = true;
  const auto end = [&](const Vector& x) -> Vector {
    carry(probe, t0, t1, x, {.sensitivity = Sensitivity::none}, moved);
    same_events = same_events && moved.termination == Termination::time && moved.event_sequence == transition.event_sequence;
    return moved.x1;
  };
  compare(list, system.name + ": Phi", end, x0, transition.Phi, step, tolerance);
  const auto end_at = [&](const Vector& q) {
    probe.set_parameters(q);
    return end(x0);
  };
  compare(list, system.name + ": Psi", end_at, p, transition.Psi, step, tolerance);
  if (!same_events) list.push_back(system.name + ": the differences leave the sequence of events; take another start");
  return list;
}

/// Uniform numbers from a fixed seed.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double operator()(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(engine_); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace graze::support
