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
  const auto coordinate = static_cast<Eigen::Index>(rebound.coordinate), velocity = static_cast<Eigen::Index>(rebound.velocity);
  Reset reset;
  reset.map = [=](double, const Vector& x, const Vector& p, Vector& out) {
    const double after = -p[coefficient] * x[velocity];
    out = x;
    out[coordinate] = p[level];
    out[velocity] = after;
  };
  reset.dx = [=](double, const Vector&, const Vector& p, Matrix& J) {
    J.setIdentity();
    J(coordinate, coordinate) = 0.0;
    J(velocity, velocity) = -p[coefficient];
  };
  reset.dp = [=](double, const Vector& x, const Vector&, Matrix& J) {
    J.setZero();
    J(coordinate, level) = 1.0;
    J(velocity, coefficient) = -x[velocity];
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
  return std::any_of(system.events.begin(), system.events.end(), [](const Event& event) {
    return !event.continuous && (begins_contact(event.kind) || (event.kind == EventKind::other && event.reset.map));
  });
}

double forcing_period(const HybridSystem& system, const Vector& p) {
  if (system.period) return system.period->value(p);
  if (!system.forcing_frequency)
    throw std::invalid_argument(fmt::format("system {} is autonomous; it has no forcing period", system.name));
  return 2.0 * std::numbers::pi / p[static_cast<Eigen::Index>(*system.forcing_frequency)];
}

double time_unit(const HybridSystem& system, const Vector& p) {
  constexpr double longest = 1000.0;  // the forcing may be far slower than the motion
  return is_forced(system) ? std::min(longest, forcing_period(system, p) / (2.0 * std::numbers::pi)) : 1.0;
}

Vector forcing_period_dp(const HybridSystem& system, const Vector& p) {
  Vector dp = Vector::Zero(p.size());
  if (system.period) {
    system.period->dp(p, dp);
    return dp;
  }
  const double period = forcing_period(system, p);
  const auto index = static_cast<Eigen::Index>(*system.forcing_frequency);
  dp[index] = -period / p[index];
  return dp;
}

int contacts_among(const std::vector<std::size_t>& events, const HybridSystem& system) {
  return static_cast<int>(
      std::count_if(events.begin(), events.end(), [&](std::size_t event) { return begins_contact(system.events[event].kind); }));
}

std::vector<std::size_t> returns_of(const HybridSystem& system) {
  if (!system.returns.empty()) return system.returns;
  std::vector<std::size_t> contacts, sticking, all;
  for (std::size_t i = 0; i < system.events.size(); ++i) {
    if (begins_contact(system.events[i].kind)) contacts.push_back(i);
    if (system.events[i].kind == EventKind::stick) sticking.push_back(i);
    all.push_back(i);
  }
  return !contacts.empty() ? contacts : !sticking.empty() ? sticking : all;
}

std::vector<std::string> state_names(const HybridSystem& system) {
  if (!system.state_names.empty()) return system.state_names;
  if (system.states == 2) return {"x", "v"};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < system.states; ++i) names.push_back(fmt::format("x{}", i + 1));
  return names;
}

namespace {

/// Compares the tags with the functions at a few states. Values that are not finite count as agreement.
class TagCheck {
 public:
  explicit TagCheck(const HybridSystem& system) : system_(system), p_(default_parameters(system.parameters)) {
    // Values away from defaults such as 0 and 1, at which different functions may agree.
    for (std::size_t i = 0; i < system.parameters.size(); ++i) {
      const ParameterInfo& info = system.parameters[i];
      const double value = info.default_value + 0.01 * static_cast<double>(i + 1) * (1.0 + std::abs(info.default_value));
      const double other = 2.0 * info.default_value - value;
      if (value < info.upper) {
        p_[static_cast<Eigen::Index>(i)] = value;
      } else if (other > info.lower) {
        p_[static_cast<Eigen::Index>(i)] = other;
      }
    }
  }

  bool guard_agrees(const Guard& guard) const {
    return everywhere([&](double t, const Vector& x) {
      const LevelGuard& level = *guard.level;
      return same(guard.value(t, x, p_), level.sign * (x[index(level.coordinate)] - p_[index(level.level)]));
    });
  }

  /// Compares on the guard only: a reset need not be valid elsewhere.
  bool rebound_agrees(const Event& event) const {
    const Reset& reset = event.reset;
    const Reset built = make_rebound(*reset.rebound);
    return everywhere([&](double t, Vector x) {
      if (event.guard.level) x[index(event.guard.level->coordinate)] = p_[index(event.guard.level->level)];
      Vector here = x, there = x;
      reset.map(t, x, p_, here);
      built.map(t, x, p_, there);
      return same(here, there);
    });
  }

  bool is_continuous(const Event& event) const {
    return everywhere([&](double t, Vector x) {
      x[index(event.guard.level->coordinate)] = p_[index(event.guard.level->level)];
      Vector after = x;
      if (event.reset.map) event.reset.map(t, x, p_, after);
      return same(after, x) && same(field(event.from, t, x), field(event.to, t, after));
    });
  }

  bool structure_agrees(std::size_t mode) const {
    const ModeStructure structure = system_.modes[mode].structure(p_);
    if (std::holds_alternative<GeneralField>(structure)) return true;
    if (system_.states != 2) return false;
    return everywhere([&](double t, Vector x) {
      // A state in contact: Hertz's law is valid on one side of the barrier only.
      if (const auto* hertz = std::get_if<HertzContact>(&structure)) x[0] = hertz->value[HertzContact::barrier] + std::abs(x[0]);
      return same(field(mode, t, x), Vector{{x[1], std::visit([&](const auto& s) { return acceleration(s, t, x); }, structure)}});
    });
  }

