// SPDX-License-Identifier: GPL-3.0-or-later
// The special points of a branch being followed, and where its nodes lie.
#include <graze/continuation/branch_follower.hpp>
#include <graze/continuation/grazing_by_events.hpp>
#include <graze/continuation/widest_gap.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace graze {

namespace {

/// How far along the step from `before` u lies, in arclength.
double place_of(const ZeroProblem& zero, const CurvePoint& before, const Vector& u) {
  return zero.weights.cwiseProduct(before.tangent).dot(u - before.u);
}

/// Where within its stretches a motion without contacts comes nearest to one, as a fraction of a stretch: there its first will
/// be.
double nearest_approach(OrbitProblem& problem, const Vector& shortened, double length) {
  constexpr int samples = 32;
  ShootingEquations& equations = problem.equations();
  double nearest = -std::numeric_limits<double>::infinity(), place = 0.5;
  Transition transition;
  for (int j = 0; j < problem.nodes(); ++j) {
    const double start = equations.node_time(shortened, j), step = length / samples;
    Vector x = equations.node(shortened, j);
    for (int k = 0; k < samples; ++k) {
      for (const Event& event : problem.system().events) {
        if (event.from != equations.stretch(j).mode0) continue;
        const double gap = event.guard.value(start + k * step, x, equations.parameters());
        if (!(gap > nearest)) continue;
        nearest = gap;
        place = static_cast<double>(k) / samples;
      }
      carry(equations.propagator(), start + k * step, start + (k + 1) * step, x, {.sensitivity = Sensitivity::none}, transition);
      if (transition.termination != Termination::time) return 0.5;
      x = transition.x1;
    }
  }
  return place;
}

}  // namespace

double BranchFollower::better_section(OrbitProblem& problem, const Vector& u) const {
  const double current = problem.equations().section_phase();
  if (!(hard_contacts_ || clear_of_soft_) || problem.equations().autonomous() ||
      !problem.evaluate(u, {.sensitivity = Sensitivity::none, .keep_events = true}))
    return current;
  // Places of the events within a stretch, as fractions of it, from its start.
  const Vector shortened = u.head(u.size() - 1);
  const double length = problem.equations().duration(shortened) / problem.nodes();
  std::vector<double> places;
  for (int j = 0; j < problem.nodes(); ++j)
    for (const EventRecord& event : problem.equations().stretch(j).events)
      places.push_back((event.t - problem.equations().node_time(shortened, j)) / length);
  if (places.empty()) places.push_back(nearest_approach(problem, shortened, length));
  std::sort(places.begin(), places.end());
  const double room = std::min(places.front(), 1.0 - places.back());
  constexpr double too_close = 0.02;
  if (room > too_close) return current;
  const Gap gap = widest_gap(places);
  if (0.5 * gap.length < 2.0 * room) return current;
  // One stretch is period / nodes forcing periods.
  return std::fmod(current + gap.middle * problem.period() / problem.nodes(), 1.0);
}

Vector BranchFollower::at_value(BranchProblem& problem, Vector u, double value) const {
  u[u.size() - 1] = value;
  const NewtonReport report = correct(problem.zero_problem(), problem.parameter_direction(), u, options_.trace);
  if (!report.converged()) return {};
  u[u.size() - 1] = value;
  return u;
}

SpecialPoint BranchFollower::plain_point(BranchProblem& problem, const Vector& u, PointType type, const Branch& branch) const {
  SpecialPoint point;
  point.type = type;
  NewtonReport report;
  report.status = NewtonStatus::converged;
  point.orbit = problem.orbit(u, report);
  point.value = point.interval[0] = point.interval[1] = problem.value(u);
  point.status = type == PointType::MX ? PointStatus::bracketed : PointStatus::converged;
  point.after_point = branch.points.empty() ? 0 : branch.points.size() - 1;
  return point;
}

