// SPDX-License-Identifier: GPL-3.0-or-later
#include "family.hpp"

#include <limits>

namespace graze::reference {

namespace {

/// The tangents of neighbouring samples enclose a smaller angle than this.
constexpr double least_cosine = 0.995;
constexpr double smallest_step = 1e-9;
/// A fold at this distance from the start still lies between two samples.
constexpr double first_step = 1e-6, halving_step = 2e-4;
/// Relative rounding of the parameter of an orbit in double. For large motions near resonance it exceeds that of a single
/// number.
constexpr double parameter_rounding = 1e-11;
/// Start of a doubled family: the largest change of a coordinate of the events from the doubling. The larger values are for
/// families whose parameter hardly changes at first: their equations are too close to singular in double.
constexpr std::array<double, 3> first_amplitudes = {1e-4, 1e-3, 1e-2};
/// Tolerance of Newton's method for orbits at an amplitude 1e-6 from a doubling: their equations are that close to singular.
const Quad beside_singular = Quad(1e-20);
/// Shift from a multiplier -1: far above the error of the multiplier, far below its distance to the others.
const Quad multiplier_shift = Quad(1e-10);

Values<double> difference(const Values<double>& a, const Values<double>& b) {
  Values<double> out = a;
  for (std::size_t k = 0; k < a.size(); ++k) out[k] -= b[k];
  return out;
}

double product(const Values<double>& a, const Values<double>& b, const Values<double>& weights) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += weights[k] * weights[k] * a[k] * b[k];
  return sum;
}

double length(const Values<double>& a, const Values<double>& weights) { return std::sqrt(product(a, a, weights)); }

/// Orbits between two samples, by a coordinate from 0 to 1 along their chord.
struct Chord {
  const Frame& frame;
  Values<double> weights, a, b;

