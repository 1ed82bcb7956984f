// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch_follower.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace graze {

namespace {

/// Half of a doubled orbit's nodes minus the other half: zero where it has collapsed onto its parent.
Vector antisymmetric_part(const Branch& branch, const std::vector<Vector>& nodes) {
  const std::size_t half = nodes.size() / 2;
  const Eigen::Index n = nodes.front().size();
  Vector difference(n * static_cast<Eigen::Index>(half));
  if (!branch.parent || nodes.size() % 2 != 0) return {};
  for (std::size_t j = 0; j < half; ++j) difference.segment(static_cast<Eigen::Index>(j) * n, n) = nodes[j] - nodes[j + half];
  return difference;
}

/// Number of real multipliers beyond -1 and beyond +1, and of complex ones outside the circle.
std::array<int, 3> unstable_kinds(const BranchPoint& point) {
  std::array<int, 3> count{};
  for (const auto& mu : nontrivial(point.multipliers)) {
    if (std::abs(mu) <= 1.0) continue;
    ++count[mu.imag() != 0.0 ? 2 : mu.real() < 0.0 ? 0 : 1];
  }
  return count;
}

}  // namespace

BranchFollower::BranchFollower(const HybridSystem& system, const ContinuationOptions& options, double low, double high,
                               std::function<std::string(PointType)> label)
    : system_(system), options_(options), low_(low), high_(high), label_(std::move(label)),
      hard_contacts_(
          std::any_of(system.events.begin(), system.events.end(), [](const Event& event) { return !event.continuous; })) {}

Vector BranchFollower::at_value(OrbitProblem& problem, Vector u, double value) const {
  u[u.size() - 1] = value;
  const NewtonReport report = correct(problem.zero_problem(), problem.parameter_direction(), u, options_.trace);
  if (!report.converged()) return {};
  u[u.size() - 1] = value;
  return u;
}

void BranchFollower::mark_end(OrbitProblem& problem, const Vector& u, PointType type, Branch& branch) {
  SpecialPoint point;
  point.type = type;
  point.label = label_(type);
  NewtonReport report;
  report.status = NewtonStatus::converged;
  point.orbit = problem.orbit(u, report);
  point.value = point.interval[0] = point.interval[1] = problem.value(u);
  point.status = PointStatus::converged;
  point.after_point = branch.points.empty() ? 0 : branch.points.size() - 1;
  branch.special_points.push_back(std::move(point));
}

bool BranchFollower::skipped_something(const TestPoint& before, const TestPoint& after) const {
  // Two multipliers through the same point within one step leave the test function's sign as it was.
  const auto a = unstable_kinds(before.branch), b = unstable_kinds(after.branch);
  return std::abs(a[0] - b[0]) > 1 || std::abs(a[1] - b[1]) > 1 || std::abs(a[2] - b[2]) > 2;
}

void BranchFollower::user_points(OrbitProblem& problem, const CurvePoint& before, const CurvePoint& after, Branch& branch) {
  if (options_.user_values.empty()) return;
  // Where the branch turns within the step, a value may be passed on both sides of the fold.
  std::vector<Vector> course{before.u};
  for (const SpecialPoint& point : branch.special_points)
    if (point.type == PointType::LP && point.status == PointStatus::converged && point.after_point + 1 == branch.points.size())
      course.push_back(problem.pack(point.orbit.nodes, point.orbit.duration, point.value));
  course.push_back(after.u);
  for (std::size_t k = 0; k + 1 < course.size(); ++k) {
    const double a = problem.value(course[k]), b = problem.value(course[k + 1]);
    std::vector<double> inside;
    for (const double value : options_.user_values)
      if ((a < value) != (b < value)) inside.push_back(value);
    std::sort(inside.begin(), inside.end(), [&](double x, double y) { return a < b ? x < y : x > y; });
    for (const double value : inside) {
      // From a fold on the state goes with the root of the distance in the parameter.
      const double way = (value - a) / (b - a);
      const double part = k > 0 ? std::sqrt(way) : k + 2 < course.size() ? 1.0 - std::sqrt(1.0 - way) : way;
      const Vector u = at_value(problem, course[k] + part * (course[k + 1] - course[k]), value);
      if (u.size() > 0) mark_end(problem, u, PointType::UZ, branch);
    }
  }
}

