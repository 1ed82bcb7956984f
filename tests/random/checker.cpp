// SPDX-License-Identifier: GPL-3.0-or-later
#include "checker.hpp"
#include "events.hpp"
#include "one_impact.hpp"

#include <cstdio>
#include <limits>
#include <set>

namespace graze::reference {

namespace {

/// Largest error of a located value, relative to its own size or to a tenth of the range.
constexpr double value_tolerance = 3e-12;
/// Within this relative distance a reported point counts as the expected one, and its value is judged.
constexpr double same_point = 1e-6;
/// Tolerance of the states of a branch's points. The residuals of the program are at rounding, but near folds and grazings its
/// states are less accurate.
constexpr double state_tolerance = 1e-6;
/// Near a doubling the equations of doubled orbits are nearly singular. A point there need only approach the doubling: its
/// distance from it must be correct up to this fraction.
constexpr double by_doubling = 0.6, near_doubling = 1e-2;
/// Largest step between neighbouring points in the coordinates of the events, with the weights of the family's arclength.
constexpr double largest_gap = 1.5;
/// The same from the start of a family (the given orbit, or the doubling) to the first point.
constexpr double largest_start = 0.1;
/// Number of first points of a branch that are tried for the events of its orbit: near a grazing the states do not determine
/// them.
constexpr std::size_t first_points = 20;
/// Tolerance of the power sums of the multipliers, relative to the largest, for impacts of at least this speed.
constexpr double multiplier_tolerance = 1e-6, multiplier_speed = 1e-2;
/// Stop reason of the branch at which the time of the program is used up: the rest is not required.
constexpr const char* interrupted = "interrupted";
/// Finer steps with which the reference confirms its own verdict before it complains.
constexpr double fine_step = 0.004;

std::string text(const char* format, auto... values) {
  char out[400];
  std::snprintf(out, sizeof out, format, values...);
  return out;
}

double largest(const State& state) {
  double out = 0.0;
  for (const double value : state) out = std::max(out, std::fabs(value));
  return out;
}

double scale(const Family& family, double value) {
  return std::max(std::fabs(value), 0.1 * (family.range.high - family.range.low));
}

/// Distance of a doubled orbit from its doubling if it is near; otherwise 0.
double from_origin(const Family& family, const std::vector<State>& states) {
  if (family.origin.empty()) return 0.0;
  const double far = apart(states, states_of(family.frame, family.origin));
  return far < near_doubling ? far : 0.0;
}

/// True if the point is closer to the doubling than the first sample of the doubled family, or about as close. Also true if it
/// is so close that p - p_0 is lost to rounding: its error is rounding over the distance.
bool before_first(const Family& family, const AnswerPoint& point) {
  const double far = from_origin(family, point.states);
  if (far == 0.0) return false;
  return far < 1.5 * from_origin(family, states_of(family.frame, family.samples.front().y)) ||
         std::fabs(point.value - family.origin.back()) * far < 1e-14 * scale(family, point.value);
}

/// Arclengths of the points of a branch; complains about points that do not lie on the family, or not in order.
struct Placed {
  std::vector<double> sigmas;  ///< NaN: not on the family
  double last = 0.0;           ///< arclength of the last point on the family
};

Placed place_points(const Family& family, const AnswerBranch& branch, std::vector<Complaint>& out) {
  Placed placed;
  double size = 1.0;
  for (const AnswerPoint& point : branch.points)
    for (const State& state : point.states) size = std::max(size, largest(state));
  const double total = family.samples.back().sigma;
  // At a fold the state has half the digits, and so has the arclength.
  const double slack = 1e-5 * (1.0 + total);
  bool astray = false, backwards = false, gap = false;
  for (std::size_t i = 0; i < branch.points.size(); ++i) {
    const AnswerPoint& point = branch.points[i];
    std::vector<Place> found = places(family, point.value, point.states,
                                      std::max(state_tolerance * size, by_doubling * from_origin(family, point.states)));
    // A closed family that was born on symmetric orbits returns to its birth: the first points must not be placed at its end.
    if (family.end == End::closed && !family.origin.empty() && placed.last < largest_start) {
      std::erase_if(found, [&](const Place& place) { return place.sigma > 0.5 * total; });
      const std::vector<State> origin = states_of(family.frame, family.origin);
      if (found.empty() && apart(point.states, origin) < 1.5 * apart(states_of(family.frame, family.samples.front().y), origin)) {
        placed.sigmas.push_back(std::numeric_limits<double>::quiet_NaN());
        continue;
      }
    }
    // The first of the matching places: a closed family ends with the orbit with which it begins.
    double nearest = 1e300;
    for (const Place& place : found)
      if (place.sigma >= placed.last - slack) nearest = std::min(nearest, place.distance);
    const Place* best = nullptr;
    for (const Place& place : found)
      if (!best && place.sigma >= placed.last - slack && place.distance <= 10.0 * nearest + 1e-10 * size) best = &place;
    placed.sigmas.push_back(best ? best->sigma : std::numeric_limits<double>::quiet_NaN());
    if (!best) {
      if (!found.empty()) {
        if (!backwards) out.push_back({"order", text("point %zu (%.17g) lies behind the point before", i + 1, point.value)});
        backwards = true;
      } else if (!astray) {
        // The reference has no orbits between a doubling and the first sample, and after the onset of sticking.
        if (family.end == End::sticking || (placed.last == 0.0 && before_first(family, point))) continue;
        // Nor has it any between the last sample and another doubling.
        if (family.end == End::halved && apart(point.states, states_of(family.frame, family.samples.back().y)) < near_doubling)
          continue;
        out.push_back({"astray", text("point %zu (%.17g) is no orbit of the family", i + 1, point.value)});
        astray = true;
      }
      continue;
    }
    const double step = best->sigma - placed.last;
    if (i == 0 && step > largest_start)
      out.push_back({"start", text("point 1 (%.17g) is %.2g away from where the family begins", point.value, step)});
    if (i > 0 && step > largest_gap && !gap) {
      out.push_back({"neighbours", text("points %zu and %zu (%.17g) are %.2g apart", i, i + 1, point.value, step)});
      gap = true;
    }
    placed.last = std::max(placed.last, best->sigma);
  }
  return placed;
}

bool same_type(const AnswerSpecial& reported, const Located& expected) { return reported.type == name(expected.kind); }

std::string described(const Located& expected) {
  std::string out = text("%s %.17g", name(expected.kind), static_cast<double>(expected.value));
  if (expected.kind == Kind::GR)
    out += text(" (%d to %d, %s%s)", expected.before, expected.after, expected.gained ? "gained" : "lost",
                !expected.persistence   ? ""
                : *expected.persistence ? ", persistence"
                                        : ", nonsmooth-fold");
  if (expected.kind == Kind::PD && expected.supercritical) out += *expected.supercritical ? " (super)" : " (sub)";
  return out;
}

/// Whether it lies between the points before and after it.
bool in_place(const Family& family, const Located& expected, const AnswerSpecial& reported, const Placed& placed) {
  const std::size_t after = static_cast<std::size_t>(reported.after_point), last = placed.sigmas.size();
  const double slack = 1e-5 * (1.0 + family.samples.back().sigma);
  return reported.after_point >= 0 && after < last && !(placed.sigmas[after] > expected.sigma + slack) &&
         !(after + 1 < last && placed.sigmas[after + 1] < expected.sigma - slack);
}

void compare_point(const Family& family, const Located& expected, const AnswerSpecial& reported, const Placed& placed,
                   std::vector<Complaint>& out) {
  const double value = static_cast<double>(expected.value);
  const double off = static_cast<double>(magnitude(Quad(reported.value) - expected.value));
  // A printed value is rounded to the nearest double.
  const double rounding = 0.5 * (std::nextafter(std::fabs(value), 1e300) - std::fabs(value));
  const std::string which = reported.label + " of " + described(expected);
  if (off > value_tolerance * scale(family, value)) out.push_back({"value", text("%s: off by %.2g", which.c_str(), off)});
  const Quad low = Quad(reported.interval[0]) - Quad(rounding), high = Quad(reported.interval[1]) + Quad(rounding);
  if (off > reported.precision + rounding || expected.value < low || expected.value > high)
    out.push_back({"error bar", text("%s: off by %.2g, bar %.2g", which.c_str(), off, reported.precision)});
  if (reported.status != "converged") out.push_back({"status", which + ": " + reported.status});
  if (reported.impacts != family.frame.impacts() || reported.period != family.frame.periods)
    out.push_back({"label", text("%s: label %d/%d", which.c_str(), reported.impacts, reported.period)});
  if (expected.kind == Kind::GR) {
    if ((reported.kind == "gained") != expected.gained || (reported.kind == "lost") == expected.gained)
      out.push_back({"lost or gained", which + ": " + reported.kind});
    // Where a symmetric orbit touches both stops at once, orbits with one impact more and orbits with two begin: both answers
    // are valid.
    const bool single = family.frame.half && expected.gained && reported.change[1] == expected.before + 1;
    if (reported.change[0] != expected.before || (reported.change[1] != expected.after && !single))
      out.push_back({"impacts at a grazing", text("%s: %d to %d", which.c_str(), reported.change[0], reported.change[1])});
    const std::optional<bool> persistence = single ? expected.persistence_single : expected.persistence;
    if (persistence && reported.scenario != (*persistence ? "persistence" : "nonsmooth-fold"))
      out.push_back({"scenario", which + ": " + (reported.scenario.empty() ? "none given" : reported.scenario)});
  } else {
    const double sign = expected.kind == Kind::PD ? -1.0 : 1.0;
    double nearest = 1e300;
    for (const std::complex<double>& mu : reported.multipliers)
      nearest = std::min(nearest, expected.kind == Kind::NS ? std::fabs(std::abs(mu) - 1.0) : std::abs(mu - sign));
    if (!(nearest < 1e-4)) out.push_back({"multiplier", text("%s: %.2g away from its multiplier", which.c_str(), nearest)});
  }
  if (expected.kind == Kind::PD && expected.supercritical &&
      reported.criticality != (*expected.supercritical ? "supercritical" : "subcritical"))
    out.push_back({reported.criticality.empty() ? "criticality not given" : "criticality",
                   which + ": " + (reported.criticality.empty() ? "none given" : reported.criticality)});
  if (!in_place(family, expected, reported, placed))
    out.push_back({"place of a point", text("%s: not behind point %d", which.c_str(), reported.after_point + 1)});
}

void compare_points(const Family& family, const AnswerBranch& branch, const Placed& placed, std::vector<Complaint>& out) {
  std::vector<bool> used(branch.special_points.size(), false);
  for (const Located& expected : family.points) {
    const double value = static_cast<double>(expected.value);
    // A branch from one end of broken symmetry to the other has pairs of folds with equal values, mirror images of each other.
    // The one at the right place counts.
    std::size_t best = used.size();
    std::pair<bool, double> least{true, same_point * scale(family, value)};
    for (std::size_t k = 0; k < used.size(); ++k) {
      const AnswerSpecial& reported = branch.special_points[k];
      const std::pair<bool, double> off{!in_place(family, expected, reported, placed), std::fabs(reported.value - value)};
      if (used[k] || !same_type(reported, expected) || off.second > same_point * scale(family, value) || off > least) continue;
      least = off;
      best = k;
    }
    if (best == used.size()) {
      if (branch.stop == interrupted && expected.sigma > placed.last) continue;
      out.push_back({std::string("missing ") + name(expected.kind), described(expected) + " is missing"});
      continue;
    }
    used[best] = true;
    compare_point(family, expected, branch.special_points[best], placed, out);
  }
  for (std::size_t k = 0; k < used.size(); ++k) {
    const AnswerSpecial& special = branch.special_points[k];
    if (used[k] || special.type == "EP" || special.type == "UZ") continue;
    if (family.end == End::sticking && std::fabs(special.value - family.end_value) < 1e-6) continue;
    if (family.end == End::sticking && static_cast<std::size_t>(special.after_point) < placed.sigmas.size() &&
        std::isnan(placed.sigmas[static_cast<std::size_t>(special.after_point)]))
      continue;
    out.push_back({"unconfirmed " + special.type, text("%s %.17g is none", special.label.c_str(), special.value)});
  }
}

/// Monodromy matrix of the whole orbit, if the frame has half of a symmetric one.
Table<double> whole_monodromy(const Frame& frame, const Values<double>& y) {
  const Table<double> M = monodromy(frame, y);
  return frame.half ? M * M : M;
}

/// Roots of the characteristic polynomial, by Weierstrass' iteration. Its coefficients follow from the power sums.
std::vector<std::complex<double>> multipliers_of(const Table<double>& M) {
  constexpr int most = 200;
  const Values<double> p = power_sums(M);
  const std::size_t n = M.rows;
  Values<double> e = {1.0};
  for (std::size_t k = 1; k <= n; ++k) {
    double sum = 0.0;
    for (std::size_t i = 1; i <= k; ++i) sum += (i % 2 == 1 ? 1.0 : -1.0) * e[k - i] * p[i - 1];
    e.push_back(sum / static_cast<double>(k));
  }
  std::vector<std::complex<double>> out;
  for (std::size_t k = 0; k < n; ++k)
    out.push_back(std::pow(std::complex<double>(0.4, 0.9), static_cast<int>(k)) * (1.0 + std::fabs(p[0])));
  for (int step = 0; step < most; ++step)
    for (std::size_t k = 0; k < n; ++k) {
      std::complex<double> value = 0.0, others = 1.0;
      for (std::size_t i = 0; i <= n; ++i) value = value * out[k] + (i % 2 == 1 ? -e[i] : e[i]);
      for (std::size_t j = 0; j < n; ++j)
        if (j != k) others *= out[k] - out[j];
      if (others != 0.0) out[k] -= value / others;
    }
  return out;
}

/// Compares the multipliers of the points with the power sums of the reference, and the stability that follows from them. Near
/// a grazing or a fold they are inaccurate.
void compare_multipliers(const Family& family, const AnswerBranch& branch, std::vector<Complaint>& out) {
  for (const AnswerPoint& point : branch.points) {
    if (point.multipliers.size() != family.frame.block()) continue;
    const std::vector<Place> found = places(family, point.value, point.states, state_tolerance);
    if (found.size() != 1) continue;
    const Values<double>& y = found.front().y;
    double slowest = 1e300, most = 0.0;
    for (std::size_t i = 0; i < family.frame.legs(); ++i) slowest = std::min(slowest, y[family.frame.block() * i + 1]);
    for (const std::complex<double>& mu : point.multipliers) most = std::max(most, std::abs(mu));
    if (slowest < multiplier_speed) continue;
    const Values<double> sums = power_sums(whole_monodromy(family.frame, y));
    const double error = multiplier_tolerance * (1.0 + found.front().distance / 1e-9);
    for (std::size_t k = 0; k < sums.size(); ++k) {
      std::complex<double> sum = 0.0;
      for (const std::complex<double>& mu : point.multipliers) sum += std::pow(mu, static_cast<int>(k) + 1);
      if (std::abs(sum - sums[k]) < error * std::pow(1.0 + most, static_cast<double>(k) + 1.0)) continue;
      out.push_back(
          {"multipliers", text("at %.17g: sum of powers %zu is %.12g, not %.12g", point.value, k + 1, sum.real(), sums[k])});
      return;
    }
    if (point.stable && std::fabs(most - 1.0) > 1e-4 && *point.stable != (most < 1.0)) {
      out.push_back({"stability", text("at %.17g: the largest multiplier is %.12g", point.value, most)});
      return;
    }
  }
}

void compare_end(const Family& family, const AnswerBranch& branch, const Placed& placed, std::vector<Complaint>& out) {
  const char* expected = family.end == End::bound ? "reached_bound" : family.end == End::grazing ? "grazing" : "returned";
  if (family.end == End::sticking) return;
  if (branch.stop != expected) {
    out.push_back({"stop " + branch.stop, text("stops at %.17g (%s); the family goes on to %.17g (%s)", branch.stop_value,
                                               branch.stop.c_str(), family.end_value, name(family.end))});
    return;
  }
  // The last point is the end, or at most one step from the grazing.
  const double total = family.samples.back().sigma, left = total - placed.last;
  const double most = family.end == End::bound ? 1e-5 * (1.0 + total) : largest_gap;
  // "Returned" to its parent is reported at the last point before, and "closed" at the first point, which is near the birth.
  const bool closed = family.end == End::closed && !family.origin.empty();
  const double expected_value = closed ? family.origin.back() : family.end_value;
  const double off = family.end == End::halved ? 0.0 : std::fabs(branch.stop_value - expected_value);
  if (left > most || off > 1e-6 * scale(family, family.end_value))
    out.push_back({"end", text("ends at %.17g (%s), %.2g before the end of the family at %.17g", branch.stop_value,
                               branch.stop.c_str(), left, family.end_value)});
}

/// Requirements on every branch without a reference: range, labels, stop reason, impacts of doubled branches.
void check_alone(const Frame& frame, const Range& range, const Answer& answer, std::vector<Complaint>& out) {
  std::set<std::string> labels;
  const double rounding = 1e-13 * (1.0 + std::fabs(range.low) + std::fabs(range.high));
  for (const AnswerBranch& branch : answer.branches) {
    const auto outside = [&](double value) { return !(value >= range.low - rounding && value <= range.high + rounding); };
    for (std::size_t i = 0; i < branch.points.size(); ++i)
      if (outside(branch.points[i].value)) {
        out.push_back(
            {"range", text("branch %d leaves the range: point %zu at %.17g", branch.id, i + 1, branch.points[i].value)});
        break;
      }
    const AnswerSpecial* last = nullptr;
    for (const AnswerSpecial& special : branch.special_points) {
      if (outside(special.value))
        out.push_back(
            {"range", text("%s of branch %d outside the range: %.17g", special.label.c_str(), branch.id, special.value)});
      if (special.label.rfind(special.type, 0) != 0 || !labels.insert(special.label).second)
        out.push_back(
            {"label", text("%s of branch %d is a %s or appears twice", special.label.c_str(), branch.id, special.type.c_str())});
      if (special.type == "NS" && !is_chain(frame.model))
        out.push_back({"unconfirmed NS", special.label + " is none: det M < 1"});
      if (special.type != "EP") last = &special;
    }
    if (branch.points.empty()) continue;
    for (const AnswerBranch& parent : answer.branches)
      if (parent.id == branch.parent)
        for (const AnswerSpecial& special : parent.special_points)
          if (special.label == branch.parent_label && special.type == "PD" &&
              (branch.points.front().impacts != 2 * special.impacts || branch.period != 2 * special.period))
            out.push_back(
                {"doubled label", text("branch %d, doubled at %s (%d/%d), begins as %d/%d", branch.id, special.label.c_str(),
                                       special.impacts, special.period, branch.points.front().impacts, branch.period)});
    if (branch.stop == "reached_bound") {
      const double at = branch.points.back().value;
      if (std::min(std::fabs(at - range.low), std::fabs(at - range.high)) > rounding)
        out.push_back({"end", text("branch %d reached_bound at %.17g", branch.id, at)});
    }
    if (branch.stop == "grazing" && (!last || last->type != "GR" || last->value != branch.stop_value))
      out.push_back({"end", text("branch %d ends at a grazing that is not its last point", branch.id)});
  }
}

/// The check of one answer: each branch once, against its family.
class Check {
 public:
  Check(const Frame& frame, const Range& range, const Answer& answer, int most_impacts)
      : frame_(frame), range_(range), answer_(answer), most_impacts_(most_impacts) {}