  template <class Real> Constraint<Real> at(Real lambda) const {
    Constraint<Real> out{{}, Real(0)};
    for (std::size_t k = 0; k < a.size(); ++k) {
      out.row.push_back(Real(weights[k] * weights[k] * (b[k] - a[k])));
      out.value += out.row[k] * (Real(a[k]) + lambda * Real(b[k] - a[k]));
    }
    return out;
  }
  template <class Real> Values<Real> guess(Real lambda) const {
    Values<Real> out;
    for (std::size_t k = 0; k < a.size(); ++k) out.push_back(Real(a[k]) + lambda * Real(b[k] - a[k]));
    return out;
  }
  std::optional<Values<double>> orbit(double lambda) const { return corrected(frame, guess(lambda), at(lambda)); }
};

/// Zero of `condition` (of an orbit in double) between 0 and `last`, by bisection of its change of sign.
template <class Condition> std::optional<double> bisected(const Chord& chord, const Condition& condition, double last = 1.0) {
  double low = 0.0, high = last;
  const std::optional<Values<double>> first = chord.orbit(low), other = chord.orbit(high);
  if (!first || !other) return std::nullopt;
  const bool sign = condition(*first) > 0.0;
  if ((condition(*other) > 0.0) == sign) return std::nullopt;
  for (int k = 0; k < 44; ++k) {
    const double middle = 0.5 * (low + high);
    const std::optional<Values<double>> y = chord.orbit(middle);
    if (!y) return std::nullopt;
    ((condition(*y) > 0.0) == sign ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

struct Root {
  Quad lambda{};
  double error = 0.0;  ///< of lambda
  Values<Quad> y;
};

/// Secant method in Quad from a value known in double.
template <class Condition> std::optional<Root> refined(const Chord& chord, double lambda, const Condition& condition) {
  Quad a = lambda, b = Quad(lambda) + Quad(1e-8);
  std::optional<Values<Quad>> y = corrected(chord.frame, chord.guess(a), chord.at(a), 20);
  if (!y) return std::nullopt;
  Quad value_a = condition(*y);
  double change = 1.0;
  for (int k = 0; k < 12; ++k) {
    y = corrected(chord.frame, *y, chord.at(b), 20);
    if (!y) return std::nullopt;
    const Quad value_b = condition(*y);
    if (value_b == value_a || value_b == Quad(0)) break;
    const Quad next = b - value_b * (b - a) / (value_b - value_a);
    change = static_cast<double>(magnitude(next - b));
    a = b;
    value_a = value_b;
    b = next;
    if (change < 1e-26) break;
  }
  y = corrected(chord.frame, *y, chord.at(b), 20);
  if (!y || magnitude(b - Quad(lambda)) > Quad(1e-5)) return std::nullopt;
  return Root{b, change, *y};
}

/// z with J(-1) z = 0, by inverse iteration. A shift is needed because J may be singular to the last bit.
Values<Quad> antiperiodic(const Frame& frame, const Values<Quad>& y) {
  Table<Quad> J = jacobian(frame, y, Quad(-1));
  Quad size(0);
  for (const Quad& entry : J.entries) size = std::max(size, magnitude(entry));
  for (std::size_t k = 0; k < frame.size(); ++k) J(k, k) += Quad(1e-29) * size;
  Values<Quad> z;
  for (std::size_t k = 0; k < frame.size(); ++k) z.push_back(Quad(1) / Quad(static_cast<double>(k) + 1.5));
  for (int k = 0; k < 3; ++k) {
    if (solve(J, z) == Quad(0)) break;
    Quad largest(0);
    for (const Quad& entry : z) largest = std::max(largest, magnitude(entry));
    for (Quad& entry : z) entry /= largest;
  }
  return z;
}

int sign_of(Quad value) { return value > Quad(0) ? 1 : value < Quad(0) ? -1 : 0; }

/// The frame of an orbit of twice the period; for half a symmetric orbit, that of the whole.
Frame doubled_frame(const Frame& frame) {
  Frame out = frame;
  for (std::size_t i = 0; i < frame.legs(); ++i) out.stops.push_back(frame.stop(i + frame.legs()));
  if (!frame.half) out.periods *= 2;
  out.half = false;
  return out;
}

/// The orbit as one of twice the period; half a symmetric orbit, as the whole.
template <class Real> Values<Real> twice(const Frame& frame, const Values<Real>& y) {
  Values<Real> out(y.begin(), y.end() - 1);
  for (std::size_t k = 0; k < frame.size(); ++k) out.push_back(y[k] + (k % frame.block() == 0 ? frame.turn<Real>() : Real(0)));
  out.push_back(y.back());
  return out;
}

/// The doubled orbit of amplitude e near the doubling y.
std::optional<Values<Quad>> doubled_orbit(const Frame& frame, const Values<Quad>& y, Quad e) {
  const std::size_t n = frame.size();
  const Values<Quad> z = antiperiodic(frame, y);
  Constraint<Quad> constraint{Values<Quad>(2 * n + 1, Quad(0)), Quad(0)};
  const Values<Quad> same = twice(frame, y);
  Values<Quad> guess = same;
  for (std::size_t k = 0; k < n; ++k) {
    constraint.row[k] = z[k];
    constraint.row[k + n] = -z[k];
    constraint.value += z[k] * (same[k] - same[k + n]) + e * Quad(2) * z[k] * z[k];
    guess[k] += e * z[k];
    guess[k + n] -= e * z[k];
  }
  return corrected(doubled_frame(frame), guess, constraint, 30, beside_singular);
}

/// Sign of c in p = p_0 + c e^2 of the doubled orbits; nothing if two amplitudes disagree.
std::optional<int> doubled_side(const Frame& frame, const Values<Quad>& y) {
  std::optional<Quad> curvature;
  for (const double amplitude : {1e-5, 1e-6}) {
    const std::optional<Values<Quad>> orbit = doubled_orbit(frame, y, Quad(amplitude));
    if (!orbit) return std::nullopt;
    const Quad now = (orbit->back() - y.back()) / (Quad(amplitude) * Quad(amplitude));
    if (curvature && magnitude(now - *curvature) > Quad(0.05) * magnitude(now)) return std::nullopt;
    curvature = now;
  }
  return sign_of(*curvature);
}

/// The orbit on the chord at distance `delta` in lambda from the root.
std::optional<Values<Quad>> beside(const Chord& chord, const Root& root, double delta) {
  return corrected(chord.frame, root.y, chord.at(root.lambda + Quad(delta)), 20);
}

void judge_doubling(const Chord& chord, const Root& root, Located& point) {
  point.side = doubled_side(chord.frame, root.y);
  if (!point.side || *point.side == 0) return;
  // Side of p on which det(M + I) has the sign of a multiplier beyond -1. This sign also depends on the other multipliers,
  // through det(M + (1 + d) I) / d.
  const bool others = characteristic(monodromy(chord.frame, root.y), Quad(-1) - multiplier_shift) > Quad(0);
  std::optional<int> unstable;
  for (const double delta : {1e-6, -1e-6}) {
    const std::optional<Values<Quad>> y = beside(chord, root, delta);
    if (!y) return;
    if ((characteristic(monodromy(chord.frame, *y), Quad(-1)) < Quad(0)) == others) unstable = sign_of(y->back() - root.y.back());
  }
  if (unstable) point.supercritical = *unstable == *point.side;
}

/// Sign of c in p = p_0 + c w of the orbits with one more impact, of speed w.
std::optional<int> added_side(const Frame& frame, const Values<Quad>& y, const Summit<Quad>& summit) {
  Frame more = frame;
  more.stops.insert(more.stops.begin() + static_cast<std::ptrdiff_t>(summit.leg) + 1, static_cast<int>(summit.stop));
  const std::size_t k = frame.block() * (summit.leg + 1);
  const Leg<Quad> here = leg(frame, y, summit.leg);
  const Quad phase = here.phase + here.system.q[ETA] * summit.time;
  Values<Quad> block =
      block_of(here.system, here.system.stops[summit.stop], phase, flight(here.system, here.phase, here.start, summit.time));
  std::optional<int> side;
  for (const double speed : {1e-6, 1e-7}) {
    Values<Quad> guess = y;
    block[1] = Quad(speed);
    guess.insert(guess.begin() + static_cast<std::ptrdiff_t>(k), block.begin(), block.end());
    Constraint<Quad> constraint{Values<Quad>(more.size() + 1, Quad(0)), Quad(speed)};
    constraint.row[k + 1] = Quad(1);
    const std::optional<Values<Quad>> orbit = corrected(more, guess, constraint, 30);
    if (!orbit) return std::nullopt;
    const int now = sign_of(orbit->back() - y.back());
    if (side && now != *side) return std::nullopt;
    side = now;
  }
  return side;
}

/// At a lost grazing: whether impact i is lost. Several are lost at once if the orbit becomes one of a lower period.
bool is_lost(const Frame& frame, const Values<Quad>& y, std::size_t i) {
  return magnitude(y[frame.block() * i + 1]) < Quad(1e-15);
}

/// Number for the whole orbit.
int count_lost(const Frame& frame, const Values<Quad>& y) {
  int count = 0;
  for (std::size_t i = 0; i < frame.legs(); ++i) count += is_lost(frame, y, i) ? 1 : 0;
  return frame.half ? 2 * count : count;
}

/// Sign of p - p_0 on the side where the orbit without the lost impacts (w_i = 0) stays below the stops.
std::optional<int> removed_side(const Frame& frame, const Values<Quad>& y) {
  const Quad p = y.back(), h = Quad(1e-8) * (Quad(1e-3) + magnitude(p)), turn = frame.turn<Quad>();
  std::optional<int> side;
  if (count_lost(frame, y) == frame.impacts()) {
    for (const int sign : {-1, 1})
      if (clearance(frame.system(p + Quad(sign) * h)) > Quad(0)) side = sign;
    return side;
  }
  Frame fewer = frame;
  fewer.stops.clear();
  Values<Quad> rest;
  for (std::size_t i = 0; i < frame.legs(); ++i) {
    if (is_lost(frame, y, i)) continue;
    const auto block = y.begin() + static_cast<std::ptrdiff_t>(frame.block() * i);
    rest.insert(rest.end(), block, block + static_cast<std::ptrdiff_t>(frame.block()));
    fewer.stops.push_back(frame.stops[i]);
  }
  rest.push_back(p);
  int found = 0;
  for (const int sign : {-1, 1}) {
    const std::optional<Values<Quad>> orbit = corrected(fewer, rest, fixed_parameter(fewer, p + Quad(sign) * h), 30);
    if (!orbit) return std::nullopt;
    bool below = true;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < frame.legs(); ++i) {
      if (!is_lost(frame, y, i)) {
        ++kept;
        continue;
      }
      // On the flight after the kept impact before it. This may be the last impact of the turn before: for half a symmetric
      // orbit, its mirror image.
      const std::size_t before = (kept + fewer.legs() - 1) % fewer.legs();
      const Quad from = rest[frame.block() * before] - (kept == 0 ? turn : Quad(0));
      const int stop = kept == 0 && frame.half ? 1 - frame.stops[i] : frame.stops[i];
      const Summit<Quad> touched{before, static_cast<std::size_t>(stop), (y[frame.block() * i] - from) / fewer.at(p)[ETA],
                                 Quad(0)};
      below = below && polished_summit(fewer, *orbit, touched).height < Quad(0);
    }
    if (!below) continue;
    side = sign;
    ++found;
  }
  return found == 1 ? side : std::nullopt;
}

/// Sign of p - p_0 just before the root.
std::optional<int> family_side(const Chord& chord, const Root& root) {
  const std::optional<Values<Quad>> y = beside(chord, root, -1e-6);
  if (!y) return std::nullopt;
  return sign_of(y->back() - root.y.back());
}

std::optional<Values<double>> tangent_at(const Frame& frame, const Values<double>& y, const Values<double>& along,
                                         const Values<double>& weights) {
  Values<double> row, t(frame.size(), 0.0);
  for (std::size_t k = 0; k < along.size(); ++k) row.push_back(weights[k] * weights[k] * along[k]);
  t.push_back(1.0);
  if (solve(bordered(frame, y, row), t) == 0.0) return std::nullopt;
  const double size = length(t, weights);
  if (!(size > 0.0) || !std::isfinite(size)) return std::nullopt;
  for (double& entry : t) entry /= size;
  return t;
}

/// y with its impacts renumbered from j on, and shifted by whole periods as close as possible to `near`. Nothing if the stops
/// then differ.
std::optional<Values<double>> rotated(const Frame& frame, const Values<double>& y, std::size_t j, const Values<double>& near) {
  const std::size_t n = frame.block(), m = frame.legs();
  Values<double> out;
  for (std::size_t i = 0; i < m; ++i) {
    if (frame.stop(i + j) != frame.stop(i)) return std::nullopt;
    for (std::size_t k = 0; k < n; ++k)
      out.push_back(y[n * ((i + j) % m) + k] + (k == 0 && i + j >= m ? frame.turn<double>() : 0.0));
  }
  out.push_back(y.back());
  const double shift = 2.0 * pi<double>() * std::round((near[0] - out[0]) / (2.0 * pi<double>()));
  for (std::size_t i = 0; i < m; ++i) out[n * i] += shift;
  return out;
}

/// Places on the chord where the parameter is p. The parameter is monotonic between `ends` (those of the chord, and the folds
/// on it). A p beyond an end by no more than rounding counts as the end.
std::vector<double> places_on(const Chord& chord, double p, const std::vector<double>& ends) {
  const auto value = [&](double lambda) {
    const std::optional<Values<double>> y = chord.orbit(lambda);
    return y ? y->back() - p : std::numeric_limits<double>::quiet_NaN();
  };
  const double rounding = parameter_rounding * (1.0 + std::fabs(p));
  std::vector<double> out;
  for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
    double low = ends[k], high = ends[k + 1], at_low = value(low), at_high = value(high);
    if (std::fabs(at_low) <= rounding) out.push_back(low);
    if ((at_low > 0.0) != (at_high > 0.0)) {
      for (int step = 0; step < 60 && high - low > 1e-13; ++step) {
        // Regula falsi, with a bisection every third step.
        const double next = step % 3 == 2 ? 0.5 * (low + high) : low + (high - low) * at_low / (at_low - at_high);
        const double here = value(next);
        if (here == 0.0) {
          low = high = next;
        } else if ((here > 0.0) == (at_low > 0.0)) {
          low = next;
          at_low = here;
        } else {
          high = next;
          at_high = here;
        }
      }
      out.push_back(0.5 * (low + high));
    }
    if (std::fabs(at_high) <= rounding) out.push_back(high);
  }
  return out;
}

class Follower {
 public:
  Follower(const Frame& frame, const Values<double>& start, const Range& range, const Values<double>& along,
           const FollowOptions& options)
      : options_(options) {
    family_.frame = frame;
    family_.range = range;
    double speed = 0.1 * std::max(std::fabs(frame.at(start.back())[R]), std::fabs(frame.at(start.back())[XI]));
    for (std::size_t k = 1; k < frame.size(); k += frame.block()) speed = std::max(speed, start[k]);
    for (std::size_t k = 0; k < frame.size(); ++k) family_.weights.push_back(k % frame.block() == 0 ? 1.0 : 1.0 / speed);
    family_.weights.push_back(2.0 / (range.high - range.low));
    family_.samples.push_back({0.0, start});
    const std::optional<Values<double>> first = tangent_at(frame, start, along, family_.weights);
    if (first) first_ = tangent_ = *first;
  }

  Family run() {
    double h = first_step;
    while (!tangent_.empty() && static_cast<int>(family_.samples.size()) < options_.most && h > smallest_step) {
      const std::optional<Values<double>> next = step(h);
      // Where the halves of a doubled orbit coincide, the last sample must lie close before.
      const Chord chord{family_.frame, family_.weights, family_.samples.back().y, next.value_or(family_.samples.back().y)};
      if (!next || (h > halving_step && halves(chord))) {
        h *= 0.5;
        continue;
      }
      if (take(*next)) return family_;
      h = std::min(options_.step, 1.3 * h);
    }
    family_.end = End::broken;
    family_.end_value = family_.samples.back().y.back();
    return family_;
  }

 private:
  std::optional<Values<double>> step(double h) {
    const Values<double>& here = family_.samples.back().y;
    Values<double> guess = here;
    Constraint<double> constraint{{}, 0.0};
    for (std::size_t k = 0; k < here.size(); ++k) {
      guess[k] += h * tangent_[k];
      constraint.row.push_back(family_.weights[k] * family_.weights[k] * tangent_[k]);
      constraint.value += constraint.row[k] * guess[k];
    }
    const std::optional<Values<double>> y = corrected(family_.frame, guess, constraint, 6);
    if (!y || length(difference(*y, guess), family_.weights) > 0.2 * h) return std::nullopt;
    const std::optional<Values<double>> t = tangent_at(family_.frame, *y, tangent_, family_.weights);
    if (!t || product(*t, tangent_, family_.weights) < least_cosine) return std::nullopt;
    next_tangent_ = *t;
    return y;
  }

  /// Takes the step to `next` with its points; returns whether the family ends in it.
  bool take(const Values<double>& next) {
    const Frame& frame = family_.frame;
    const Sample last = family_.samples.back();
    const Chord chord{frame, family_.weights, last.y, next};
    const double size = length(difference(next, last.y), family_.weights);
    double limit = 1.0;
    std::optional<End> end;
    std::optional<Located> grazing;
    const auto end_at = [&](End what, double lambda) {
      if (lambda >= limit) return;
      limit = lambda;
      end = what;
      grazing.reset();
    };
    // Between two samples the parameter is extreme at a fold, if there is one.
    std::optional<double> fold;
    if ((condition(frame, last.y, 1) > 0.0) != (condition(frame, next, 1) > 0.0)) {
      fold = bisected(chord, [&](const Values<double>& y) { return condition(frame, y, 1); });
      if (!fold) return broken();
    }
    for (const double furthest : {fold.value_or(1.0), 1.0}) {
      const std::optional<Values<double>> far = chord.orbit(furthest);
      if (!far) return broken();
      for (const double bound : {family_.range.low, family_.range.high}) {
        const double side = bound == family_.range.low ? 1.0 : -1.0;
        if (side * (far->back() - bound) >= 0.0) continue;
        const auto inside = [&](const Values<double>& y) { return side * (y.back() - bound); };
        const std::optional<double> lambda = bisected(chord, inside, furthest);
        if (!lambda) return broken();
        if (*lambda < limit) bound_ = bound;
        end_at(End::bound, *lambda);
      }
      if (end) break;
    }
    for (std::size_t i = 0; i < frame.legs(); ++i)
      if (const std::size_t k = frame.block() * i + 1; next[k] <= 0.0) {
        const std::optional<double> lambda = bisected(chord, [k](const Values<double>& y) { return y[k]; });
        if (!lambda) return broken();
        if (*lambda >= limit) continue;
        const std::optional<Root> root = refined(chord, *lambda, [k](const Values<Quad>& y) { return y[k]; });
        if (!root) return broken();
        end_at(End::grazing, *lambda);
        Located point = located(Kind::GR, chord, *root, last.sigma, size);
        point.which = i;
        point.before = frame.impacts();
        point.after = frame.impacts() - count_lost(frame, root->y);
        const std::optional<int> own = family_side(chord, *root), other = removed_side(frame, root->y);
        if (own && other) point.persistence = *own != *other;
        grazing = point;
      }
    // The other maxima of an orbit that loses its only impact reach the barrier at the same time: they count only if they come
    // first.
    const double before = end == End::grazing ? limit * (1.0 - 1e-7) : limit;
    const std::optional<Values<double>> last_orbit = chord.orbit(before);
    if (!last_orbit) return broken();
    if (gap(frame, *last_orbit) > 0.0 && before > 1e-9) {
      const std::optional<double> lambda = bisected(
          chord, [&](const Values<double>& y) { return gap(frame, y); }, before);
      if (!lambda) return broken();
      const std::optional<Values<double>> touching = chord.orbit(*lambda);
      if (!touching) return broken();
      const std::vector<Summit<double>> all = summits(frame, *touching);
      if (all.empty()) return broken();
      const Summit<double> top = all.front();
      const Summit<Quad> guess{top.leg, top.stop, Quad(top.time), Quad(0)};
      const auto height = [&](const Values<Quad>& y) { return polished_summit(frame, y, guess).height; };
      const std::optional<Root> root = refined(chord, *lambda, height);
      if (!root) return broken();
      // If the orbit without the lost impact closes after a part of its period, its other turns touch at the same time.
      const bool with_lost = end == End::grazing && count_lost(frame, root->y) > 0;
      if (!with_lost) {
        end_at(End::grazing, *lambda);
        Located point = located(Kind::GR, chord, *root, last.sigma, size);
        point.gained = true;
        point.which = top.leg;
        point.before = frame.impacts();
        point.after = frame.impacts() + (frame.half ? 2 : 1);
        const std::optional<int> own = family_side(chord, *root);
        const std::optional<int> other = added_side(frame, root->y, polished_summit(frame, root->y, guess));
        if (own && other) point.persistence = *own != *other;
        if (frame.half) {
          // Both stops are touched at once: the orbits with one impact more are less symmetric.
          const std::optional<int> single =
              added_side(doubled_frame(frame), twice(frame, root->y), polished_summit(frame, root->y, guess));
          if (own && single) point.persistence_single = *own != *single;
        }
        grazing = point;
      }
    }
    if (sticks(frame, next)) {
      const std::optional<double> lambda = bisected(chord, [&](const Values<double>& y) { return pressing(frame, y); });
      if (!lambda) return broken();
      end_at(End::sticking, *lambda);
    }
    if (const std::optional<double> lambda = closes(chord, size)) end_at(End::closed, *lambda);

    std::vector<Located> found;
    if (halves(chord)) {
      if (!mirrored()) {
        family_.end = End::halved;
        family_.end_value = last.y.back();
        return true;
      }
      const std::optional<Located> breaking = symmetry_breaking(chord, last.sigma + 0.5 * size);
      if (!breaking) return broken();
      found.push_back(*breaking);
    }

    if (fold && *fold < limit) {
      const std::optional<Root> root = refined(chord, *fold, [&](const Values<Quad>& y) { return condition(frame, y, 1); });
      if (!root) return broken();
      found.push_back(located(Kind::LP, chord, *root, last.sigma, size));
    }
    // The other conditions, where they change sign.
    const auto crossed = [&](const auto& function) -> std::optional<std::optional<Root>> {
      if ((function(last.y) > 0.0) == (function(next) > 0.0)) return std::optional<Root>();
      const std::optional<double> lambda = bisected(chord, function);
      if (!lambda) return std::nullopt;
      if (*lambda >= limit) return std::optional<Root>();
      const std::optional<Root> root = refined(chord, *lambda, function);
      if (!root) return std::nullopt;
      return root;
    };
    const auto doubling = crossed([&](const auto& y) { return condition(frame, y, -1); });
    if (!doubling) return broken();
    if (*doubling) {
      Located point = located(frame.half ? Kind::BP : Kind::PD, chord, **doubling, last.sigma, size);
      judge_doubling(chord, **doubling, point);
      found.push_back(point);
    }
    // Beyond a grazing, multipliers are meaningless.
    if (is_chain(frame.model) && !(end == End::grazing)) {
      const auto circle = crossed([&](const auto& y) { return pair_condition(monodromy(frame, y)); });
      if (!circle) return broken();
      if (*circle && on_circle(monodromy(frame, (*circle)->y)))
        found.push_back(located(Kind::NS, chord, **circle, last.sigma, size));
    }
    std::sort(found.begin(), found.end(), [](const Located& one, const Located& other) { return one.sigma < other.sigma; });
    family_.points.insert(family_.points.end(), found.begin(), found.end());
    if (end) {
      const std::optional<Values<double>> y = chord.orbit(limit);
      if (!y) return broken();
      family_.samples.push_back({last.sigma + limit * size, *y});
      if (grazing) family_.points.push_back(*grazing);
      family_.end = *end;
      family_.end_value = *end == End::bound ? bound_ : *end == End::grazing ? static_cast<double>(grazing->value) : y->back();
      return true;
    }
    family_.samples.push_back({last.sigma + size, next});
    tangent_ = next_tangent_;
    return false;
  }

  bool broken() {
    family_.end = End::broken;
    family_.end_value = family_.samples.back().y.back();
    return true;
  }

  Located located(Kind kind, const Chord& chord, const Root& root, double sigma, double size) const {
    Located out;
    out.kind = kind;
    out.value = root.y.back();
    out.error = root.error * std::fabs(chord.b.back() - chord.a.back());
    out.sigma = sigma + static_cast<double>(root.lambda) * size;
    out.orbit = root.y;
    return out;
  }

  /// The place where the step passes the start again, in the same direction.
  std::optional<double> closes(const Chord& chord, double size) const {
    const Values<double>& start = family_.samples.front().y;
    if (family_.samples.size() < 3) return std::nullopt;
    for (std::size_t j = 0; j < family_.frame.legs(); ++j) {
      const std::optional<Values<double>> a = rotated(family_.frame, chord.a, j, start),
                                          b = rotated(family_.frame, chord.b, j, start);
      if (!a || !b) continue;
      const Values<double> step = difference(*b, *a);
      const double lambda = product(difference(start, *a), step, family_.weights) / (size * size);
      if (!(lambda > 0.0 && lambda <= 1.0) || product(step, first_, family_.weights) < 0.9 * size) continue;
      const std::optional<Values<double>> y = chord.orbit(lambda);
      if (!y) continue;
      if (length(difference(*rotated(family_.frame, *y, j, start), start), family_.weights) < 1e-7) return lambda;
    }
    return std::nullopt;
  }

  /// Whether the compared halves of a whole orbit are mirror images, as for a symmetric orbit.
  bool mirrored() const { return family_.frame.periods % 2 != 0; }

  /// The symmetric orbit on the chord at which the family of less symmetric orbits ends. There the family continues with their
  /// mirror images.
  std::optional<Located> symmetry_breaking(const Chord& chord, double sigma) const {
    // Distance in the parameter to either side, within its range. On the family the parameter changes by the square of the
    // step.
    const double beside = 1e-5 * (family_.range.high - family_.range.low);
    const std::size_t n = family_.frame.size() / 2;
    Frame frame = family_.frame;
    frame.stops.resize(frame.legs() / 2);
    frame.half = true;
    Values<double> middle, weights(family_.weights.begin(), family_.weights.begin() + static_cast<std::ptrdiff_t>(n));
    for (std::size_t k = 0; k < n; ++k) {
      const double shift = k % frame.block() == 0 ? frame.turn<double>() : 0.0;
      middle.push_back(0.5 * (chord.a[k] + chord.a[k + n] - shift));
    }
    const double p = chord.a.back();
    middle.push_back(p);
    weights.push_back(family_.weights.back());
    const std::optional<Values<double>> low = corrected(frame, middle, fixed_parameter(frame, p - beside));
    const std::optional<Values<double>> high = corrected(frame, middle, fixed_parameter(frame, p + beside));
    if (!low || !high) return std::nullopt;
    const Chord symmetric{frame, weights, *low, *high};
    const std::optional<double> lambda = bisected(symmetric, [&](const auto& y) { return condition(frame, y, -1); });
    if (!lambda) return std::nullopt;
    const std::optional<Root> root = refined(symmetric, *lambda, [&](const auto& y) { return condition(frame, y, -1); });
    if (!root) return std::nullopt;
    Located out = located(Kind::BP, symmetric, *root, sigma, 0.0);
    out.orbit = twice(frame, root->y);
    return out;
  }

  /// Whether both halves of the orbit coincide on the chord. The family of the undoubled orbits passes there too, and the step
  /// may have switched to it.
  bool halves(const Chord& chord) const {
    constexpr double same = 1e-7;
    const Frame& frame = family_.frame;
    const std::size_t n = frame.size() / 2, m = frame.legs() / 2;
    if (frame.half || frame.legs() % 2 != 0 || (mirrored() && frame.model != Model::equal_stops)) return false;
    for (std::size_t i = 0; i < m; ++i)
      if ((frame.stops[i] == frame.stops[i + m]) == mirrored()) return false;
    const auto unlike = [&](const Values<double>& y) {
      Values<double> out;
      for (std::size_t k = 0; k < n; ++k) {
        const double shift = k % frame.block() == 0 ? 0.5 * frame.turn<double>() : 0.0;
        out.push_back(family_.weights[k] * (y[k + n] - y[k] - shift));
      }
      return out;
    };
    const Values<double> a = unlike(chord.a), b = unlike(chord.b);
    double sum = 0.0, size = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      sum += a[k] * b[k];
      size += b[k] * b[k];
    }
    return sum < 0.0 || size < same * same;
  }

  FollowOptions options_;
  Family family_;
  Values<double> first_, tangent_, next_tangent_;
  double bound_ = 0.0;
};

}  // namespace

