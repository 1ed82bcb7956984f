// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch/branch_record.hpp>
#include <graze/continuation/branch/branch_step.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

struct ValueAt {
  double arclength, value;
};

/// Whether a test function may pass zero twice in the last step. Criterion: the parabola through its values at three
/// consecutive points, the last two of one sign, passes zero in that step or comes close to it.
bool may_pass_zero_twice(const ValueAt& earlier, const ValueAt& before, const ValueAt& after) {
  constexpr double near = 0.1;  // of the value at the beginning of the step
  const double slope = (before.value - earlier.value) / (before.arclength - earlier.arclength);
  const double bend =
      ((after.value - before.value) / (after.arclength - before.arclength) - slope) / (after.arclength - earlier.arclength);
  const double turn = 0.5 * (earlier.arclength + before.arclength - slope / bend);
  if (!(turn > before.arclength && turn < after.arclength)) return false;
  const double there =
      earlier.value + slope * (turn - earlier.arclength) + bend * (turn - earlier.arclength) * (turn - before.arclength);
  return there / before.value < near;
}

}  // namespace

FollowSettings::FollowSettings(const SharedSystem& of, const ContinuationOptions& with, double from, double to)
    : system(of), options(with), low(from), high(to), hard_contacts(has_hard_contacts(of)), tests(test_functions()) {
  tests.insert(tests.end(), with.further_tests.begin(), with.further_tests.end());
}

BranchRecord::BranchRecord(const FollowSettings& settings, Branch& branch)
    : settings_(settings), symmetries_(flight_symmetries(settings.system, branch.parameters)), branch_(branch) {}

bool BranchRecord::interrupted_now() {
  interrupted_ = interrupted_ || (settings_.options.cancelled && settings_.options.cancelled());
  return interrupted_;
}

std::optional<Verdict> BranchRecord::rejection_of(const BranchPoint& next) const {
  if (!next.multipliers.valid) return Verdict(Verdict::reject, "the multipliers cannot be computed");
  if (leaves_branch(settings_.system, symmetries_, branch_, next))
    return Verdict(Verdict::reject, "the orbit found beyond is on another branch");
  return std::nullopt;
}

void BranchRecord::mark(BranchProblem& problem, const Vector& u, PointType type) {
  branch_.special_points.push_back(plain_point(problem, u, type, branch_));
}

void BranchRecord::begin(BranchProblem& problem, const Vector& u) {
  branch_.points.push_back(problem.branch_point(u, 0.0));
  last_ = u;
  earlier_ = {};
  mark(problem, u, PointType::EP);
}

BranchRecord::Mark BranchRecord::mark() const {
  return {branch_.points.size(), branch_.special_points.size(), last_, earlier_, ending_};
}

void BranchRecord::roll_back(const Mark& mark) {
  branch_.points.resize(mark.points);
  branch_.special_points.resize(mark.special_points);
  last_ = mark.last;
  earlier_ = mark.earlier;
  ending_ = mark.ending;
}

void BranchRecord::clear() { roll_back({}); }

bool BranchRecord::take(BranchProblem& problem, const CurvePoint& before, const CurvePoint& after, BranchPoint point,
                        std::vector<PointInStep> met, const std::optional<Corner>& corner) {
  // A special point that is announced but not found may be a step onto a nearby branch.
  constexpr double smallest_doubt = 1e-5, smallest_step = 1e-8;
  const bool long_step = !corner && after.arclength - before.arclength > smallest_doubt;
  const auto doubtful = [&](const PointInStep& special) { return special.point.status != PointStatus::converged && long_step; };
  if (std::any_of(met.begin(), met.end(), doubtful)) return false;
  const TestPoint a{before, branch_.points.back(), problem.unit()}, b{after, point, problem.unit()};
  constexpr double longest_undivided = 1e-3;
  const bool divisible = !corner && met.empty() && after.arclength - before.arclength > longest_undivided;
  EarlierValues values{a.branch.arclength, {}};
  for (const TestFunction& test : settings_.tests) {
    const double f_a = test.value(a), f_b = test.value(b);
    values.values.push_back(f_a);
    if (!std::isfinite(f_a) || !std::isfinite(f_b)) continue;
    if ((f_a < 0.0) == (f_b < 0.0)) {
      const std::size_t index = values.values.size() - 1;
      if (divisible && !earlier_.values.empty() &&
          may_pass_zero_twice({earlier_.arclength, earlier_.values[index]}, {a.branch.arclength, f_a}, {point.arclength, f_b}))
        return false;
      continue;
    }
    const bool confirmed = test.confirm(a, b);
    if (!confirmed && !(test.too_far_apart && test.too_far_apart(a, b))) continue;
    if (in_rounding(test, a, b)) continue;
    std::optional<PointInStep> special = locate_in_step(
        problem, test, a, b, {.halve = !confirmed, .at_corner = corner.has_value()}, branch_, settings_.options.trace);
    if (!special) {
      if (confirmed && long_step) return false;
      continue;
    }
    // A fold beyond the end of the range: the branch leaves the range and returns within the step.
    const bool outside = special->point.value < settings_.low || special->point.value > settings_.high;
    if (outside && test.type == PointType::LP && long_step) return false;
    met.push_back(std::move(*special));
    if (corner) {  // at the tip of the corner: within the smallest step of the grazing, on the contact side
      SpecialPoint& tip = met.back().point;
      tip.status = PointStatus::bracketed;
      tip.value = corner->value;
      tip.precision = smallest_step;
      tip.interval[0] = tip.value - tip.precision;
      tip.interval[1] = tip.value + tip.precision;
      met.back().place = corner->place + (corner->to_contact ? 1e-12 : -1e-12);
    }
    if (doubtful(met.back())) return false;
  }
  add_user_points(problem, before, after, settings_.options.user_values, settings_.options.trace, branch_, met);
  std::stable_sort(met.begin(), met.end(), [](const PointInStep& x, const PointInStep& y) { return x.place < y.place; });
  for (PointInStep& special : met) branch_.special_points.push_back(std::move(special.point));
  earlier_ = std::move(values);
  branch_.points.push_back(std::move(point));
  last_ = after.u;
  if (settings_.options.progress) settings_.options.progress(branch_);
  return true;
}