  Verdict continued(const Case& one) {
    const auto family = [&](const FollowOptions& options) -> std::optional<Family> {
      return follow(one.frame, one.start, range_, one.direction(), options);
    };
    const std::optional<Family> own = family({});
    if (own->end == End::broken)
      verdict_.undecided = true;
    else if (!answer_.failure.empty())
      complain("", "no answer", answer_.failure);
    else {
      check_alone(frame_, range_, answer_, verdict_.complaints);
      compare_with(answer_.branches.front(), "", family);
      check_beyond(answer_.branches.front());
      check_others();
    }
    return verdict_;
  }

  Verdict skeleton(int most_periods) {
    most_periods_ = most_periods;
    if (!answer_.failure.empty()) {
      complain("", "no answer", answer_.failure);
      return verdict_;
    }
    check_alone(frame_, range_, answer_, verdict_.complaints);
    check_others();
    for (const Family& family : one_impact_families(frame_, range_, most_periods)) {
      if (family.end == End::broken) {
        verdict_.undecided = true;
        continue;
      }
      ++verdict_.families;
      check_covered(family);
    }
    return verdict_;
  }

 private:
  void complain(const std::string& who, const std::string& kind, const std::string& what) {
    verdict_.complaints.push_back({kind, (who.empty() ? "" : who + ": ") + what});
  }

