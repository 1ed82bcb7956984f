// SPDX-License-Identifier: GPL-3.0-or-later
// HybridSystem: named modes (a field each) and events (guard and reset as a pair), as a plain value.
//
// In mode m the state obeys x' = f_m(t, x, p). An event of that mode fires where its guard h(t, x, p) crosses zero from
// below; then x+ = g(t, x-, p) and the mode becomes the event's target.
//
// Trigger rule (h- just before, h+ just after an instant t in (t0, t1], the step being half open on the left):
//     h- <  0, h+ >= 0                       fires
//     h  = 0 at the start, dh/dt >  0        fires at once (initially active guard)
//     h  = 0 at the start, dh/dt <  0        does not fire (this is how a reset leaves the barrier)
//     h  = 0 at the start, dh/dt =  0        fires at once if h rises right after (dh/dt > 0 a millionth later), else does not
//     h touches 0 from below and turns back  does not fire (tangency)
// Events that fall on the same instant fire one after the other in the order in which they are declared.
// An event exactly at the end time of a run fires. "h = 0" and "dh/dt = 0" are meant up to rounding: guard_tolerance and
// rest_tolerance. An event must leave its guard (by its reset or by its target mode): nothing stays beyond a guard in its mode.
//
// The system knows no solver. It has any number of states, modes and events; forced systems name the parameter that is
// their forcing frequency (period T = 2 pi / frequency) or give their period as a function of p, autonomous ones do neither.
#pragma once

