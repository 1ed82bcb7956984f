// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/shooting.hpp>
#include <graze/floquet/verify/hard_limit.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace graze {

namespace {

using namespace oscillator_parameter;
constexpr std::size_t k_H = law, b_H = law + 1;  // of Hertz
constexpr std::size_t limit_b_H = law;
constexpr double not_known = std::numeric_limits<double>::quiet_NaN();
constexpr double epsilon_power = -0.4;
constexpr std::size_t least_steps = 5;  // four decades: an order, its change, and two columns of the extrapolation

/// (ln(1 + w) - w) / -w^2 = 1/2 - w/3 + w^2/4 - ..., without cancellation; w > -1.
double loss_function(double w) {
  if (std::abs(w) > 0.1) return (w - std::log1p(w)) / (w * w);
  double sum = 0.0, power = 1.0;
  for (int k = 2; k < 20; ++k, power *= -w) sum += power / k;
  return sum;
}

/// Replaces Newton's reset by that of the limit.
void set_limit_reset(Event& impact) {
  impact.reset = {};
  impact.reset.map = [](double, const Vector& x, const Vector& p, Vector& out) {
    out[0] = p[r];
    out[1] = -limit_restitution(p[limit_b_H] * std::max(0.0, x[1])) * x[1];
  };
  impact.reset.dx = [](double, const Vector& x, const Vector& p, Matrix& J) {
    J << 0.0, 0.0, 0.0, -limit_restitution_slope(p[limit_b_H] * std::max(0.0, x[1]));
  };
  impact.reset.dp = [](double, const Vector& x, const Vector& p, Matrix& J) {
    J.setZero();
    J(0, r) = 1.0;
    // u = e w with w = b_H v: v+ = -u / b_H.
    const double w = p[limit_b_H] * std::max(0.0, x[1]), v = x[1];
    const double e = limit_restitution(w), slope = limit_restitution_slope(w);
    J(1, limit_b_H) = w > 0.0 ? -v * (slope - e) / p[limit_b_H] : 2.0 / 3.0 * v * v;
  };
  // Restitution tends to 1 as the speed tends to 0: no sequence of impacts ever completes.
  impact.accumulation.reset();
  impact.log_volume_change = {};
}

/// Orbits of one kind, computed one after the other.
struct Family {
  int period = 0;
  std::optional<int> impacts = {};

  std::optional<PeriodicOrbit> at(const HybridSystem& system, const Vector& p, const std::vector<Vector>& guess) const {
    try {
      PeriodicOrbit orbit = shoot(system, p, guess, period);
      const bool same = orbit.converged() && orbit.period == period && impacts.value_or(orbit.impacts) == orbit.impacts &&
                        orbit.admissible == Admissibility::admissible && orbit.multipliers.valid;
      if (same) return orbit;
    } catch (const std::invalid_argument&) {  // the guess is inside the barrier
    }
    return std::nullopt;
  }
};

/// States at epsilon, extrapolated linearly from those at two other values.
std::vector<Vector> predicted(const PeriodicOrbit& before, double eps_before, const PeriodicOrbit& last, double eps_last,
                              double eps) {
  std::vector<Vector> guess = last.states;
  if (eps_before == eps_last) return guess;
  const double share = (eps - eps_last) / (eps_last - eps_before);
  for (std::size_t j = 0; j < guess.size(); ++j) guess[j] += share * (last.states[j] - before.states[j]);
  return guess;
}

double epsilon_of(double stiffness) { return std::pow(stiffness, epsilon_power); }

double multiplier_difference(const FloquetMultipliers& a, const FloquetMultipliers& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.values.size(); ++i) largest = std::max(largest, std::abs(a.values[i] - b.values[i]));
  return largest / (1.0 + std::abs(b.values.front()));
}

double relative(const Vector& difference, const Vector& x) {
  return difference.lpNorm<Eigen::Infinity>() / (1.0 + x.lpNorm<Eigen::Infinity>());
}

/// Trace and determinant of M: they stay smooth where multipliers meet.
Vector invariants(const PeriodicOrbit& orbit) {
  const Matrix M = orbit.monodromy.product();
  return Vector{{M.trace(), M.determinant()}};
}

class Comparison {
 public:
  Comparison(const OscillatorKind& kind, const Vector& p, const HardLimitOptions& options)
      : hertz_(make_oscillator(kind, contact_law("hertz"))), limit_(make_hard_limit(kind)), kind_(kind), p_(p), limit_p_(law + 1),
        options_(options) {
    limit_p_.head(law) = p.head(law);
    limit_p_[limit_b_H] = p[b_H];
  }