  /// Compares the branch, and those doubled on it, with `family`, which follows the family with given options.
  void compare_with(const AnswerBranch& branch, const std::string& who, const auto& family) {
    done_.insert(branch.id);
    std::optional<Family> found = family({});
    if (!found || found->end == End::broken) return;
    ++verdict_.families;
    const std::string label = text("%d/%d", found->frame.impacts(), found->frame.periods);
    if (branch.points.empty() || branch.points.front().impacts != found->frame.impacts() ||
        branch.period != found->frame.periods) {
      complain(who, "label",
               text("begins as %d/%d, not as %s", branch.points.empty() ? 0 : branch.points.front().impacts, branch.period,
                    label.c_str()));
      return;
    }
    std::vector<Complaint> complaints = compare(*found, branch);
    if (!complaints.empty()) {
      // Confirmed with finer steps of the reference.
      const std::optional<Family> finer = family({fine_step, 100000});
      if (finer && finer->end != End::broken) {
        found = finer;
        complaints = compare(*found, branch);
      }
    }
    for (const Complaint& complaint : complaints) complain(who, (who.empty() ? "" : "other: ") + complaint.kind, complaint.text);
    compare_doubled(*found, branch);
  }

  /// Arclength from the start of the family to a point early on the branch; very large if the point is not on the family.
  static double length_to(const Family& family, const AnswerBranch& branch) {
    if (branch.points.empty()) return 1e300;
    const AnswerPoint& early = branch.points[branch.points.size() / 4];
    double size = 1.0;
    for (const State& state : early.states) size = std::max(size, largest(state));
    const std::vector<Place> found = places(family, early.value, early.states, state_tolerance * size);
    return found.empty() ? 1e300 : found.front().sigma;
  }