void BranchFollower::mark(BranchProblem& problem, const Vector& u, PointType type, Branch& branch) {
  branch.special_points.push_back(plain_point(problem, u, type, branch));
}

void BranchFollower::user_points(BranchProblem& problem, const CurvePoint& before, const CurvePoint& after, const Branch& branch,
                                 std::vector<MetPoint>& met) const {
  if (options_.user_values.empty()) return;
  // Where the branch turns within the step, a value may be passed on both sides of the fold.
  std::vector<Vector> course{before.u};
  for (const MetPoint& point : met)
    if (point.point.type == PointType::LP && point.point.status == PointStatus::converged) course.push_back(point.u);
  course.push_back(after.u);
  for (std::size_t k = 0; k + 1 < course.size(); ++k) {
    const double a = problem.value(course[k]), b = problem.value(course[k + 1]);
    for (const double value : options_.user_values) {
      if ((a < value) == (b < value)) continue;
      // From a fold on the state goes with the root of the distance in the parameter.
      const double way = (value - a) / (b - a);
      const double part = k > 0 ? std::sqrt(way) : k + 2 < course.size() ? 1.0 - std::sqrt(1.0 - way) : way;
      const Vector u = at_value(problem, course[k] + part * (course[k + 1] - course[k]), value);
      if (u.size() > 0)
        met.push_back({place_of(problem.zero_problem(), before, u), u, plain_point(problem, u, PointType::UZ, branch)});
    }
  }
}

/// Empty where the sign changes without such a point.
std::optional<MetPoint> BranchFollower::locate(BranchProblem& problem, const TestFunction& test, const TestPoint& before,
                                               const TestPoint& after, const Branch& branch) const {
  /// How near to the unit circle's point a multiplier is where only the sign change along the branch locates it.
  constexpr double announced = 1e-3;
  const ZeroProblem zero = problem.zero_problem();
  const double length = after.curve.arclength - before.curve.arclength;
  double lo = 0.0, hi = 1.0, f_lo = test.value(before), f_hi = test.value(after);
  double value_lo = problem.value(before.curve.u), value_hi = problem.value(after.curve.u);
  CurvePoint best = after.curve;
  BranchPoint best_branch = after.branch;
  int side = 0;
  // Closes in on the sign change along the curve (Illinois).
  const auto close_in = [&](int steps, double small, double narrow) {
    for (int i = 0; i < steps && hi - lo > narrow; ++i) {
      const double s = std::clamp((lo * f_hi - hi * f_lo) / (f_hi - f_lo), lo + 0.01 * (hi - lo), hi - 0.01 * (hi - lo));
      CurvePoint trial;
      trial.u = before.curve.u + s * (after.curve.u - before.curve.u);
      if (!correct(zero, after.curve.u - before.curve.u, trial.u, options_.trace).converged()) break;
      trial.tangent = tangent_at(zero, trial.u, before.curve.tangent);
      if (trial.tangent.size() == 0) break;
      trial.arclength = before.curve.arclength + s * length;
      const BranchPoint here = problem.branch_point(trial.u, trial.arclength);
      if (!here.multipliers.valid) break;
      const double f = test.value({trial, here});
      best = trial;
      best_branch = here;
      if ((f < 0.0) == (f_lo < 0.0)) {
        lo = s;
        f_lo = f;
        value_lo = here.value;
        if (side == 1) f_hi *= 0.5;
        side = 1;
      } else {
        hi = s;
        f_hi = f;
        value_hi = here.value;
        if (side == -1) f_lo *= 0.5;
        side = -1;
      }
      if (std::abs(f) < small) break;
    }
  };
  close_in(8, 1e-5, 1e-7);
  SpecialPoint point;
  point.type = test.type;
  point.after_point = branch.points.size() - 1;
  LocatedPoint located = test.locate(problem, best.u, {best, best_branch});
  // Newton must not have left for another point of the kind: it stays within the step that announced this one.
  const auto within_step = [&](const Vector& u) {
    constexpr double slack = 0.01;
    const double place = place_of(zero, before.curve, u);
    return weighted_norm(zero.weights, u - best.u) <= length && place >= -slack * length && place <= (1.0 + slack) * length;
  };
  point.newton = located.newton;
  if (located.newton.converged() && within_step(located.u)) {
    point.status = PointStatus::converged;
    point.precision = std::max(located.precision, 4e-16 * std::abs(problem.value(located.u)));
    point.value = problem.value(located.u);
    point.orbit = problem.orbit(located.u, located.newton);
    point.orbit.multipliers = problem.branch_point(located.u, 0.0).multipliers;
    best.u = located.u;
    if (test.describe) test.describe(problem, located, point);
  } else {
    // Where Newton fails, as at the corner of a stiff contact, the sign change along the curve is followed down to rounding. A
    // sign that changes with no multiplier where the condition wants one is that of another event, or of a jump.
    close_in(60, 0.0, 1e-12);
    if (!corner_ && !(test.distance(best_branch) < announced)) return std::nullopt;
    point.value = problem.value(best.u);
    point.precision = std::max(std::abs(value_hi - value_lo), 1e-13 * (1.0 + std::abs(point.value)));
    point.status = hi - lo <= 1e-10 ? PointStatus::converged : PointStatus::bracketed;
    NewtonReport report;
    report.status = NewtonStatus::converged;
    point.orbit = problem.orbit(best.u, report);
    point.orbit.multipliers = best_branch.multipliers;
    point.details["method"] = std::string("sign change along the branch");
  }
  point.interval[0] = point.value - point.precision;
  point.interval[1] = point.value + point.precision;
  return MetPoint{place_of(zero, before.curve, best.u), best.u, std::move(point)};
}

