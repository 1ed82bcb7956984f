// SPDX-License-Identifier: GPL-3.0-or-later
// Converts a system written as text (parameters, definitions, modes with equations, events with guards and resets) to a
// HybridSystem.
//
// All derivatives (fields, guards and resets in x, p and t) come from the expressions and are exact. A parameter whose value
// names other parameters is tied: it is replaced by its expression and is not a parameter of the HybridSystem. Structure
// (levels, rebounds, continuous crossings, linear and cubic oscillators, Hertz's contact) is recognised, not declared: a
// built-in system written as text uses the same flows.
//
// A power with a non-integer exponent whose base may become negative is allowed in a mode that is entered through that base as
// its guard (a contact law; it is zero outside its contact), and refused elsewhere.
//
// abs, sign, max, min, step, clamp and deadzone in equations, guards and resets become modes and guards (nonsmooth.hpp).
//
// Mechanics (matrices, stops, friction) and surfaces become modes and events (mechanics.hpp, sliding.hpp).
//
// The initial mode of a state is the first mode in which no guard is positive; for a state on a guard, the direction of motion
// decides. Sticking and sliding modes are tested first, for states on their constraints. A state beyond a guard of every mode
// is not admissible.
#pragma once

#include <graze/lib/equations/expression.hpp>
#include <graze/lib/equations/parse.hpp>
#include <graze/lib/equations/source.hpp>
#include <graze/lib/system/hybrid_system.hpp>

#include <map>
#include <memory>
#include <optional>

namespace graze::equations {

struct ParameterText {
  Text name;
  Text value;  ///< a number, a fraction "36/35", a constant "pi/8", or an expression of other parameters (then it is tied)
  std::optional<Text> min = {}, max = {}, above = {}, below = {};  ///< numbers; above and below exclude the value itself
  std::string unit = "dimensionless";
  std::string meaning = {};
};

struct ModeText {
  Text name;
  Text equations;  ///< "x' = v", separated by line breaks or ;
};

struct EventText {
  Text name;
  std::optional<Text> kind = {};   ///< a name of EventKind; absent: other
  std::optional<Text> from = {};   ///< absent: every mode
  std::optional<Text> to = {};     ///< absent: the mode does not change
  Text when = {};                  ///< the guard: the event fires where it rises through zero
  std::optional<Text> reset = {};  ///< "x = ...; v = ..."; the other states keep their values
  std::size_t count = 0;           ///< positive: an orbit's period n counts these events if there is no forcing
};

/// M q'' + C q' + K q = force, plus the forces of stops and friction. The states are the coordinates, then the velocities.
struct MechanicsText {
  std::vector<Text> coordinates, velocities;
  std::vector<std::vector<Text>> mass;                          ///< in coordinates and parameters; symmetric, positive definite
  std::vector<std::vector<Text>> damping = {}, stiffness = {};  ///< empty: none
  std::vector<Text> force = {};                                 ///< all other forces, one entry per coordinate; empty: none
  Place place = {};
};

/// A unilateral stop, open while its gap is positive. The gap's gradient W in the coordinates is the direction of its force.
/// Contact laws, with d = -gap and its rate d':
///     newton  k_r         d'+ = -k_r d'-: v+ = v - (1 + k_r) M^-1 W (W^T M^-1 W)^-1 gap'
///     hertz   k_H, b_H    F = k_H d^(3/2) (1 + b_H d')     (b_H is optional)
///     linear  k, c        F = k d + c d'                   (c is optional: Kelvin-Voigt with it)
///     force   F           any expression of d, d' and the motion
/// A contact whose force vanishes with d ends where the gap opens. Any other force (Kelvin-Voigt) does not pull unless
/// `adhesion` is set: it ends where it vanishes, and begins again if it rises before the gap has opened. With adhesion it ends
/// where the gap opens.
struct StopText {
  Text name;
  Text gap;  ///< in coordinates and t
  Text law;  ///< "newton", "hertz", "linear" or "force"
  std::vector<Text> values;
  bool adhesion = false;
  std::size_t count = 0;  ///< as in EventText, for impacts and entries
};

/// A surface between two modes. A motion that both fields press onto it slides along it in its own mode, with Filippov's convex
/// combination of the fields.
struct SurfaceText {
  Text function;
  Text below, above;                 ///< the modes on its negative and positive side
  std::optional<Text> sliding = {};  ///< name of the sliding mode; absent: the surface is only crossed
  std::size_t count = 0;             ///< as in EventText: entries into the sliding mode; without one, upward crossings
};

/// Dry friction -mu(u) N sign(speed) along a sliding speed, with u = |speed|; requires mechanics. The speed is linear in the
/// velocities; its gradient in them is the direction of the force.
struct FrictionText {
  Text name;
  Text speed;
  Text normal;                        ///< N > 0
  Text law;                           ///< mu(u)
  std::optional<Text> sticking = {};  ///< static coefficient; absent: mu(0)
  std::size_t count = 0;              ///< as in EventText, for the beginning of sticking
};

struct StartText {
  Text state;
  Text value;  ///< a number or an expression of the parameters
};

struct UnitText {
  Text name;  ///< a state, a definition, an output or t
  std::string unit;
};

struct SystemText {
  std::string name;
  Source source;
  std::vector<Text> states = {};
  std::optional<Text> forcing = {};  ///< the parameter that is the forcing frequency; its range is restricted to > 0
  std::optional<Text> period = {};   ///< or the period: a parameter or an expression of parameters; neither: autonomous
  std::vector<ParameterText> parameters = {};
  std::vector<Definition> definitions = {};
  std::vector<ModeText> modes = {};
  std::vector<EventText> events = {};
  std::optional<MechanicsText> mechanics = {};  ///< instead of states and modes
  std::vector<StopText> stops = {};
  std::vector<FrictionText> friction = {};
  std::vector<SurfaceText> surfaces = {};
  std::vector<Definition> outputs = {};  ///< may name each other, in any order
  std::vector<StartText> start = {};     ///< missing states are 0; empty: no start
  std::vector<Table> tables = {};        ///< for spline(name, u)
  std::vector<UnitText> units = {};      ///< for axes; the units of parameters are in ParameterText