 private:
  static Eigen::Index index(std::size_t i) { return static_cast<Eigen::Index>(i); }

  static bool same(double a, double b) {
    constexpr double rounding = 1e-9;
    return !std::isfinite(a) || !std::isfinite(b) || std::abs(a - b) <= rounding * (1.0 + std::max(std::abs(a), std::abs(b)));
  }
  static bool same(const Vector& a, const Vector& b) {
    for (Eigen::Index i = 0; i < a.size(); ++i)
      if (!same(a[i], b[i])) return false;
    return true;
  }

  template <class Agrees> bool everywhere(const Agrees& agrees) const {
    for (const double t : {0.37, 2.9}) {
      Vector x(index(system_.states));
      for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = std::cos(1.3 * static_cast<double>(i + 1) + t);
      if (!agrees(t, x)) return false;
    }
    return true;
  }

  Vector field(std::size_t mode, double t, const Vector& x) const {
    Vector f = Vector::Zero(x.size());
    system_.modes[mode].field(t, x, p_, f);
    return f;
  }

  static double acceleration(const GeneralField&, double, const Vector&) { return 0.0; }
  static double acceleration(const LinearOscillator& s, double t, const Vector& x) {
    return s.amplitude * std::cos(s.frequency * t) + s.constant - 2.0 * s.damping * x[1] - s.stiffness * x[0];
  }
  static double acceleration(const CubicOscillator& s, double t, const Vector& x) {
    using C = CubicOscillator;
    return s.value[C::amplitude] * std::cos(s.value[C::frequency] * t) + s.value[C::constant] - 2.0 * s.value[C::damping] * x[1] -
           s.value[C::stiffness] * x[0] - s.value[C::cubic] * x[0] * x[0] * x[0];
  }
  static double acceleration(const HertzContact& s, double t, const Vector& x) {
    using C = HertzContact;
    const double depth = x[0] - s.value[C::barrier];
    return s.value[C::amplitude] * std::cos(s.value[C::frequency] * t) - 2.0 * s.value[C::damping] * x[1] - x[0] -
           s.value[C::beta] * x[0] * x[0] * x[0] -
           s.value[C::stiffness] * depth * std::sqrt(depth) * (1.0 + s.value[C::contact_damping] * x[1]);
  }

  const HybridSystem& system_;
  Vector p_;
};

}  // namespace

void validate(const HybridSystem& system) {
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(fmt::format("system {}: {}", system.name, what));
  };
  if (system.states == 0) refuse("it has no states");
  if (!system.state_names.empty() && system.state_names.size() != system.states)
    refuse(fmt::format("it names {} of its {} states", system.state_names.size(), system.states));
  if (system.modes.empty()) refuse("it has no modes");
  if (system.forcing_frequency && *system.forcing_frequency >= system.parameters.size())
    refuse("the forcing frequency is not one of its parameters");
  if (system.forcing_frequency && system.period) refuse("it has both a forcing frequency and a period of its own");
  if (system.period && (!system.period->value || !system.period->dp)) refuse("its period or the derivative of it is missing");
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
    if (event.otherwise) {
      if (!event.otherwise->condition) refuse(fmt::format("event {} has an alternative without a condition", event.name));
      const std::size_t other = event.otherwise->event, own = static_cast<std::size_t>(&event - system.events.data());
      if (other <= own || other >= system.events.size() || system.events[other].from != event.from)
        refuse(fmt::format("the alternative of event {} is no later event of its mode", event.name));
    }
    if (event.accumulation) {
      if (event.accumulation->sticking_mode >= system.modes.size())
        refuse(fmt::format("event {} accumulates in a mode that does not exist", event.name));
      if (!event.accumulation->reset.map || !event.accumulation->reset.dx)
        refuse(fmt::format("event {} has no reset (or no derivative of it) for its accumulation point", event.name));
    }
    if (event.reset.rebound) {
      const Rebound& rebound = *event.reset.rebound;
      if (rebound.coordinate >= system.states || rebound.velocity >= system.states || rebound.coordinate == rebound.velocity)
        refuse(fmt::format("event {} rebounds in states that do not exist", event.name));
      if (rebound.level >= system.parameters.size() || rebound.coefficient >= system.parameters.size())
        refuse(fmt::format("event {} rebounds by parameters that do not exist", event.name));
      if (!event.guard.level || event.guard.level->coordinate != rebound.coordinate || event.guard.level->level != rebound.level)
        refuse(fmt::format("event {} rebounds at another level than its guard watches", event.name));
    }
  }
  const TagCheck tags(system);
  for (std::size_t mode = 0; mode < system.modes.size(); ++mode)
    if (system.modes[mode].structure && !tags.structure_agrees(mode))
      refuse(fmt::format("the structure given for mode {} is not that of its field", system.modes[mode].name));
  for (const Event& event : system.events) {
    if (event.guard.level && !tags.guard_agrees(event.guard))
      refuse(fmt::format("the level given for event {} is not that of its guard", event.name));
    if (event.reset.rebound && !(event.reset.map && tags.rebound_agrees(event)))
      refuse(fmt::format("the rebound given for event {} is not its reset", event.name));
    if (event.continuous && event.guard.level && !tags.is_continuous(event))
      refuse(fmt::format("event {} is called continuous, but state or field jumps at its guard", event.name));
  }
}

bool is_continuous(const HybridSystem& system, const Event& event) { return TagCheck(system).is_continuous(event); }

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
