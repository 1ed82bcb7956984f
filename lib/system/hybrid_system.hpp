// SPDX-License-Identifier: GPL-3.0-or-later
// HybridSystem: named modes (each with a field) and events (each with a guard and a reset), as a plain value.
//
// In mode m the state obeys x' = f_m(t, x, p). An event of that mode fires where its guard h(t, x, p) crosses zero from below;
// then x+ = g(t, x-, p) and the mode becomes the event's target.
//
// Trigger rule (h- just before, h+ just after an instant t in (t0, t1], the step being half open on the left):
//     h- <  0, h+ >= 0                       fires
//     h  = 0 at the start, dh/dt >  0        fires at once (initially active guard)
//     h  = 0 at the start, dh/dt <  0        does not fire (this is how a reset leaves the barrier)
//     h  = 0 at the start, dh/dt =  0        fires at once if h rises right after (dh/dt > 0 a millionth later), else does not
//     h touches 0 from below and turns back  does not fire (tangency)
// Simultaneous events fire one after the other, in the order of their declaration. An event exactly at the end time of a run
// fires. "h = 0" and "dh/dt = 0" hold up to rounding: guard_tolerance and rest_tolerance. An event must leave its guard (by its
// reset or by its target mode): no state stays beyond a guard of its mode.
//
// The system knows no solver. The numbers of states, modes and events are arbitrary. A forced system names the parameter that
// is its forcing frequency (period T = 2 pi / frequency), or gives its period as a function of p; an autonomous system does
// neither.
#pragma once