SpecialPoint BranchFollower::grazing_point(const LocatedGrazing& located, int impacts_before, int impacts_after,
                                           const Branch& branch) const {
  SpecialPoint point;
  point.type = PointType::GR;
  point.after_point = branch.points.size() - 1;
  point.status = PointStatus::converged;
  point.newton = located.newton;
  point.value = located.u[located.u.size() - 1];
  point.precision = std::max(located.precision, 4e-16 * std::abs(point.value));
  point.interval[0] = point.value - point.precision;
  point.interval[1] = point.value + point.precision;
  point.orbit = located.orbit;
  point.orbit.admissible = branch.points.back().admissible;
  point.touching = located.contacts;
  set_impacts(point, impacts_before, impacts_after);
  point.details["scenario"] = std::string(grazing_scenario_name(located.scenario));
  point.details["time"] = located.t;
  if (system_.forcing_frequency) {
    const double T = forcing_period(system_, point.orbit.parameters);
    point.details["phase"] = 2.0 * std::numbers::pi * std::fmod(located.t / T, 1.0);
  }
  return point;
}

MetPoint BranchFollower::locate_impact_change(OrbitProblem& problem, const CurvePoint& before, const CurvePoint& after,
                                              const BranchPoint& reached, const Branch& branch) const {
  const BranchPoint& last = branch.points.back();
  const bool lost = reached.impacts < last.impacts;
  const int change = std::abs(reached.isolated_impacts - last.isolated_impacts);
  const Vector& with_impact = lost ? before.u : after.u;
  const double low = std::min(last.value, reached.value), high = std::max(last.value, reached.value), width = high - low;
  // A contact that reaches over a node is cut in two: then the nodes are moved.
  const double section = problem.equations().section_phase();
  for (const double further : {0.0, 0.37, 0.71}) {
    const bool moving = further > 0.0;
    if (moving && problem.equations().autonomous()) break;
    std::optional<OrbitProblem> moved;
    if (moving) moved.emplace(problem.with_section(std::fmod(section + further, 1.0)));
    std::optional<Vector> u = moving ? problem.to_section(*moved, with_impact) : with_impact;
    // Contacts that touch together are left out one by one: on a stretch each, the others do not count before it.
    if (change > 1 && u) {
      OrbitProblem& coarse = moving ? *moved : problem;
      OrbitProblem fine = coarse.with_nodes(4);
      u = coarse.to_nodes(fine, *u);
      moved.emplace(std::move(fine));
    }
    OrbitProblem& here = moved ? *moved : problem;
    // One that grazes need not be the weakest of all contacts yet.
    constexpr int considered = 4;
    const std::vector<GrazingGuess> guesses =
        u ? weakest_contacts(here, *u, change > 1 ? change : considered) : std::vector<GrazingGuess>{};
    const auto within_step = [&](const LocatedGrazing& found) {
      const double value = found.newton.converged() ? here.value(found.u) : std::numeric_limits<double>::quiet_NaN();
      return value >= low - 0.01 * width && value <= high + 0.01 * width;
    };
    LocatedGrazing located;
    for (std::size_t k = 0; k < guesses.size() && !within_step(located); ++k)
      if (k == 0 || change == 1) located = locate_grazing(here, *u, guesses[k]);
    if (!within_step(located)) continue;
    const double value = here.value(located.u);
    const auto apart = [&](const GrazingGuess& other) {
      const LocatedGrazing found = locate_grazing(here, *u, other);
      return !found.newton.converged() || std::abs(here.value(found.u) - value) > 1e-10 * (1.0 + std::abs(value));
    };
    if (change > 1 && std::any_of(guesses.begin() + 1, guesses.end(), apart)) continue;
    const Vector along =
        before.u + (value - before.u[before.u.size() - 1]) / (after.u - before.u)[before.u.size() - 1] * (after.u - before.u);
    const Vector& place = moved ? along : located.u;
    return {place_of(problem.zero_problem(), before, place), place,
            grazing_point(located, last.impacts, reached.impacts, branch)};
  }
  SpecialPoint point;
  point.type = PointType::GR;
  point.after_point = branch.points.size() - 1;
  point.value = 0.5 * (low + high);
  point.precision = 0.5 * width;
  point.interval[0] = low;
  point.interval[1] = high;
  point.orbit = problem.orbit(with_impact, {});
  point.details["kind"] = lost ? "lost" : "gained";
  point.details["impacts"] = std::vector<double>{static_cast<double>(last.impacts), static_cast<double>(reached.impacts)};
  const Vector middle = 0.5 * (before.u + after.u);
  return {place_of(problem.zero_problem(), before, middle), middle, std::move(point)};
}