  void compare_doubled(const Family& parent, const AnswerBranch& branch) {
    // A doubled family that ends at another doubling is followed once, from one of the two.
    std::set<double> reached;
    for (const Located& doubling : parent.points) {
      if ((doubling.kind != Kind::PD && doubling.kind != Kind::BP) || !doubling.side) continue;
      const double value = static_cast<double>(doubling.value);
      const AnswerSpecial* reported = nullptr;
      for (const AnswerSpecial& special : branch.special_points)
        if (same_type(special, doubling) && std::fabs(special.value - value) < same_point * scale(parent, value))
          reported = &special;
      if (!reported) continue;
      const AnswerBranch* child = nullptr;
      for (const AnswerBranch& other : answer_.branches)
        if (other.parent == branch.id && other.parent_label == reported->label) child = &other;
      // Of two mirror images that begin at a BP, the answer has one.
      int sign = 1;
      std::optional<Family> family = follow_doubled(parent, doubling);
      if (!family) continue;
      if (child && doubling.kind == Kind::BP) {
        const std::optional<Family> image = follow_doubled(parent, doubling, {}, -1);
        if (image && length_to(*image, *child) < length_to(*family, *child)) {
          sign = -1;
          family = image;
        }
      }
      if (family->end == End::halved && child) reached.insert(family->end_value);
      if (!child) {
        // Later generations are not required.
        if (!answer_.interrupted && branch.id == answer_.branches.front().id && reached.count(value) == 0 &&
            family->frame.periods <= most_periods_)
          complain("", "child missing",
                   text("no branch is doubled at %s; the family goes to %.17g (%s)", reported->label.c_str(), family->end_value,
                        name(family->end)));
        continue;
      }
      compare_with(*child, text("branch %d, doubled at %s", child->id, reported->label.c_str()),
                   [&](const FollowOptions& options) { return follow_doubled(parent, doubling, options, sign); });
    }
  }