Family follow(const Frame& frame, const Values<double>& start, const Range& range, int direction, const FollowOptions& options) {
  Values<double> along(start.size(), 0.0);
  along.back() = direction;
  return Follower(frame, start, range, along, options).run();
}

Family follow_both_ways(const Frame& frame, const Values<double>& start, const Range& range, const FollowOptions& options) {
  Family back = follow(frame, start, range, -1, options);
  if (back.end == End::closed || back.end == End::broken) return back;
  Family on = follow(frame, start, range, 1, options);
  if (on.end == End::broken) return on;
  // Joins the two pieces, with the weights common to both.
  const double turn = back.samples.back().sigma;
  Family out = on;
  for (Sample& sample : out.samples) sample.sigma += turn;
  for (Located& point : out.points) point.sigma += turn;
  std::vector<Sample> samples;
  for (std::size_t k = back.samples.size(); k-- > 1;) samples.push_back({turn - back.samples[k].sigma, back.samples[k].y});
  out.samples.insert(out.samples.begin(), samples.begin(), samples.end());
  for (Located& point : back.points) {
    point.sigma = turn - point.sigma;
    std::swap(point.before, point.after);
  }
  std::reverse(back.points.begin(), back.points.end());
  out.points.insert(out.points.begin(), back.points.begin(), back.points.end());
  return out;
}