bool BranchFollower::reaches_grazing(SignatureProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch) {
  const ZeroProblem zero = problem.zero_problem();
  const double length = after.arclength - before.arclength;
  const Vector chord = after.u - before.u;
  auto beyond = problem.violation(after.u);
  Vector good = before.u;
  double lo = 0.0, hi = 1.0;
  // To where the last motion (with impacts of at least that speed) and the first solution that is none are next to each other.
  const auto close_in = [&](double speed) {
    for (int i = 0; i < 40 && (hi - lo) * length > 1e-9; ++i) {
      const double middle = 0.5 * (lo + hi);
      Vector u = before.u + middle * chord;
      if (!correct(zero, chord, u, options_.trace).converged()) return false;
      const auto violation = problem.violation(u);
      if (violation) beyond = violation;
      if (violation || problem.least_speed(u) < speed) {
        hi = middle;
      } else {
        good = u;
        lo = middle;
      }
    }
    return true;
  };
  if (!close_in(weakest_kept)) return false;
  // An orbit about to gain an impact is kept from so far before that a free run tells it from the grazing.
  constexpr double told_apart = 1e-8;
  CurvePoint last = before;
  last.u = good;
  double kept = lo;
  if (!beyond->lost && lo * length > told_apart) {
    const double earlier = lo - told_apart / length;
    Vector u = before.u + earlier * chord;
    if (correct(zero, chord, u, options_.trace).converged() && !problem.violation(u)) {
      last.u = std::move(u);
      kept = earlier;
    }
  }
  last.arclength = before.arclength + kept * length;
  last.tangent = tangent_at(zero, last.u, before.tangent);
  BranchPoint point;
  if (kept > 0.0 && last.tangent.size() > 0) point = problem.branch_point(last.u, branch.points.back().arclength + kept * length);
  hi = 1.0;
  if (!close_in(0.0)) return false;
  const std::size_t parameter = parameter_index(system_.parameters, options_.parameter);
  // The bracket's end, and what rounding of a speed or of a gap leaves.
  constexpr double next_to = 1e-7;
  std::optional<GrazingAhead> ahead = grazing_ahead(problem, good, *beyond, parameter, next_to + 4.0 * (hi - lo) * length);
  if (!ahead) return false;
  // What lies before the grazing on this step is taken up; the grazing's own multipliers are singular.
  if (point.multipliers.valid && !take(problem, before, last, std::move(point), {}, branch)) return false;
  if (!(kept > 0.0 && last.tangent.size() > 0)) last = before;
  if (!take_up_to_grazing(problem, ahead->u, last, branch)) return false;
  const int impacts = branch.points.back().impacts;
  branch.special_points.push_back(
      grazing_point(ahead->grazing, impacts, impacts + (ahead->lost ? -ahead->grazing.touches : 1), branch));
  after = std::move(last);
  grazing_ = GrazingEnd{std::move(ahead->grazing), ahead->lost};
  return true;
}