SpecialPoint BranchFollower::locate(OrbitProblem& problem, const TestFunction& test, const TestPoint& before,
                                    const TestPoint& after, const Branch& branch) const {
  // Close in on the sign change along the curve (Illinois), until Newton on the extended system has an easy start.
  const ZeroProblem zero = problem.zero_problem();
  const double length = after.curve.arclength - before.curve.arclength;
  double lo = 0.0, hi = 1.0, f_lo = test.value(before), f_hi = test.value(after);
  double value_lo = problem.value(before.curve.u), value_hi = problem.value(after.curve.u);
  CurvePoint best = after.curve;
  BranchPoint best_branch = after.branch;
  int side = 0;
  for (int i = 0; i < 8; ++i) {
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
    if (std::abs(f) < 1e-5 || hi - lo < 1e-7) break;
  }
  SpecialPoint point;
  point.type = test.type;
  point.after_point = branch.points.size() - 1;
  point.interval[0] = std::min(value_lo, value_hi);
  point.interval[1] = std::max(value_lo, value_hi);
  LocatedPoint located = test.locate(problem, best.u, {best, best_branch});
  // Newton must not have left for another point of the kind: it stays within the step that announced this one.
  const Vector away = located.u - best.u;
  const bool near = away.size() > 0 && std::sqrt(zero.weights.dot(away.cwiseAbs2())) <= length;
  point.newton = located.newton;
  if (located.newton.converged() && near) {
    point.status = PointStatus::converged;
    point.precision = std::max(located.precision, 4e-16 * std::abs(problem.value(located.u)));
    point.value = problem.value(located.u);
    point.interval[0] = point.value - point.precision;
    point.interval[1] = point.value + point.precision;
    point.orbit = problem.orbit(located.u, located.newton);
    if (test.describe) test.describe(problem, located, point);
  } else {
    point.value = problem.value(best.u);
    point.precision = 0.5 * (point.interval[1] - point.interval[0]);
    NewtonReport report;
    report.status = NewtonStatus::converged;
    point.orbit = problem.orbit(best.u, report);
  }
  return point;
}

void BranchFollower::add_grazing(const OrbitProblem& problem, const LocatedGrazing& located, int impacts_before,
                                 int impacts_after, Branch& branch) {
  SpecialPoint point;
  point.type = PointType::GR;
  point.label = label_(PointType::GR);
  point.after_point = branch.points.size() - 1;
  point.status = PointStatus::converged;
  point.newton = located.newton;
  point.value = problem.value(located.u);
  point.precision = std::max(located.precision, 4e-16 * std::abs(point.value));
  point.interval[0] = point.value - point.precision;
  point.interval[1] = point.value + point.precision;
  point.orbit = located.orbit;
  point.orbit.impacts = impacts_before;
  point.orbit.admissible = branch.points.back().admissible;
  point.details["kind"] = impacts_after < impacts_before ? "lost" : "gained";
  point.details["impacts"] = std::vector<double>{static_cast<double>(impacts_before), static_cast<double>(impacts_after)};
  point.details["scenario"] = std::string(grazing_scenario_name(located.scenario));
  point.details["time"] = located.t;
  if (system_.forcing_frequency) {
    const double T = forcing_period(system_, point.orbit.parameters);
    point.details["phase"] = 2.0 * std::numbers::pi * std::fmod(located.t / T, 1.0);
  }
  branch.special_points.push_back(std::move(point));
}

void BranchFollower::locate_impact_change(OrbitProblem& problem, const CurvePoint& before, const CurvePoint& after,
                                          const BranchPoint& reached, Branch& branch) {
  const BranchPoint& last = branch.points.back();
  const bool lost = reached.impacts < last.impacts;
  const Vector& with_impact = lost ? before.u : after.u;
  const double low = std::min(last.value, reached.value), high = std::max(last.value, reached.value), width = high - low;
  if (const std::optional<GrazingGuess> guess = weakest_contact(problem, with_impact)) {
    const LocatedGrazing located = locate_grazing(problem, with_impact, *guess);
    const double value = located.newton.converged() ? problem.value(located.u) : 0.0;
    if (located.newton.converged() && value >= low - 0.01 * width && value <= high + 0.01 * width)
      return add_grazing(problem, located, last.impacts, reached.impacts, branch);
  }
  SpecialPoint point;
  point.type = PointType::GR;
  point.label = label_(PointType::GR);
  point.after_point = branch.points.size() - 1;
  point.value = 0.5 * (low + high);
  point.precision = 0.5 * width;
  point.interval[0] = low;
  point.interval[1] = high;
  point.orbit = problem.orbit(with_impact, {});
  point.details["kind"] = lost ? "lost" : "gained";
  point.details["impacts"] = std::vector<double>{static_cast<double>(last.impacts), static_cast<double>(reached.impacts)};
  branch.special_points.push_back(std::move(point));
}