  /// A branch without impacts follows the impactless motion to the bound, or to its grazing at amplitude r.
  void check_impactless(const AnswerBranch& branch) {
    const std::string who = text("branch %d (0/1)", branch.id);
    const double start = branch.points.front().value, next = branch.points[1].value;
    for (const AnswerPoint& point : branch.points) {
      const Linear<double> system = frame_.system(point.value);
      const State expected = state_of(system, impactless(system, 0.0));
      if (point.states.size() != 1 || apart({expected}, point.states) > state_tolerance * (1.0 + largest(expected)))
        return complain(who, "other: astray", text("%.17g is not the impactless motion", point.value));
    }
    const double bound = next > start ? range_.high : range_.low;
    const std::optional<Quad> value = touching(frame_, start, bound);
    if (branch.stop != interrupted && branch.stop != (value ? "grazing" : "reached_bound"))
      complain(who, "other: stop " + branch.stop,
               text("stops at %.17g; the amplitude reaches the barrier at %.17g", branch.stop_value,
                    value ? static_cast<double>(*value) : bound));
    int grazings = 0;
    for (const AnswerSpecial& special : branch.special_points) {
      if (special.type == "EP") continue;
      if (!value || special.type != "GR" || ++grazings > 1) {
        complain(who, "other: unconfirmed " + special.type, text("%s %.17g is none", special.label.c_str(), special.value));
        continue;
      }
      Family family;
      family.frame = frame_;
      family.frame.stops.clear();
      family.frame.periods = 1;
      family.range = range_;
      family.samples.resize(1);
      Located expected;
      expected.kind = Kind::GR;
      expected.value = *value;
      expected.gained = true;
      expected.after = frame_.model == Model::equal_stops ? 2 : 1;
      // The 1/1 orbits of small speed w at the stop have amplitude^2 = wall^2 - 2 wall alpha w. Equal stops are touched at
      // once.
      Frame one = frame_;
      one.half = false;
      one.periods = 1;
      one.stops = {0};
      const double p = static_cast<double>(*value);
      const Linear<double> system = frame_.system(p);
      if (system.stops.size() > 1 && system.stops[1].wall - impactless_amplitude(system, system.stops[1]) <
                                         system.stops[0].wall - impactless_amplitude(system, system.stops[0]))
        one.stops = {1};
      const SingleImpact<double> form = single_impact(one, p);
      if (frame_.model != Model::equal_stops) expected.persistence = form.stop.wall * form.alpha < 0.0;
      Placed placed;
      placed.sigmas.assign(branch.points.size(), 0.0);
      std::vector<Complaint> found;
      compare_point(family, expected, special, placed, found);
      for (const Complaint& complaint : found) complain(who, "other: " + complaint.kind, complaint.text);
    }
    ++verdict_.families;
  }