void BranchRecord::append_apart(const Vector& u, BranchPoint point) {
  branch_.points.push_back(std::move(point));
  last_ = u;
  earlier_ = {};
  if (settings_.options.progress) settings_.options.progress(branch_);
}

Verdict BranchRecord::end_before(BranchProblem& problem, const CurvePoint& before, double part, CurvePoint& after) {
  constexpr double just_before = 0.9;
  const Verdict none_there(Verdict::reject, "no orbit is found just before the end of the branch");
  const Vector chord = after.u - before.u;
  CurvePoint last;
  last.u = before.u + just_before * part * chord;
  last.arclength = before.arclength + just_before * part * (after.arclength - before.arclength);
  if (!correct(problem.zero_problem(), chord, last.u, settings_.options.trace).converged()) return none_there;
  last.tangent = tangent_at(problem.zero_problem(), last.u, before.tangent);
  BranchPoint point = problem.branch_point(last.u, branch_.points.back().arclength + last.arclength - before.arclength);
  if (last.tangent.size() == 0 || !point.multipliers.valid || !problem.is_motion(last.u)) return none_there;
  if (point.isolated_impacts != branch_.points.back().isolated_impacts) return none_there;
  if (!take(problem, before, last, std::move(point), {})) return {Verdict::reject, special_points_lost};
  after = std::move(last);
  return Verdict::stop;
}

std::optional<Verdict> BranchRecord::end_at_half(BranchProblem& problem, const CurvePoint& before, CurvePoint& after) {
  const auto part = zero_crossing(problem.half_difference(before.u), problem.half_difference(after.u));
  if (!part) return std::nullopt;
  const Verdict verdict = end_before(problem, before, *part, after);
  const double end = branch_.points.back().value;
  if (verdict == Verdict::stop)
    ending_ = {BranchStop::returned, end,
               fmt::format("the doubled orbit has returned to its parent near {} = {:.12g}", branch_.parameter, end)};
  return verdict;
}

bool BranchRecord::end_on_bound(BranchProblem& problem) {
  const BranchPoint& end = branch_.points.back();
  for (const double bound : {settings_.low, settings_.high}) {
    if (end.value == bound || std::abs(end.value - bound) > 1e-6 * problem.size_of_value(bound)) continue;
    const Vector u = at_value(problem, last_, bound, settings_.options.trace);
    if (u.size() == 0) return false;
    BranchPoint point = problem.branch_point(u, end.arclength + std::abs(end.value - bound) / (settings_.high - settings_.low));
    if (!point.multipliers.valid || point.signature != end.signature) return false;
    branch_.points.push_back(std::move(point));
    last_ = u;
    return true;
  }
  return false;
}

ZeroProblem traced_problem(const FollowSettings& settings, BranchProblem& problem) {
  ZeroProblem zero = problem.zero_problem();
  const ParameterInfo& info = settings.system->parameters[problem.parameter()];
  zero.limits.push_back({problem.orbit_unknowns(), info.lower, info.upper, settings.low, settings.high});
  return zero;
}

std::optional<Verdict> end_of_range(const FollowSettings& settings, BranchProblem& problem, const CurvePoint& before,
                                    CurvePoint& after) {
  const double value = problem.value(after.u), last = problem.value(before.u);
  const double tolerance = 1e-14 * problem.size_of_value(settings.high);
  const bool above = value >= settings.high - tolerance && last < settings.high && value > last;
  const bool below = value <= settings.low + tolerance && last > settings.low && value < last;
  if (!above && !below) {
    const bool outside = value > settings.high + tolerance || value < settings.low - tolerance;
    return outside ? std::optional<Verdict>({Verdict::reject, "the branch leaves the range"}) : std::nullopt;
  }
  const double bound = above ? settings.high : settings.low;
  const Vector u =
      at_value(problem, before.u + (bound - last) / (value - last) * (after.u - before.u), bound, settings.options.trace);
  const Verdict none_there(Verdict::reject, "no isolated orbit is found at the end of the range");
  if (u.size() == 0) return none_there;
  const double length = after.arclength - before.arclength;
  after.arclength = before.arclength + length * std::clamp((bound - last) / (value - last), 0.0, 1.0);
  after.u = u;
  after.tangent = tangent_at(problem.zero_problem(), u, before.tangent);
  return after.tangent.size() == 0 ? none_there : Verdict::stop;
}

}  // namespace graze