std::optional<GrazingEnd> BranchFollower::broken_off_at_grazing(OrbitProblem& problem, Branch& branch) {
  const BranchPoint& end = branch.points.back();
  const Vector u = problem.pack(end.nodes, end.duration, end.value);
  const ZeroProblem zero = problem.zero_problem();
  // The impact about to be lost, or else the maximum about to become one: whichever grazing lies right beyond the last point.
  constexpr double near = 0.02;
  for (const bool lost : {true, false}) {
    const std::optional<GrazingGuess> guess = lost ? weakest_contact(problem, u) : nearest_miss(problem, u);
    if (!guess) continue;
    LocatedGrazing located = locate_grazing(problem, u, *guess);
    if (!located.newton.converged() || located.scenario == GrazingScenario::smooth) continue;
    const Vector away = located.u - u;
    if (std::sqrt(zero.weights.dot(away.cwiseAbs2())) > near) continue;
    add_grazing(problem, located, end.impacts, end.impacts + (lost ? -1 : 1), branch);
    return GrazingEnd{std::move(located), lost};
  }
  return std::nullopt;
}

Verdict BranchFollower::monitor(OrbitProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch) {
  if (options_.cancelled && options_.cancelled()) {
    interrupted_ = true;
    return Verdict::stop;
  }
  // The end of the range: the last point lies on it.
  Verdict verdict = Verdict::go_on;
  const double value = problem.value(after.u), last = problem.value(before.u);
  const double tolerance = 1e-14 * (1.0 + std::abs(high_));
  if ((value >= high_ - tolerance && last < high_ && value > last) ||
      (value <= low_ + tolerance && last > low_ && value < last)) {
    const double bound = value > last ? high_ : low_;
    const Vector u = at_value(problem, before.u + (bound - last) / (value - last) * (after.u - before.u), bound);
    if (u.size() == 0) return Verdict::reject;
    const double length = after.arclength - before.arclength;
    after.arclength = before.arclength + length * std::clamp((bound - last) / (value - last), 0.0, 1.0);
    after.u = u;
    after.tangent = tangent_at(problem.zero_problem(), u, before.tangent);
    if (after.tangent.size() == 0) return Verdict::reject;
    verdict = Verdict::stop;
  }
  BranchPoint point = problem.branch_point(after.u, branch.points.back().arclength + after.arclength - before.arclength);
  if (!point.multipliers.valid) return Verdict::reject;
  const TestPoint a{before, branch.points.back()}, b{after, point};
  if (skipped_something(a, b)) return Verdict::reject;
  // One grazing at a time: a step across several is halved, down to where they cannot be told apart.
  const int change = std::abs(point.isolated_impacts - branch.points.back().isolated_impacts);
  // Orbits on both sides of a hard grazing are different families, even where the corrector finds its way across: never step over
  // one.
  if (change == 1 && hard_contacts_) return Verdict::reject;
  if (change > 1 && after.arclength - before.arclength > 1e-7) return Verdict::reject;
  const Vector difference = antisymmetric_part(branch, branch.points.back().nodes);
  if (difference.size() > 0 && difference.dot(antisymmetric_part(branch, point.nodes)) < 0.0) {
    returned_ = true;
    return Verdict::stop;
  }
  std::vector<SpecialPoint> located;
  for (const TestFunction& test : test_functions()) {
    const double f_a = test.value(a), f_b = test.value(b);
    if (!std::isfinite(f_a) || !std::isfinite(f_b) || (f_a < 0.0) == (f_b < 0.0) || !test.confirm(a, b)) continue;
    located.push_back(locate(problem, test, a, b, branch));
    // What is not found where it was announced may be no such point, but a step onto another branch close by.
    constexpr double smallest_doubt = 1e-5;
    if (located.back().status != PointStatus::converged && after.arclength - before.arclength > smallest_doubt)
      return Verdict::reject;
  }
  for (SpecialPoint& special : located) {
    special.label = label_(special.type);
    branch.special_points.push_back(std::move(special));
  }
  if (change == 1) locate_impact_change(problem, before, after, point, branch);
  user_points(problem, before, after, branch);
  const auto in_this_step =
      std::find_if(branch.special_points.begin(), branch.special_points.end(), [&](const SpecialPoint& special) {
        return special.after_point + 1 == branch.points.size() && special.type != PointType::EP;
      });
  const bool turns = std::any_of(in_this_step, branch.special_points.end(),
                                 [](const SpecialPoint& special) { return special.type == PointType::LP; });
  const auto advance = [&](const SpecialPoint& special) {
    if (!turns) return value > last ? special.value : -special.value;
    const Vector u = problem.pack(special.orbit.nodes, special.orbit.duration, special.value);
    return problem.zero_problem().weights.cwiseProduct(before.tangent).dot(u - before.u);
  };
  std::stable_sort(in_this_step, branch.special_points.end(),
                   [&](const SpecialPoint& x, const SpecialPoint& y) { return advance(x) < advance(y); });
  branch.points.push_back(std::move(point));
  if (options_.progress) options_.progress(branch);
  if (verdict == Verdict::go_on && better_section(problem, after.u) != problem.equations().section_phase()) {
    section_blocked_ = true;
    return Verdict::stop;
  }
  return verdict;
}

