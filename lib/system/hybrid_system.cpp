// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/system/hybrid_system.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace graze {

Guard make_level_guard(const LevelGuard& level) {
  const auto coordinate = static_cast<Eigen::Index>(level.coordinate);
  const auto parameter = static_cast<Eigen::Index>(level.level);
  const double sign = level.sign;
  Guard guard;
  guard.value = [=](double, const Vector& x, const Vector& p) { return sign * (x[coordinate] - p[parameter]); };
  guard.dx = [=](double, const Vector&, const Vector&, Vector& out) {
    out.setZero();
    out[coordinate] = sign;
  };
  guard.dp = [=](double, const Vector&, const Vector&, Vector& out) {
    out.setZero();
    out[parameter] = -sign;
  };
  guard.level = level;
  return guard;
}

Reset make_rebound(const Rebound& rebound) {
  const auto level = static_cast<Eigen::Index>(rebound.level), coefficient = static_cast<Eigen::Index>(rebound.coefficient);
  Reset reset;
  reset.map = [=](double, const Vector& x, const Vector& p, Vector& out) {
    const double after = -p[coefficient] * x[1];
    out[0] = p[level];
    out[1] = after;
  };
  reset.dx = [=](double, const Vector&, const Vector& p, Matrix& J) { J << 0.0, 0.0, 0.0, -p[coefficient]; };
  reset.dp = [=](double, const Vector& x, const Vector&, Matrix& J) {
    J.setZero();
    J(0, level) = 1.0;
    J(1, coefficient) = -x[1];
  };
  reset.rebound = rebound;
  return reset;
}

std::string_view event_kind_name(EventKind kind) {
  switch (kind) {
  case EventKind::impact:
    return "impact";
  case EventKind::enter:
    return "enter";
  case EventKind::leave:
    return "leave";
  case EventKind::stick:
    return "stick";
  case EventKind::release:
    return "release";
  case EventKind::other:
    break;
  }
  return "other";
}

bool has_hard_contacts(const HybridSystem& system) {
  return std::any_of(system.events.begin(), system.events.end(), [](const Event& event) { return !event.continuous; });
}

double forcing_period(const HybridSystem& system, const Vector& p) {
  if (!system.forcing_frequency)
    throw std::invalid_argument(fmt::format("system {} is autonomous; it has no forcing period", system.name));
  return 2.0 * std::numbers::pi / p[static_cast<Eigen::Index>(*system.forcing_frequency)];
}

Vector forcing_period_dp(const HybridSystem& system, const Vector& p) {
  Vector dp = Vector::Zero(p.size());
  const double period = forcing_period(system, p);
  const auto index = static_cast<Eigen::Index>(*system.forcing_frequency);
  dp[index] = -period / p[index];
  return dp;
}

void validate(const HybridSystem& system) {
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(fmt::format("system {}: {}", system.name, what));
  };
  if (system.states == 0) refuse("it has no states");
  if (system.modes.empty()) refuse("it has no modes");
  if (system.forcing_frequency && *system.forcing_frequency >= system.parameters.size())
    refuse("the forcing frequency is not one of its parameters");
  for (const Mode& mode : system.modes) {
    if (!mode.field) refuse(fmt::format("mode {} has no field", mode.name));
    if (!mode.field_dx) refuse(fmt::format("mode {} has no derivative of the field in x", mode.name));
    if (!mode.field_dp) refuse(fmt::format("mode {} has no derivative of the field in p", mode.name));
  }
  for (const Event& event : system.events) {
    if (event.from >= system.modes.size() || event.to >= system.modes.size())
      refuse(fmt::format("event {} leads from or to a mode that does not exist", event.name));
    if (!event.guard.value) refuse(fmt::format("event {} has no guard", event.name));
    if (!event.guard.dx) refuse(fmt::format("event {} has no derivative of the guard in x", event.name));
    if (event.reset.map && !event.reset.dx) refuse(fmt::format("event {} has no derivative of the reset in x", event.name));
    if (event.guard.level && event.guard.level->coordinate >= system.states)
      refuse(fmt::format("event {} watches a coordinate that does not exist", event.name));
    if (event.guard.level && event.guard.level->level >= system.parameters.size())
      refuse(fmt::format("event {} watches a level that is not a parameter", event.name));
    if (event.accumulation) {
      if (event.accumulation->sticking_mode >= system.modes.size())
        refuse(fmt::format("event {} accumulates in a mode that does not exist", event.name));
      if (!event.accumulation->reset.map || !event.accumulation->reset.dx)
        refuse(fmt::format("event {} has no reset (or no derivative of it) for its accumulation point", event.name));
    }
  }
}

std::optional<std::size_t> mode_at(const HybridSystem& system, double t, const Vector& x, const Vector& p) {
  if (!x.allFinite()) return std::nullopt;
  return system.initial_mode ? system.initial_mode(t, x, p) : 0;
}

std::size_t initial_mode(const HybridSystem& system, double t, const Vector& x, const Vector& p) {
  if (static_cast<std::size_t>(x.size()) != system.states)
    throw std::invalid_argument(fmt::format("the state has {} entries; system {} has {}", x.size(), system.name, system.states));
  if (!x.allFinite()) throw std::invalid_argument("the state holds a value that is not a finite number");
  const std::optional<std::size_t> mode = mode_at(system, t, x, p);
  if (!mode)
    throw std::invalid_argument(
        fmt::format("the state ({}) lies inside the barrier; start on the free side of it", fmt::join(x, ", ")));
  return *mode;
}

}  // namespace graze