  /// A grazing that ends the first branch is the birth or the end of another one.
  void check_beyond(const AnswerBranch& branch) {
    if (answer_.interrupted || branch.stop != "grazing" || branch.special_points.empty()) return;
    const AnswerSpecial& last = branch.special_points.back();
    for (const AnswerBranch& other : answer_.branches) {
      if (other.parent == branch.id && other.parent_label == last.label) return;
      if (other.id == branch.id) continue;
      for (const AnswerSpecial& special : other.special_points)
        if (special.type == "GR" && std::fabs(special.value - last.value) < 1e-9 * (1.0 + std::fabs(last.value))) return;
    }
    complain("", "nothing beyond a grazing", last.label + " is followed by no branch");
  }

  void check_others() {
    for (const AnswerBranch& branch : answer_.branches)
      if (done_.count(branch.id) == 0) check_other(branch);
  }

  /// A family of a skeleton must be among its branches, complete and once: from end to end no gap is larger than a step and no
  /// special point is missing.
  void check_covered(const Family& family) {
    const std::string who = text("%d/%d family from %.17g to %.17g", family.frame.impacts(), family.frame.periods,
                                 family.samples.front().y.back(), family.samples.back().y.back());
    std::vector<std::pair<double, double>> pieces;
    for (const AnswerBranch& branch : answer_.branches) {
      if (branch.period != family.frame.periods || branch.points.empty() ||
          branch.points.front().impacts != family.frame.impacts())
        continue;
      double first = 1e300, last = -1e300, size = 1.0;
      for (const AnswerPoint& point : branch.points)
        for (const State& state : point.states) size = std::max(size, largest(state));
      for (const AnswerPoint& point : branch.points)
        for (const Place& place : places(family, point.value, point.states, state_tolerance * size)) {
          first = std::min(first, place.sigma);
          last = std::max(last, place.sigma);
        }
      if (first <= last) pieces.emplace_back(first, last);
    }
    std::sort(pieces.begin(), pieces.end());
    double reached = 0.0;
    const double total = family.samples.back().sigma, gap = std::min(largest_gap, 0.05 + 0.3 * total);
    if (pieces.empty()) return complain(who, "family missing", text("on no branch (arclength %.2g)", total));
    for (const auto& [first, last] : pieces) {
      if (first > reached + gap)
        complain(who, "piece missing", text("from arclength %.3g to %.3g of %.3g", reached, first, total));
      if (reached - first > gap && last - first > gap)
        complain(who, "family twice", text("from arclength %.3g to %.3g of %.3g", first, reached, total));
      reached = std::max(reached, last);
    }
    if (reached < total - gap) complain(who, "piece missing", text("from arclength %.3g to %.3g", reached, total));
    for (const Located& point : family.points) {
      bool found = false;
      for (const AnswerBranch& branch : answer_.branches)
        for (const AnswerSpecial& special : branch.special_points)
          // A grazing may be listed only on the branch beyond it, from which the family was found.
          found = found || (same_type(special, point) && (point.kind == Kind::GR || special.period == family.frame.periods) &&
                            std::fabs(special.value - static_cast<double>(point.value)) <
                                same_point * scale(family, static_cast<double>(point.value)));
      if (!found) complain(who, std::string("skeleton: missing ") + name(point.kind), described(point) + " is missing");
    }
  }