/// A fold or a period doubling closer to the grazing than the branch's points are kept: the signs of its conditions, regular in
/// the coordinates of the events, are others at the grazing than at `point`. Then the point between the two that is nearest to
/// the grazing and still on its side of it; empty where there is nothing between.
std::optional<CurvePoint> BranchFollower::beside_grazing(SignatureProblem& problem, const Vector& grazing,
                                                         const CurvePoint& point) const {
  const ZeroProblem zero = problem.zero_problem();
  struct Signs {
    bool turned, doubled;
    bool operator==(const Signs&) const = default;
  };
  const auto signs = [&](const Vector& u, const Vector& tangent) {
    return Signs{tangent[tangent.size() - 1] < 0.0, problem.cyclic(u, -1.0).real().partialPivLu().determinant() < 0.0};
  };
  const Vector tangent = tangent_at(zero, grazing, point.tangent);
  if (tangent.size() == 0) return std::nullopt;
  const Signs there = signs(grazing, tangent);
  if (there == signs(point.u, point.tangent)) return std::nullopt;
  const Vector chord = point.u - grazing;
  for (double part = 0.5; part * weighted_norm(zero.weights, chord) > weakest_told; part *= 0.5) {
    CurvePoint between;
    between.u = grazing + part * chord;
    if (!correct(zero, chord, between.u, options_.trace).converged() || problem.violation(between.u)) return std::nullopt;
    between.tangent = tangent_at(zero, between.u, point.tangent);
    if (between.tangent.size() == 0) return std::nullopt;
    if (signs(between.u, between.tangent) != there) continue;
    between.arclength = point.arclength - (1.0 - part) * weighted_norm(zero.weights, chord);
    return between;
  }
  return std::nullopt;
}

bool BranchFollower::take_up_to_grazing(SignatureProblem& problem, const Vector& grazing, CurvePoint& last, Branch& branch) {
  std::optional<CurvePoint> nearer = beside_grazing(problem, grazing, last);
  if (!nearer) return true;
  nearer->arclength = 2.0 * last.arclength - nearer->arclength;  // it lies ahead
  BranchPoint point = problem.branch_point(nearer->u, branch.points.back().arclength + nearer->arclength - last.arclength);
  if (!point.multipliers.valid) return true;
  if (!take(problem, last, *nearer, std::move(point), {}, branch)) return false;
  last = std::move(*nearer);
  return true;
}