std::optional<Family> follow_doubled(const Family& parent, const Located& doubling, const FollowOptions& options, int sign) {
  if (!doubling.side) return std::nullopt;
  Values<double> along = converted<double>(antiperiodic(parent.frame, doubling.orbit));
  for (std::size_t k = 0; k < parent.frame.size(); ++k) along.push_back(-along[k]);
  along.push_back(0.0);
  for (double& entry : along) entry *= sign;
  for (const double amplitude : first_amplitudes) {
    const std::optional<Values<Quad>> orbit = doubled_orbit(parent.frame, doubling.orbit, Quad(sign * amplitude));
    if (!orbit) return std::nullopt;
    const Values<double> start = converted<double>(*orbit);
    if (start.back() < parent.range.low || start.back() > parent.range.high) return std::nullopt;
    Family found = Follower(doubled_frame(parent.frame), start, parent.range, along, options).run();
    if (found.end == End::broken) continue;
    found.origin = converted<double>(twice(parent.frame, doubling.orbit));
    if (found.end == End::halved) {
      // Ends at the nearest other doubling of the parent.
      double least = 1e300;
      for (const Located& other : parent.points) {
        if (other.kind != doubling.kind || &other == &doubling) continue;
        const double far = apart(states_of(found.frame, converted<double>(twice(parent.frame, other.orbit))),
                                 states_of(found.frame, found.samples.back().y));
        if (far < least) found.end_value = static_cast<double>(other.value);
        least = std::min(least, far);
      }
    }
    return found;
  }
  return std::nullopt;
}