#include <graze/lib/system/mode_structure.hpp>
#include <graze/lib/system/parameters.hpp>

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace graze {

/// A state lies on a guard if |h| <= guard_tolerance (1 + |x|): a hundred times the rounding of an event's instant.
inline constexpr double guard_tolerance = 1e-12;
/// It rests there if |dh/dt| <= rest_tolerance (1 + |f|); what h does this much time later then decides.
inline constexpr double rest_tolerance = 1e-15, rest_glance = 1e-6;

/// out = function of (t, x, p); `out` has its size already.
using VectorFunction = std::function<void(double t, const Vector& x, const Vector& p, Vector& out)>;
using MatrixFunction = std::function<void(double t, const Vector& x, const Vector& p, Matrix& out)>;
using ScalarFunction = std::function<double(double t, const Vector& x, const Vector& p)>;

/// What vanishes all along a mode that sticks or slides. The fields beside it press a small disturbance back along `direction` in
/// a time in proportion to it: its multiplier is zero.
struct Constraint {
  std::size_t number = 0;    ///< the same in all modes that keep it
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
  StructureAt structure;    ///< empty: nothing is known of it
  std::vector<Constraint> constraints = {};
};

/// Guard h = sign (x[coordinate] - p[level]), told apart because the fast flows bound the motion against it. validate() holds it
/// against Guard::value.
struct LevelGuard {
  std::size_t coordinate = 0;
  std::size_t level = 0;  ///< index of the parameter
  double sign = 1.0;
};

/// A scalar guard and its derivatives. make_level_guard builds all of it from a LevelGuard.
struct Guard {
  ScalarFunction value;
  VectorFunction dx;  ///< gradient in x (n)
  VectorFunction dp;  ///< gradient in p; empty: does not depend on p
  ScalarFunction dt;  ///< empty: does not depend on t
  std::optional<LevelGuard> level;
};

Guard make_level_guard(const LevelGuard& level);

/// Reset of an impact with restitution: x+ = p[level] of the coordinate, v+ = -p[coefficient] v- of its velocity, all other
/// states stay. Told apart because the lanes know it.
struct Rebound {
  std::size_t coordinate = 0;   ///< index of the state
  std::size_t velocity = 1;     ///< index of the state
  std::size_t level = 0;        ///< index of the parameter
  std::size_t coefficient = 0;  ///< index of the parameter
};

/// A reset x+ = g(t, x-, p); empty `map` means the identity. make_rebound builds all of it from a Rebound.
struct Reset {
  VectorFunction map;
  MatrixFunction dx;
  MatrixFunction dp;               ///< empty: zero
  VectorFunction dt;               ///< empty: zero
  std::optional<Rebound> rebound;  ///< validate() holds it against `map`
};

Reset make_rebound(const Rebound& rebound);

enum class EventKind { impact, enter, leave, stick, release, other };

/// An impact, or an entry into contact: what counts as one impact.
constexpr bool begins_contact(EventKind kind) { return kind == EventKind::impact || kind == EventKind::enter; }

/// "impact", "enter", ...
std::string_view event_kind_name(EventKind kind);

/// Infinitely many impacts in finite time (k_r < 1): where the run goes on from the accumulation point.
struct Accumulation {
  std::size_t sticking_mode = 0;
  Reset reset;  ///< state at the accumulation point, for example (r, 0)
  /// Second derivative of the guard along the motion after an impact: the pressing acceleration. Empty: taken from the field, for
  /// a flat barrier at rest.
  ScalarFunction pressing = {};
};

/// Two events of a mode may share a guard. Where `condition` is not positive on the guard, `event` fires instead of the event
/// that holds this: a motion that meets a surface either goes on in a sliding mode or passes.
struct Alternative {
  ScalarFunction condition;
  std::size_t event = 0;  ///< index in HybridSystem::events, behind the event that holds this
};

/// Guard, reset and target mode as one.
struct Event {
  std::string name;
  std::size_t from = 0;
  std::size_t to = 0;
  EventKind kind = EventKind::other;
  Guard guard;
  Reset reset;
  /// True where state *and* field are continuous across the guard: the saltation matrix is then the identity, at grazing too.
  bool continuous = false;
  std::optional<Accumulation> accumulation;
  std::optional<Alternative> otherwise = {};
  /// Mass that meets the barrier, 1 / (W^T M^-1 W) with the gap's gradient W: energies are half of it times normal speeds
  /// squared. Empty: 1, energies are then per unit mass.
  ScalarFunction effective_mass;
  /// Of an event that ends a soft contact: the rate at which its gap opens. Empty: the rate of the guard, which is the gap.
  ScalarFunction opening_rate = {};
  /// ln|det S| where a law knows it (Newton: ln k_r^2), for Liouville's identity; empty: taken from S.
  std::function<double(const Vector& p)> log_volume_change;
};

/// The mode a state belongs to at time t; nullopt: the state is not admissible (inside a hard barrier).
using InitialMode = std::function<std::optional<std::size_t>(double t, const Vector& x, const Vector& p)>;

/// Forcing period T(p) and its gradient (number of parameters), where no parameter is the frequency.
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

/// Whether the state or its field jumps where some contact begins, or the state at an event without a kind: orbits on the two
/// sides of a grazing are then different families. Friction that holds a body or turns with its motion is no contact.
bool has_hard_contacts(const HybridSystem& system);

/// Whether the system is forced with a period; else it is autonomous.
inline bool is_forced(const HybridSystem& system) { return system.forcing_frequency || system.period; }

/// Forcing period: 2 pi / frequency, or the system's own. @throws std::invalid_argument for an autonomous system.
double forcing_period(const HybridSystem& system, const Vector& p);

/// dT/dp (number of parameters).
Vector forcing_period_dp(const HybridSystem& system, const Vector& p);

/// Events that are the returns of an autonomous system, which stand for forcing periods: HybridSystem::returns, else those that
/// begin a contact, else those that begin to stick, else all.
std::vector<std::size_t> returns_of(const HybridSystem& system);

/// Names of the states, one each.
std::vector<std::string> state_names(const HybridSystem& system);

/// Checks that the pieces fit: sizes, derivatives present, targets exist, and that what is told apart (LevelGuard, Rebound,
/// Event::continuous, Mode::structure) agrees with its functions at states near the guard. @throws std::invalid_argument in one
/// sentence.
void validate(const HybridSystem& system);

/// The mode that `x` belongs to; nullopt: no motion begins there, it is not finite or lies inside a barrier.
std::optional<std::size_t> mode_at(const HybridSystem& system, double t, const Vector& x, const Vector& p);

/// The same. @throws std::invalid_argument if the state is not finite, has the wrong size or is not
/// admissible.
std::size_t initial_mode(const HybridSystem& system, double t, const Vector& x, const Vector& p);

}  // namespace graze