#include <graze/lib/system/mode_structure.hpp>
#include <graze/lib/system/parameters.hpp>

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace graze {

/// A state lies on a guard if |h| <= guard_tolerance (1 + |x|), in the guard's own units (guard_width): a hundred times the
/// rounding error of an event's instant.
inline constexpr double guard_tolerance = 1e-12;
/// A motion without forcing that returns after the time T rests at an equilibrium if |f| T <= equilibrium_tolerance (1 + |x|): so
/// near to one, returns and orbits cannot be told from it.
inline constexpr double equilibrium_tolerance = 1e-8;
inline bool is_at_equilibrium(const Vector& f, double T, const Vector& x) {
  return f.lpNorm<Eigen::Infinity>() * T <= equilibrium_tolerance * (1.0 + x.lpNorm<Eigen::Infinity>());
}
/// It rests there if |dh/dt| <= rest_tolerance (1 + |f|), in these units (rests); then the sign of dh/dt a time rest_glance
/// time_unit() later decides.
inline constexpr double rest_tolerance = 1e-15, rest_glance = 1e-6;

/// out = function of (t, x, p); `out` has the right size before the call.
using VectorFunction = std::function<void(double t, const Vector& x, const Vector& p, Vector& out)>;
using MatrixFunction = std::function<void(double t, const Vector& x, const Vector& p, Matrix& out)>;
using ScalarFunction = std::function<double(double t, const Vector& x, const Vector& p)>;

/// A scalar that vanishes throughout a sticking or sliding mode. The fields on either side drive a small disturbance back along
/// `direction`, in a time proportional to it: its multiplier is zero.
struct Constraint {
  std::size_t number = 0;    ///< the same in all modes that preserve it
  ScalarFunction value;      ///< zero in the mode
  VectorFunction dx;         ///< gradient in x (n)
  VectorFunction dp;         ///< gradient in p; empty: does not depend on p
  VectorFunction direction;  ///< (n)
};

/// A mode: field f (n) and its derivatives in x (n x n), p (n x number of parameters) and t (n).
struct Mode {
  std::string name;
  VectorFunction field;
  MatrixFunction field_dx;
  MatrixFunction field_dp;
  VectorFunction field_dt;  ///< empty: the field does not depend on t
  StructureAt structure;    ///< empty: no structure is known
  std::vector<Constraint> constraints = {};
};

/// Guard h = sign (x[coordinate] - p[level]), marked because the fast flows bound the motion against it. validate() compares it
/// with Guard::value.
struct LevelGuard {
  std::size_t coordinate = 0;
  std::size_t level = 0;  ///< index of the parameter
  double sign = 1.0;
};

/// A scalar guard and its derivatives. make_level_guard builds it from a LevelGuard.
struct Guard {
  ScalarFunction value;
  VectorFunction dx;  ///< gradient in x (n)
  VectorFunction dp;  ///< gradient in p; empty: does not depend on p
  ScalarFunction dt;  ///< empty: does not depend on t
  std::optional<LevelGuard> level;
};

Guard make_level_guard(const LevelGuard& level);

/// Reset of an impact with restitution: x+ = p[level] for the coordinate, v+ = -p[coefficient] v- for its velocity; all other
/// states stay. Marked because the SIMD lanes have code for it.
struct Rebound {
  std::size_t coordinate = 0;   ///< index of the state
  std::size_t velocity = 1;     ///< index of the state
  std::size_t level = 0;        ///< index of the parameter
  std::size_t coefficient = 0;  ///< index of the parameter
};

/// A reset x+ = g(t, x-, p); empty `map` means the identity. make_rebound builds it from a Rebound.
struct Reset {
  VectorFunction map;
  MatrixFunction dx;
  MatrixFunction dp;               ///< empty: zero
  VectorFunction dt;               ///< empty: zero
  std::optional<Rebound> rebound;  ///< validate() compares it with `map`
};

Reset make_rebound(const Rebound& rebound);

enum class EventKind { impact, enter, leave, stick, release, other };

/// True for an impact and for an entry into contact: each counts as one impact.
constexpr bool begins_contact(EventKind kind) { return kind == EventKind::impact || kind == EventKind::enter; }

/// "impact", "enter", ...
std::string_view event_kind_name(EventKind kind);

/// Infinitely many impacts in finite time (k_r < 1): continuation of the run from the accumulation point.
struct Accumulation {
  std::size_t sticking_mode = 0;
  Reset reset;  ///< state at the accumulation point, for example (r, 0)
  /// Second derivative of the guard along the motion after an impact: the pressing acceleration. Empty: taken from the field,
  /// which is valid for a flat barrier at rest.
  ScalarFunction pressing = {};
};

/// Two events of a mode may share a guard. If `condition` is not positive on the guard, `event` fires instead of the event that
/// holds this: a motion that meets a surface either slides on it or passes through.
struct Alternative {
  ScalarFunction condition;
  std::size_t event = 0;  ///< index in HybridSystem::events, after the event that holds this
};

/// An event: guard, reset and target mode.
struct Event {
  std::string name;
  std::size_t from = 0;
  std::size_t to = 0;
  EventKind kind = EventKind::other;
  Guard guard;
  Reset reset;
  /// True if state *and* field are continuous across the guard: the saltation matrix is then the identity, at grazing too.
  bool continuous = false;
  std::optional<Accumulation> accumulation;
  std::optional<Alternative> otherwise = {};
  /// Effective mass m at the barrier, m = 1 / (W^T M^-1 W) with the gap's gradient W: energies are m (normal speed)^2 / 2.
  /// Empty: m = 1, and energies are per unit mass.
  ScalarFunction effective_mass;
  /// The rate at which the gap opens, for an event that ends a soft contact and for an impact. Empty: the guard tells it.
  ScalarFunction opening_rate = {};
  /// ln|det S| if the contact law provides it (Newton: ln k_r^2), for Liouville's identity; empty: computed from S.
  std::function<double(const Vector& p)> log_volume_change;
};

/// The mode a state belongs to at time t; nullopt: the state is not admissible (inside a hard barrier).
using InitialMode = std::function<std::optional<std::size_t>(double t, const Vector& x, const Vector& p)>;

/// Forcing period T(p) and its gradient (number of parameters), for systems without a frequency parameter.
struct ForcingPeriod {
  std::function<double(const Vector& p)> value;
  std::function<void(const Vector& p, Vector& out)> dp;
};

struct HybridSystem {
  std::string name;
  std::size_t states = 0;
  std::vector<std::string> state_names;  ///< empty: x, v for two states, else x1, x2, ...
  std::vector<ParameterInfo> parameters;
  std::vector<Mode> modes;
  std::vector<Event> events;
  std::optional<std::size_t> forcing_frequency;  ///< index of the parameter; nullopt: autonomous, or with a period of its own
  InitialMode initial_mode;                      ///< empty: mode 0 always
  std::optional<ForcingPeriod> period;           ///< instead of forcing_frequency
  std::vector<std::size_t> returns;              ///< events that end a period of an autonomous system; empty: see returns_of()
};

/// True if the state or its field jumps where some contact begins, or the state jumps at an event without a kind: the orbits on
/// the two sides of a grazing are then different families. Friction that holds a body, or changes sign with its motion, is no
/// contact.
bool has_hard_contacts(const HybridSystem& system);

/// True if the system is periodically forced; otherwise it is autonomous.
inline bool is_forced(const HybridSystem& system) { return system.forcing_frequency || system.period; }

/// Forcing period: 2 pi / frequency, or the system's own. @throws std::invalid_argument for an autonomous system.
double forcing_period(const HybridSystem& system, const Vector& p);

/// The unit of rest_glance, and of FlowOptions::accumulation_window where it is below 1: T / (2 pi), at most 1000; 1 without
/// forcing.
double time_unit(const HybridSystem& system, const Vector& p);

/// dT/dp (number of parameters).
Vector forcing_period_dp(const HybridSystem& system, const Vector& p);

/// Number of impacts and entries into contact in a sequence of events (indices).
int contacts_among(const std::vector<std::size_t>& events, const HybridSystem& system);

/// The events that count as returns of an autonomous system; a return replaces the forcing period. HybridSystem::returns, or
/// else the events that begin a contact, or else those that begin to stick, or else all.
std::vector<std::size_t> returns_of(const HybridSystem& system);

/// Names of the states, one each.
std::vector<std::string> state_names(const HybridSystem& system);

/// Checks the consistency of the parts: sizes, presence of derivatives, existence of targets, and agreement of the tags
/// (LevelGuard, Rebound, Event::continuous, Mode::structure) with the functions at states near the guard. @throws
/// std::invalid_argument in one sentence.
void validate(const HybridSystem& system);

/// Whether state and field are continuous across an event with a level guard, by samples on the guard.
bool is_continuous(const HybridSystem& system, const Event& event);

/// The mode that `x` belongs to; nullopt: no motion begins there, because `x` is not finite or lies inside a barrier.
std::optional<std::size_t> mode_at(const HybridSystem& system, double t, const Vector& x, const Vector& p);

/// The mode that `x` belongs to. @throws std::invalid_argument if the state is not finite, has the wrong size or is not
/// admissible.
std::size_t initial_mode(const HybridSystem& system, double t, const Vector& x, const Vector& p);

}  // namespace graze