State state_of(const Linear<double>& system, const Point<double>& z) {
  State out;
  for (std::size_t k = 0; k < system.size(); ++k) out.push_back(z[system.index(k)]);
  return out;
}

Point<double> point_of(const Linear<double>& system, const State& state) {
  Point<double> out{};
  for (std::size_t k = 0; k < std::min(state.size(), system.size()); ++k) out[system.index(k)] = state[k];
  return out;
}

std::vector<State> states_of(const Frame& frame, const Values<double>& y) {
  if (frame.half) return states_of(doubled_frame(frame), twice(frame, y));
  const double turn = 2.0 * pi<double>();
  std::vector<State> out;
  double next = turn * std::ceil(y[0] / turn);
  for (std::size_t i = 0; i < frame.legs(); ++i) {
    const Leg<double> here = leg(frame, y, i);
    for (; next < here.end_phase() && static_cast<int>(out.size()) < frame.periods; next += turn)
      out.push_back(state_of(here.system, flight(here.system, here.phase, here.start, (next - here.phase) / here.system.q[ETA])));
  }
  return out;
}

double apart(const std::vector<State>& one, const std::vector<State>& other) {
  const std::size_t n = one.size();
  double best = 1e300;
  if (n != other.size()) return best;
  for (std::size_t j = 0; j < n; ++j) {
    double far = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      const State &a = one[(k + j) % n], &b = other[k];
      if (a.size() != b.size()) return best;
      for (std::size_t c = 0; c < a.size(); ++c) far = std::max(far, std::fabs(a[c] - b[c]));
    }
    best = std::min(best, far);
  }
  return best;
}