  /// A branch that is not known in advance: its family is followed from one of its first points.
  void check_other(const AnswerBranch& branch) {
    done_.insert(branch.id);
    if (branch.points.size() < 3 || branch.points.front().sticking) return;
    Frame frame = frame_;
    const int impacts = branch.points.front().impacts;
    frame.periods = branch.period;
    if (impacts == 0 && frame.periods == 1) check_impactless(branch);
    if (impacts < 1 || impacts > most_impacts_) return;
    const std::string who = text("branch %d (%d/%d)", branch.id, impacts, frame.periods);
    for (std::size_t i = 0; i < std::min<std::size_t>(first_points, branch.points.size() - 1); ++i) {
      const AnswerPoint& point = branch.points[i];
      if (point.impacts != impacts) break;
      double size = 1.0;
      for (const State& state : point.states) size = std::max(size, largest(state));
      const std::optional<Orbit> start = events_of(frame, impacts, point.value, point.states, state_tolerance * size);
      if (!start) continue;
      AnswerBranch rest = branch;
      rest.points.erase(rest.points.begin(), rest.points.begin() + static_cast<std::ptrdiff_t>(i));
      std::erase_if(rest.special_points, [&](const AnswerSpecial& special) { return special.after_point < static_cast<int>(i); });
      for (AnswerSpecial& special : rest.special_points) special.after_point -= static_cast<int>(i);
      // A fold may lie before the next point: the correct direction is the one in which the point is reached first.
      int direction = branch.points[i + 1].value > point.value ? 1 : -1;
      const auto reached = [&](int way) {
        const Family family = follow(start->frame, start->y, range_, way);
        const AnswerPoint& next = branch.points[i + 1];
        const std::vector<Place> found = places(family, next.value, next.states, state_tolerance * size);
        return found.empty() ? 1e300 : found.front().sigma;
      };
      if (reached(-direction) < reached(direction)) direction = -direction;
      compare_with(rest, who, [&](const FollowOptions& options) -> std::optional<Family> {
        return follow(start->frame, start->y, range_, direction, options);
      });
      return;
    }
    ++verdict_.unresolved;
  }