  /// The states, or the coordinates and then the velocities.
  std::vector<Text> state_texts() const;
};

/// A function of the motion, evaluated in a mode (rates depend on the mode).
struct Output {
  std::string name;
  std::function<double(std::size_t mode, double t, const Vector& x, const Vector& p)> value;
};

/// A parameter that is a function of the others.
struct TiedParameter {
  ParameterInfo info;  ///< with its value at the default parameters
  std::function<double(const Vector& p)> value;
  std::function<void(const Vector& p, Vector& out)> dp;  ///< gradient (number of parameters)
};

/// The expressions behind a mode and an event, for further derivatives.
struct ModeExpressions {
  std::vector<Expression> field;
  std::vector<Place> equation = {};  ///< of each state
};
struct EventExpressions {
  Expression guard;
  std::vector<Expression> map;  ///< x+ for each state
  std::size_t text = 0;         ///< number in SystemText::events; SIZE_MAX: the event is not in the text
  std::size_t count = 0;
  Place when = {}, reset = {};
};

struct TextSystem {
  HybridSystem system;
  std::vector<TiedParameter> tied;
  std::vector<Output> outputs;
  std::optional<Vector> start;           ///< at t = 0
  std::shared_ptr<Graph> graph;          ///< to be changed by one thread only
  std::vector<ModeExpressions> modes;    ///< in the order of HybridSystem::modes
  std::vector<EventExpressions> events;  ///< in the order of HybridSystem::events
  /// States, parameters, definitions and outputs by name; their rates are not resolved.
  std::map<std::string, Expression, std::less<>> names;
  std::map<std::string, std::size_t, std::less<>> tables;  ///< numbers of the graph's splines
  std::map<std::string, std::string, std::less<>> units;   ///< by name, including parameters; no entry: no unit given
  Source source;
  Symbols symbols;
  std::vector<Hazard> hazards;  ///< places of the expressions that can fail at some values
};

/// The system of a text. @throws EquationError for every mistake in the text, with its place.
TextSystem make_system(const SystemText& text);

}  // namespace graze::equations