std::vector<Place> places(const Family& family, double p, const std::vector<State>& states, double tolerance) {
  std::vector<Place> out;
  const Frame& frame = family.frame;
  for (std::size_t i = 0; i + 1 < family.samples.size(); ++i) {
    const Sample &a = family.samples[i], &b = family.samples[i + 1];
    const double size = b.sigma - a.sigma, rounding = parameter_rounding * (1.0 + std::fabs(p));
    double low = std::min(a.y.back(), b.y.back()), high = std::max(a.y.back(), b.y.back());
    std::vector<double> ends = {0.0};
    for (const Located& point : family.points) {
      const bool turns = point.kind == Kind::LP || (point.kind == Kind::BP && !frame.half);
      if (!turns || point.sigma < a.sigma || point.sigma >= b.sigma) continue;
      ends.push_back((point.sigma - a.sigma) / size);
      low = std::min(low, static_cast<double>(point.value));
      high = std::max(high, static_cast<double>(point.value));
    }
    ends.push_back(1.0);
    if (p < low - rounding || p > high + rounding) continue;
    const Chord chord{frame, family.weights, a.y, b.y};
    for (const double lambda : places_on(chord, p, ends)) {
      const std::optional<Values<double>> y = chord.orbit(lambda);
      if (!y) continue;
      const double distance = apart(states_of(frame, *y), states), sigma = a.sigma + lambda * size;
      if (distance > tolerance) continue;
      if (out.empty() || sigma - out.back().sigma > 1e-9 * size)
        out.push_back({sigma, distance, *y});
      else if (distance < out.back().distance)
        out.back() = {sigma, distance, *y};
    }
  }
  return out;
}

const char* name(Kind kind) {
  constexpr std::array<const char*, 5> names = {"LP", "PD", "BP", "NS", "GR"};
  return names[static_cast<std::size_t>(kind)];
}

const char* name(End end) {
  switch (end) {
  case End::bound:
    return "bound";
  case End::grazing:
    return "grazing";
  case End::closed:
    return "closed";
  case End::sticking:
    return "sticking";
  case End::halved:
    return "halved";
  case End::broken:
    break;
  }
  return "broken";
}

}  // namespace graze::reference