  const Frame& frame_;
  const Range range_;
  const Answer& answer_;
  int most_impacts_, most_periods_ = std::numeric_limits<int>::max();
  Verdict verdict_;
  std::set<int> done_;
};

}  // namespace

std::vector<Complaint> compare(const Family& family, const AnswerBranch& branch) {
  std::vector<Complaint> out;
  const Placed placed = place_points(family, branch, out);
  compare_points(family, branch, placed, out);
  compare_multipliers(family, branch, out);
  if (branch.stop != interrupted) compare_end(family, branch, placed, out);
  return out;
}

namespace {

/// The scenario of a grazing may follow from a branch that an interrupted run did not reach.
Verdict without_open_scenarios(Verdict verdict, const Answer& answer) {
  if (answer.interrupted)
    std::erase_if(verdict.complaints,
                  [](const Complaint& one) { return one.kind == "scenario" && one.text.ends_with("unknown"); });
  return verdict;
}

}  // namespace

Verdict check(const Case& one, const Answer& answer, int most_impacts) {
  return without_open_scenarios(Check(one.frame, one.range(), answer, most_impacts).continued(one), answer);
}

Verdict check_skeleton(const SkeletonCase& one, const Answer& answer, int most_impacts) {
  return without_open_scenarios(Check(one.frame, one.range, answer, most_impacts).skeleton(one.most_periods), answer);
}

AnswerBranch answer_of(const Family& family, int id) {
  AnswerBranch out;
  out.id = id;
  out.period = family.frame.periods;
  // Labels must not appear twice in an answer of several branches.
  int count = 1000 * id;
  for (const Sample& sample : family.samples) {
    // The end of a family that grazes is its last special point.
    if (family.end == End::grazing && &sample == &family.samples.back()) break;
    out.points.push_back({sample.y.back(), states_of(family.frame, sample.y), family.frame.impacts(), false, {}, {}});
    std::vector<std::complex<double>>& multipliers = out.points.back().multipliers;
    multipliers = multipliers_of(whole_monodromy(family.frame, sample.y));
    double most = 0.0;
    for (const std::complex<double>& mu : multipliers) most = std::max(most, std::abs(mu));
    out.points.back().stable = most < 1.0;
  }
  for (const Located& point : family.points) {
    AnswerSpecial special;
    special.type = name(point.kind);
    special.label = special.type + std::to_string(++count);
    special.status = "converged";
    special.value = static_cast<double>(point.value);
    special.precision = 1e-15 * (1.0 + std::fabs(special.value));
    special.interval = {special.value - special.precision, special.value + special.precision};
    std::size_t i = 0;
    while (i + 1 < out.points.size() && family.samples[i + 1].sigma <= point.sigma) ++i;
    special.after_point = static_cast<int>(i);
    special.period = family.frame.periods;
    special.impacts = family.frame.impacts();
    special.states = states_of(family.frame, converted<double>(point.orbit));
    special.multipliers = {point.kind == Kind::PD ? -1.0 : 1.0};  // of modulus 1, and real where required
    special.kind = point.kind != Kind::GR ? "" : point.gained ? "gained" : "lost";
    if (point.persistence) special.scenario = *point.persistence ? "persistence" : "nonsmooth-fold";
    if (point.supercritical) special.criticality = *point.supercritical ? "supercritical" : "subcritical";
    special.change = {point.before, point.after};
    out.special_points.push_back(special);
  }
  out.stop = family.end == End::bound ? "reached_bound" : family.end == End::grazing ? "grazing" : "returned";
  out.stop_value = family.end_value;
  return out;
}

}  // namespace graze::reference