  HardLimit run(const PeriodicOrbit& orbit) {
    family_ = {orbit.period};
    out_.stop = follow(orbit);
    if (out_.stop != HardLimitStop::done) return std::move(out_);
    check_orbit();
    if (p_[b_H] > 0.0) add_restitution();
    return std::move(out_);
  }

 private:
  bool cancelled() const { return options_.cancelled && options_.cancelled(); }
  Vector stiff(double stiffness) const {
    Vector p = p_;
    p[k_H] = stiffness;
    return p;
  }

  /// Follows the orbit from the problem's own stiffness up to the stiffest, to the limit, and down by decades.
  HardLimitStop follow(const PeriodicOrbit& given) {
    const bool hard = given.parameters.size() == limit_p_.size();
    std::vector<Vector> guess = given.states;
    PeriodicOrbit last = given, before = given;
    double stiffness = p_[k_H], eps_last = epsilon_of(stiffness), eps_before = eps_last;
    for (double factor = 2.0; !hard && stiffness != options_.stiffest;) {
      if (cancelled()) return HardLimitStop::interrupted;
      const double next = stiffness < options_.stiffest ? std::min(options_.stiffest, stiffness * factor)
                                                        : std::max(options_.stiffest, stiffness / factor);
      const double eps = epsilon_of(next);
      auto orbit = family_.at(hertz_, stiff(next), predicted(before, eps_before, last, eps_last, eps));
      if (!orbit) {
        factor = std::sqrt(factor);
        if (factor < 1.005) return HardLimitStop::lost_stiff;
        continue;
      }
      before = std::exchange(last, std::move(*orbit));
      eps_before = std::exchange(eps_last, eps);
      stiffness = next;
      factor = std::min(10.0, factor * factor);
    }
    // On the way up a soft contact may graze, which changes z while the orbit continues; from here on z is fixed.
    family_.impacts = last.impacts;
    if (!hard) guess = predicted(before, eps_before, last, eps_last, 0.0);
    auto limit = family_.at(limit_, limit_p_, guess);
    if (!limit) return HardLimitStop::lost_limit;
    out_.limit = std::move(*limit);
    before = last = out_.limit;
    eps_before = eps_last = 0.0;
    for (double step = options_.stiffest; step > options_.softest / 2.0; step /= 10.0) {
      if (cancelled()) return HardLimitStop::interrupted;
      const double eps = epsilon_of(step);
      auto orbit = family_.at(hertz_, stiff(step), predicted(before, eps_before, last, eps_last, eps));
      if (!orbit) break;
      before = std::exchange(last, *orbit);
      eps_before = std::exchange(eps_last, eps);
      out_.steps.push_back({step, std::move(*orbit), 0.0, 0.0, not_known});
    }
    std::reverse(out_.steps.begin(), out_.steps.end());
    return out_.steps.size() < least_steps ? HardLimitStop::lost_soft : HardLimitStop::done;
  }

  void check_orbit() {
    const PeriodicOrbit& limit = out_.limit;
    std::vector<Vector> states, matrices;
    const StiffnessStep* softer = nullptr;
    for (StiffnessStep& step : out_.steps) {
      step.state_difference = relative(step.orbit.state - limit.state, limit.state);
      step.multiplier_difference = multiplier_difference(step.orbit.multipliers, limit.multipliers);
      if (softer != nullptr) step.order = std::log10(softer->state_difference / step.state_difference);
      softer = &step;
      states.push_back(step.orbit.state);
      matrices.push_back(invariants(step.orbit));
    }
    if (limit.impacts > 0) {  // otherwise nothing converges
      const double last = out_.steps.back().order, before = out_.steps[out_.steps.size() - 2].order;
      // The order's own error falls like epsilon, by 2.5 a decade: the remaining error is less than its last change (2/3 of
      // it). The floor is for cases where two terms of the expansion cancel in that change; every orbit of order 2/5 meets it.
      const double left = std::max(order_bound, std::abs(last - before));
      out_.checks.push_back({"hard limit: order", std::abs(last + epsilon_power), left});
    }
    compare_extrapolated("hard limit: state", states, limit.state);
    compare_extrapolated("hard limit: multipliers", matrices, invariants(limit));
    compare_newton();
  }

