// SPDX-License-Identifier: GPL-3.0-or-later
// A family of orbits of the reference, followed in arclength of the events' coordinates from a start within a range of its
// parameter, with every point that changes something:
//
//     LP  det J(1) = 0       PD (of half a symmetric orbit BP)  det J(-1) = 0       NS  two multipliers of product 1
//     GR lost  w_i = 0       GR gained  an interior maximum touches a stop
//
// Each lies between two samples where its condition changes sign; there it is located by secants in Quad, with an error far
// below 1e-20 unless two of them nearly coincide. Three verdicts come from orbits nearby, found by Newton's method in Quad:
//     criticality of PD: doubled orbits y_0 + e (z, -z) + O(e^2), J(-1) z = 0, have p = p_0 + c e^2. Supercritical if they lie
//         where the orbit itself is unstable (det(M + I) < 0), for then they are stable.
//     scenario of a gained GR: the orbit with one impact more, of a given small speed w, has p = p_0 + c w. Persistence if it
//         lies on the other side of p_0 than the family, nonsmooth fold if on the same.
//     scenario of a lost GR: likewise by the side where the orbit without that impact stays below the barrier.
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
  halved,    ///< both halves of a doubled orbit have become the same: at a PD of the family it was doubled from
  broken     ///< the reference itself gives up: too many steps, or none that converges
};

struct Located {
  Kind kind{};
  Quad value{};
  double error = 0.0;  ///< of the value: the last change by a secant
  double sigma = 0.0;  ///< arclength, as that of the samples
  Values<Quad> orbit;
  bool gained = false;
  std::size_t which = 0;                           ///< impact that is lost, or after which one is gained
  int before = 0, after = 0;                       ///< impacts, at GR
  std::optional<bool> supercritical, persistence;  ///< nothing: not decided
  std::optional<bool> persistence_single;  ///< where a symmetric orbit gains an impact at both stops: of those that gain one
  std::optional<int> side;                 ///< at PD: the sign of p - p_0 of doubled orbits
};

struct Sample {
  double sigma = 0.0;
  Values<double> y;
};

/// Of the parameter, both ends included.
struct Range {
  double low = 0.0, high = 0.0;
};

struct Family {
  Frame frame;
  Values<double> weights;  ///< of the coordinates in the arclength
  Range range;
  std::vector<Sample> samples;
  std::vector<Located> points;  ///< in the order met
  End end = End::broken;
  double end_value = 0.0;
  Values<double> origin;  ///< of a doubled family: the doubling, as an orbit of twice the period
};

struct FollowOptions {
  double step = 0.02;  ///< largest step of arclength
  int most = 20000;    ///< samples
};

/// From the orbit `start`, the parameter first changing in `direction`.
Family follow(const Frame& frame, const Values<double>& start, const Range& range, int direction,
              const FollowOptions& options = {});

/// The family from end to end through `start`: followed back first, and then on from that end. A closed one begins at `start`.
Family follow_both_ways(const Frame& frame, const Values<double>& start, const Range& range, const FollowOptions& options = {});

/// The doubled orbits that begin at a PD of a family, or those less symmetric that begin at a BP (of both the mirror images of
/// others, by `sign`); nothing if they are not found or do not begin within the range.
std::optional<Family> follow_doubled(const Family& parent, const Located& doubling, const FollowOptions& options = {},
                                     int sign = 1);

/// Largest difference, in the best rotation.
double apart(const std::vector<State>& one, const std::vector<State>& other);

/// Places on the family of the orbit at p with these states at phase 0 after 0 ... n - 1 periods, in any rotation, that agree
/// within `tolerance`: by increasing arclength.
struct Place {
  double sigma = 0.0, distance = 0.0;
  Values<double> y;
};
std::vector<Place> places(const Family& family, double p, const std::vector<State>& states, double tolerance);

State state_of(const Linear<double>& system, const Point<double>& z);
Point<double> point_of(const Linear<double>& system, const State& state);

/// States at phase 0 after 0 ... n - 1 periods, the first one in the period of the first impact's flight.
std::vector<State> states_of(const Frame& frame, const Values<double>& y);

const char* name(Kind kind);
const char* name(End end);

}  // namespace graze::reference