double BranchFollower::better_section(OrbitProblem& problem, const Vector& u) const {
  const double current = problem.equations().section_phase();
  if (!hard_contacts_ || problem.equations().autonomous() || !problem.evaluate(u, {.sensitivity = Sensitivity::none, .keep_events = true}))
    return current;
  // Places of the events within a stretch, as fractions of it, from its start.
  const Vector shortened = u.head(u.size() - 1);
  const double length = problem.equations().duration(shortened) / problem.nodes();
  std::vector<double> places;
  for (int j = 0; j < problem.nodes(); ++j)
    for (const EventRecord& event : problem.equations().stretch(j).events)
      places.push_back((event.t - problem.equations().node_time(shortened, j)) / length);
  if (places.empty()) return current;
  std::sort(places.begin(), places.end());
  const double room = std::min(places.front(), 1.0 - places.back());
  constexpr double too_close = 0.02;
  if (room > too_close) return current;
  double widest = 1.0 - places.back() + places.front(), middle = 0.5 * (places.back() + 1.0 + places.front());
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    if (places[i + 1] - places[i] <= widest) continue;
    widest = places[i + 1] - places[i];
    middle = 0.5 * (places[i] + places[i + 1]);
  }
  if (0.5 * widest < 2.0 * room) return current;
  // One stretch is period / nodes forcing periods.
  return std::fmod(current + middle * problem.period() / problem.nodes(), 1.0);
}