  void compare_extrapolated(const std::string& name, const std::vector<Vector>& values, const Vector& limit) {
    const Extrapolated there = extrapolate(values, std::pow(10.0, epsilon_power));
    const double scale = 1.0 + limit.lpNorm<Eigen::Infinity>();
    out_.checks.push_back({name, relative(there.value - limit, limit), extrapolation_safety * there.error / scale + rounding()});
  }

  /// Compares with the same orbit under Newton's law, with k_r that of its impacts.
  void compare_newton() {
    out_.newton_restitution = p_[b_H] == 0.0 ? 1.0 : not_known;
    std::vector<double> all;
    for (const EventRecord& event : out_.limit.events)
      if (event.kind == EventKind::impact) all.push_back(event.exit_speed / event.normal_speed);
    if (!all.empty()) {
      const auto [least, most] = std::minmax_element(all.begin(), all.end());
      out_.newton_restitution = *most - *least < 1e-12 ? std::min(1.0, all.front()) : not_known;
    }
    OrbitCheck check{"hard limit: Newton's law", -1.0, rounding(),
                     all.empty() ? "there is no impact" : "the impacts differ in restitution"};
    if (std::isfinite(out_.newton_restitution)) {
      Vector p = limit_p_;
      p[law] = out_.newton_restitution;
      const auto orbit = family_.at(make_oscillator(kind_, contact_law("newton")), p, out_.limit.states);
      check.reason.clear();
      check.disagreement = orbit ? relative(orbit->state - out_.limit.state, out_.limit.state) : not_known;
    }
    out_.checks.push_back(check);
  }

  void add_restitution();

  /// Newton's error is about 1e-13, divided by the distance of the multipliers from 1. Extrapolation weights (up to 1 + 2 / 3 +
  /// ... a column) and derivatives amplify it by about 1000.
  double rounding() const {
    double nearest = 1.0;
    for (const auto& mu : out_.limit.multipliers.values) nearest = std::min(nearest, std::abs(1.0 - mu));
    return 1e-10 / nearest;
  }

  static constexpr double order_bound = 1e-3;          // see check_orbit
  static constexpr double extrapolation_safety = 4.0;  // the error is an estimate, not a bound

  HybridSystem hertz_, limit_;
  OscillatorKind kind_;
  Vector p_, limit_p_;
  HardLimitOptions options_;
  Family family_;
  HardLimit out_;
};

void Comparison::add_restitution() {
  double fastest = 0.0;
  const double T = 2.0 * std::numbers::pi / p_[eta];
  for (const EventRecord& event : out_.limit.events) {
    if (event.kind != EventKind::impact) continue;
    if (fastest == 0.0) out_.entry_time = std::fmod(event.t, T);
    fastest = std::max(fastest, event.normal_speed);
  }
  const double most = options_.largest_speed > 0.0 ? options_.largest_speed : std::max(2.0, 2.0 * fastest);
  OrbitCheck worst{"hard limit: restitution", -1.0, 1e-10, "too few contacts are stiff enough to throw the mass back"};
  for (int i = 1; i <= options_.speeds; ++i) {
    RestitutionPoint point;
    point.speed = most * i / options_.speeds;
    point.closed_form = limit_restitution(p_[b_H] * point.speed);
    point.computed = contact_restitution(hertz_, p_, out_.entry_time, point.speed);
    std::vector<Vector> values;
    for (const StiffnessStep& step : out_.steps) {
      const double e = contact_restitution(hertz_, stiff(step.k_H), out_.entry_time, point.speed);
      if (std::isnan(e)) values.clear();  // too soft to throw the mass back: use only stiffer contacts
      if (!std::isnan(e)) values.push_back(Vector{{e}});
    }
    point.stiff = values.empty() ? not_known : values.back()[0];
    const bool enough = values.size() >= least_steps;
    const Extrapolated there = enough ? extrapolate(values, std::pow(10.0, epsilon_power)) : Extrapolated{{}, not_known};
    point.extrapolated = enough ? there.value[0] : not_known;
    point.error = there.error;
    if (enough) {
      const OrbitCheck here{worst.name, std::abs(point.extrapolated - point.closed_form),
                            extrapolation_safety * point.error + 1e-10};
      if (!worst.applicable() || !(here.ratio() <= worst.ratio())) worst = here;
    }
    out_.restitution.push_back(point);
  }
  out_.checks.push_back(worst);
}

}  // namespace

