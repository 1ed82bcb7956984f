// SPDX-License-Identifier: GPL-3.0-or-later
// A family of orbits of the reference, followed in the arclength of the coordinates of the events. It starts at an orbit
// within a range of its parameter and has every special point:
//
//     LP  det J(1) = 0       PD (of half a symmetric orbit BP)  det J(-1) = 0       NS  two multipliers of product 1
//     GR lost  w_i = 0       GR gained  an interior maximum touches a stop
//
// Each lies between two samples where its condition changes sign. The secant method in Quad locates it with an error far below
// 1e-20, unless two points nearly coincide. Three verdicts follow from nearby orbits, found by Newton's method in Quad:
//     - criticality of PD: doubled orbits y_0 + e (z, -z) + O(e^2), J(-1) z = 0, have p = p_0 + c e^2. It is supercritical if
//       they lie where the orbit itself is unstable (det(M + I) < 0): they are then stable.
//     - scenario of a gained GR: the orbit with one more impact, of a given small speed w, has p = p_0 + c w. It is
//       persistence if that orbit lies on the other side of p_0 than the family, nonsmooth fold if on the same side.
//     - scenario of a lost GR: the same, by the side on which the orbit without that impact stays below the barrier.
#pragma once

#include "answer.hpp"
#include "summits.hpp"

#include <string>

namespace graze::reference {

enum class Kind { LP, PD, BP, NS, GR };
enum class End {
  bound,     ///< the parameter leaves its range
  grazing,   ///< the last point is a GR
  closed,    ///< back at the start
  sticking,  ///< k_r = 0 and the mass no longer leaves the barrier: the reference ends here
  halved,    ///< both halves of a doubled orbit coincide: at a PD of the parent family
  broken     ///< the reference itself fails: too many steps, or no convergence
};

struct Located {
  Kind kind{};
  Quad value{};
  double error = 0.0;  ///< of the value: the last change by the secant method
  double sigma = 0.0;  ///< arclength, as for the samples
  Values<Quad> orbit;
  bool gained = false;
  std::size_t which = 0;                           ///< impact that is lost, or after which one is gained
  int before = 0, after = 0;                       ///< impacts, at GR
  std::optional<bool> supercritical, persistence;  ///< nothing: undecided
  std::optional<bool> persistence_single;          ///< for orbits with one impact more, if a symmetric orbit touches both stops
  std::optional<int> side;                         ///< at PD: the sign of p - p_0 of doubled orbits
};

struct Sample {
  double sigma = 0.0;
  Values<double> y;
};

/// Range of the parameter, both ends included.
struct Range {
  double low = 0.0, high = 0.0;
};

struct Family {
  Frame frame;
  Values<double> weights;  ///< of the coordinates in the arclength
  Range range;
  std::vector<Sample> samples;
  std::vector<Located> points;  ///< in the order of the family
  End end = End::broken;
  double end_value = 0.0;
  Values<double> origin;  ///< of a doubled family: the doubling, as an orbit of twice the period
};

struct FollowOptions {
  double step = 0.02;  ///< largest step of arclength
  int most = 20000;    ///< samples
};

/// Follows the family from the orbit `start`; the parameter changes in `direction` first.
Family follow(const Frame& frame, const Values<double>& start, const Range& range, int direction,
              const FollowOptions& options = {});

/// The family from end to end through `start`: followed back first, and then forwards from that end. A closed one begins at
/// `start`.
Family follow_both_ways(const Frame& frame, const Values<double>& start, const Range& range, const FollowOptions& options = {});

/// The doubled orbits that begin at a PD of a family, or the less symmetric ones that begin at a BP (`sign` selects one of two
/// mirror images). Nothing if they are not found or do not begin within the range.
std::optional<Family> follow_doubled(const Family& parent, const Located& doubling, const FollowOptions& options = {},
                                     int sign = 1);

/// Largest difference in the best rotation.
double apart(const std::vector<State>& one, const std::vector<State>& other);

/// Places on the family, by increasing arclength, of the orbit at p with these states at phase 0 after 0 ... n - 1 periods.
/// The states may be in any rotation and must agree within `tolerance`.
struct Place {
  double sigma = 0.0, distance = 0.0;
  Values<double> y;
};
std::vector<Place> places(const Family& family, double p, const std::vector<State>& states, double tolerance);

State state_of(const Linear<double>& system, const Point<double>& z);
Point<double> point_of(const Linear<double>& system, const State& state);

/// States at phase 0 after 0 ... n - 1 periods; the first one is in the period of the flight after the first impact.
std::vector<State> states_of(const Frame& frame, const Values<double>& y);

const char* name(Kind kind);
const char* name(End end);

}  // namespace graze::reference