/// The grazing of a stiff contact is a corner of the branch, narrower than steps can be (like the stiffness to the power -2). The
/// branch goes on beyond it as that of a hard contact would: `last`, its end, is moved there. False where there is no corner.
bool BranchFollower::around_corner(OrbitProblem& problem, Branch& branch, CurvePoint& last) {
  constexpr double near = 1e-4;
  const ZeroProblem zero = problem.zero_problem();
  const BranchPoint& end = branch.points.back();
  for (const bool weakest : {true, false}) {
    const std::optional<GrazingGuess> guess = weakest ? weakest_contact(problem, last.u) : nearest_miss(problem, last.u);
    if (!guess) continue;
    const LocatedGrazing located = locate_grazing(problem, last.u, *guess);
    if (!located.newton.converged() || located.scenario != GrazingScenario::smooth ||
        weighted_norm(zero.weights, located.u - last.u) > near)
      continue;
    // The grazing may have been passed, and the tip of the corner lie beyond it.
    const double value = problem.value(located.u);
    const SpecialPoint& met_last = branch.special_points.back();
    const bool passed = met_last.type == PointType::GR && std::abs(met_last.value - value) < 1e-9 * (1.0 + std::abs(value));
    const bool to_contact = passed ? std::get<std::string>(met_last.details.at("kind")) == "gained" : !weakest;
    const int impacts = end.isolated_impacts + (passed ? 0 : to_contact ? 1 : -1);
    for (const double speed : {1e-3, 3e-3, 1e-2, 3e-4, 3e-2}) {
      // With contact: at that speed, as that of a hard contact. Without: as far from the grazing.
      const double height = speed * speed / (2.0 * -located.curvature), side = located.top_dp > 0.0 ? -1.0 : 1.0;
      const double change = to_contact ? (located.response * speed + height) / located.top_dp : side * speed;
      Vector away = change * located.family_dp;
      if (to_contact) away += speed * located.impulse;
      CurvePoint next;
      next.u = located.u + away;
      if (!away.allFinite() || !correct(zero, problem.parameter_direction(), next.u, options_.trace).converged()) continue;
      if (weighted_norm(zero.weights, next.u - located.u - away) > 0.5 * weighted_norm(zero.weights, away)) continue;
      next.tangent = tangent_at(zero, next.u, next.u - located.u);
      next.arclength = last.arclength + weighted_norm(zero.weights, next.u - last.u);
      BranchPoint point = problem.branch_point(next.u, end.arclength + next.arclength - last.arclength);
      if (next.tangent.size() == 0 || !point.multipliers.valid || point.isolated_impacts != impacts) continue;
      std::vector<MetPoint> met;
      if (!passed)
        met.push_back({place_of(zero, last, located.u), located.u, grazing_point(located, end.impacts, point.impacts, branch)});
      corner_ = Corner{value, place_of(zero, last, located.u), to_contact};
      const bool taken = take(problem, last, next, std::move(point), std::move(met), branch);
      corner_.reset();
      if (!taken) continue;
      last = std::move(next);
      return true;
    }
  }
  return false;
}

std::optional<GrazingEnd> BranchFollower::broken_off_at_grazing(OrbitProblem& problem, Branch& branch) {
  const BranchPoint& end = branch.points.back();
  const Vector u = problem.pack(end.nodes, end.duration, end.value);
  // The impact about to be lost, or else the maximum about to become one: whichever grazing lies right beyond the last point.
  for (const bool lost : {true, false}) {
    const std::optional<GrazingGuess> guess = lost ? weakest_contact(problem, u) : nearest_miss(problem, u);
    if (!guess) continue;
    std::optional<LocatedGrazing> located = hard_grazing_near(problem, u, *guess);
    if (!located) continue;
    branch.special_points.push_back(grazing_point(*located, end.impacts, end.impacts + (lost ? -1 : 1), branch));
    return GrazingEnd{std::move(*located), lost};
  }
  return std::nullopt;
}

}  // namespace graze