std::optional<GrazingEnd> BranchFollower::follow(OrbitProblem& problem, const Vector& u0, const Vector& orientation,
                                                 Branch& branch) {
  interrupted_ = returned_ = false;
  Vector start = u0, direction = orientation;
  // Moves start and direction to a section clear of impacts, if need be.
  const auto clear_section = [&] {
    const double section = better_section(problem, start);
    if (section == problem.equations().section_phase()) return;
    OrbitProblem moved = problem.with_section(section);
    // Small against the square of the speed of a weak impact, which lives within that distance of the barrier.
    const double small = 1e-8 / std::max(1e-300, direction.lpNorm<Eigen::Infinity>());
    const auto here = problem.to_section(moved, start), before = problem.to_section(moved, start - small * direction);
    if (!here) return;
    direction =
        before ? Vector((*here - *before) / small) : Vector(direction[direction.size() - 1] * moved.parameter_direction());
    start = *here;
    problem = std::move(moved);
  };
  clear_section();
  Curve curve;
  // Where the branch began: a closed one comes back there, perhaps with its nodes on another section.
  std::optional<CurvePoint> first, origin;
  double first_section = 0.0;
  TraceOptions trace_options = options_.trace;
  for (;;) {
    section_blocked_ = false;
    const ZeroProblem zero = problem.zero_problem();
    trace_options.max_points = std::max(1, options_.trace.max_points - static_cast<int>(branch.points.size()) + 1);
    const auto on_branch = [&](const CurvePoint& before, CurvePoint& after) {
      if (branch.points.empty()) {
        branch.points.push_back(problem.branch_point(before.u, 0.0));
        mark_end(problem, before.u, PointType::EP, branch);
        first = before;
        first_section = problem.equations().section_phase();
      }
      return monitor(problem, before, after, branch);
    };
    curve = trace(zero, start, direction, trace_options, on_branch, origin);
    const Vector plain = std::copysign(1.0, direction[direction.size() - 1]) * problem.parameter_direction();
    if (curve.stop == TraceStop::start_failed && branch.points.empty() && direction != plain) {
      direction = plain;
      continue;
    }
    if (curve.stop != TraceStop::monitor || !section_blocked_) break;
    start = curve.points.back().u;
    direction = curve.points.back().tangent;
    const double arclength = branch.points.back().arclength;
    clear_section();
    branch.points.back() = problem.branch_point(start, arclength);
    origin.reset();
    OrbitProblem at_first = problem.with_section(first_section);
    if (const auto u = at_first.to_section(problem, first->u)) {
      const double forward = std::copysign(1.0, first->tangent[first->tangent.size() - 1]);
      origin.emplace();
      origin->u = *u;
      origin->tangent = tangent_at(problem.zero_problem(), *u, forward * problem.parameter_direction());
      if (origin->tangent.size() == 0) origin.reset();
    }
  }
  const auto begin = [&](const Vector& u) {
    branch.points.push_back(problem.branch_point(u, 0.0));
    mark_end(problem, u, PointType::EP, branch);
  };
  if (curve.points.empty()) {
    branch.stop = BranchStop::start_failed;
    branch.message = "the first point did not converge: " + curve.failure;
    return std::nullopt;
  }
  if (branch.points.empty()) begin(curve.points.front().u);
  branch.direction = branch.points.size() > 1 && branch.points[1].value < branch.points[0].value ? -1 : 1;
  const BranchPoint& end = branch.points.back();
  branch.stop_value = end.value;
  const auto stop = [&](BranchStop reason, std::string message) {
    branch.stop = reason;
    branch.message = std::move(message);
  };
  std::optional<GrazingEnd> grazing;
  switch (curve.stop) {
  case TraceStop::monitor:
    if (interrupted_) {
      stop(BranchStop::interrupted, "it was interrupted");
    } else if (returned_) {
      stop(BranchStop::returned,
           fmt::format("the doubled orbit has returned to its parent near {} = {:.12g}", branch.parameter, end.value));
    } else {
      stop(BranchStop::reached_bound,
           fmt::format("the end of the range, {} = {:.12g}, was reached", branch.parameter, end.value));
    }
    break;
  case TraceStop::closed:
    stop(BranchStop::returned, "the branch is closed: it is back at its start");
    break;
  case TraceStop::point_limit:
    stop(BranchStop::point_limit, fmt::format("{} points were computed, the limit", branch.points.size()));
    break;
  default: {
    grazing = broken_off_at_grazing(problem, branch);
    if (grazing) {
      const SpecialPoint& point = branch.special_points.back();
      branch.stop_value = point.value;
      stop(BranchStop::grazing,
           fmt::format("{} at {} = {:.12g}: an impact is {} ({})", point.label, branch.parameter, point.value,
                       grazing->lost ? "lost" : "gained", grazing_scenario_name(grazing->grazing.scenario)));
      break;
    }
    stop(BranchStop::step_too_small, fmt::format("no point is found beyond {} = {:.12g} even with the smallest step ({})",
                                                 branch.parameter, end.value, curve.failure));
    if (curve.first_failed) {
      BranchPoint failed;
      const Vector& u = *curve.first_failed;
      failed.value = problem.value(u);
      for (int j = 0; j < problem.nodes(); ++j) failed.nodes.emplace_back(u.segment(j * problem.states(), problem.states()));
      failed.duration = end.duration;
      failed.section_phase = problem.equations().section_phase();
      if (failed.section_phase == 0.0) failed.states = {failed.nodes.front()};
      branch.first_failed = std::move(failed);
    }
  }
  }
  if (grazing) return grazing;
  const PointType type = branch.stop == BranchStop::step_too_small ? PointType::MX : PointType::EP;
  mark_end(problem, problem.pack(end.nodes, end.duration, end.value), type, branch);
  return std::nullopt;
}

}  // namespace graze