std::string_view hard_limit_stop_text(HardLimitStop reason) {
  switch (reason) {
  case HardLimitStop::failed:
    return "it was not run";
  case HardLimitStop::done:
    return "done";
  case HardLimitStop::lost_stiff:
    return "the orbit could not be followed to the stiffest contact";
  case HardLimitStop::lost_limit:
    return "there is no orbit with its number of impacts in the hard limit";
  case HardLimitStop::lost_soft:
    return "the orbit could not be followed down four decades from the stiffest contact";
  case HardLimitStop::interrupted:
    return "it was interrupted";
  }
  return "";
}

double limit_restitution(double w) {
  if (!(w >= 0.0) || !std::isfinite(w))
    throw std::invalid_argument(fmt::format("b_H times the speed of impact is {}; allowed is a finite number >= 0", w));
  if (w == 0.0) return 1.0;
  // Solves e^2 L(-e w) = L(w), L the loss function, by Newton in e from below: the left side is increasing and convex.
  const double target = loss_function(w);
  // Large w: u = e w tends to 1, and 1 - u is lost to cancellation. It satisfies 1 - u = exp(-(w - ln(1 + w)) - u).
  if (w > 20.0) {
    double u = 1.0;
    for (int i = 0; i < 4; ++i) u = 1.0 - std::exp(-target * w * w - u);
    return u / w;
  }
  double low = 0.0, high = std::min(1.0, 1.0 / w), e = std::min(1.0 / (1.0 + 2.0 / 3.0 * w), 0.999 * high);
  for (int i = 0; i < 200; ++i) {
    const double f = e * e * loss_function(-e * w) - target;
    (f > 0.0 ? high : low) = e;
    const double slope = e / (1.0 - e * w);  // of e^2 L(-e w): u / (1 - u) / w
    double next = e - f / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const bool done = std::abs(next - e) <= 2e-16 * e;
    e = next;
    if (done) break;
  }
  return e;
}

double limit_restitution_slope(double w) {
  const double e = limit_restitution(w), u = e * w;
  return w == 0.0 ? 1.0 : (1.0 - u) / (e * (1.0 + w));
}

HybridSystem make_hard_limit(const OscillatorKind& kind) {
  ContactLaw law_of_limit;
  law_of_limit.name = "hertz-limit";
  law_of_limit.formula = "x'+ = -e(b_H x'-) x'- at x = r; x <= r always";
  law_of_limit.hard = true;
  law_of_limit.parameters = {contact_law("hertz").parameters[b_H - law]};
  law_of_limit.stop = "newton";
  law_of_limit.values = {"1"};
  HybridSystem system = make_oscillator(kind, law_of_limit);
  set_limit_reset(system.events.front());
  return system;
}

double contact_restitution(const HybridSystem& system, const Vector& p, double t, double speed, const FlowOptions& options) {
  if (!(speed > 0.0)) throw std::invalid_argument(fmt::format("the speed of entry is {}; allowed is > 0", speed));
  const Trajectory run = simulate(system, p, t, Vector{{p[r], speed}}, {t + forcing_period(system, p), 1}, options);
  for (const EventRecord& event : run.events)
    if (event.kind == EventKind::leave) return event.normal_speed / speed;
  return not_known;
}

Extrapolated extrapolate(const std::vector<Vector>& values, double ratio) {
  if (values.empty()) throw std::invalid_argument("there is nothing to extrapolate");
  std::vector<Vector> row, above;
  double last_change = 0.0;
  for (const Vector& value : values) {
    row = {value};
    double power = ratio;
    for (const Vector& coarser : above) {
      const Vector finer = row.back();
      row.push_back(finer + (finer - coarser) * (power / (1.0 - power)));
      power *= ratio;
    }
    if (!above.empty()) last_change = (row.back() - above.back()).lpNorm<Eigen::Infinity>();
    above = row;
  }
  Extrapolated out{row.back(), 0.0};
  // Changes by the last column and by the last row.
  if (row.size() > 1) out.error = std::max((row.back() - row[row.size() - 2]).lpNorm<Eigen::Infinity>(), last_change);
  return out;
}

HardLimit hard_limit(const OscillatorKind& kind, const Vector& p, const PeriodicOrbit& orbit, const HardLimitOptions& options) {
  if (!(options.softest > 0.0) || !(options.stiffest >= 1e4 * options.softest * (1.0 - 1e-12)))
    throw std::invalid_argument(
        fmt::format("k_H goes from {} to {}; four decades at least are needed, from above 0", options.softest, options.stiffest));
  if (options.speeds < 1)
    throw std::invalid_argument(fmt::format("speeds is {}; allowed is a whole number >= 1", options.speeds));
  return Comparison(kind, p, options).run(orbit);
}

}  // namespace graze
