// SPDX-License-Identifier: GPL-3.0-or-later
#include "cases.hpp"
#include "events.hpp"
#include "one_impact.hpp"

#include <cstdio>

namespace graze::reference {

namespace {

/// splitmix64
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t index) : state_(seed * 0x9e3779b97f4a7c15u ^ (index + 1) * 0xd1342543de82ef95u) {}
  double between(double low, double high) { return low + (high - low) * static_cast<double>(next() >> 11) * 0x1p-53; }
  std::size_t below(std::size_t end) { return static_cast<std::size_t>(next() % end); }

 private:
  std::uint64_t next() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

/// Short decimals make short commands.
double rounded(double value, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return std::strtod(text, nullptr);
}

std::string exact(double value) {
  char text[40];
  for (const int digits : {4, 15, 16, 17}) {
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    if (std::strtod(text, nullptr) == value) break;
  }
  return text;
}

/// Range in which each parameter is drawn and followed.
Range range_of(std::size_t name) {
  switch (name) {
  case B:
    return {0.005, 0.35};
  case XI:
    return {0.2, 4.0};
  case ETA:
    return {0.35, 4.0};
  case R:
    return {-1.5, 2.5};
  default:
    return {0.0, 1.0};
  }
}

/// Ranges of the additional parameters of other models. k_r stays away from 0, so that motions do not chatter.
Range range_of(Model model, std::size_t name) {
  if (model == Model::barrier || name == B || name == XI || name == ETA) return range_of(name);
  if (name == K_R || (name == K_L && !is_chain(model))) return {0.3, 1.0};
  if (model == Model::chain_second || model == Model::chain_first || model == Model::chain_between) {
    if (name == MASS) return {0.2, 2.0};
    if (name == K) return {0.2, 3.0};
    if (name == C) return {0.0, 0.2};
    return {-0.5, 2.5};
  }
  return {0.1, 2.5};
}

double drawn(Random& random, std::size_t name) {
  const Range range = range_of(name);
  switch (name) {
  case B:
    return rounded(range.low * std::pow(range.high / range.low, random.between(0.0, 1.0)), 4);
  case XI:
    return random.below(3) == 0 ? rounded(random.between(range.low, range.high), 3) : 1.0;
  case K_R: {
    const double edge = random.between(0.0, 1.0);
    return edge < 0.04 ? 0.0 : edge > 0.9 ? 1.0 : rounded(random.between(range.low, range.high), 3);
  }
  default:
    return rounded(random.between(range.low, range.high), 3);
  }
}

std::string settings(const Frame& frame) {
  std::string out;
  const auto names = parameter_names(frame.model);
  for (std::size_t i = 0; i < names.size(); ++i) out += " --set " + std::string(names[i]) + "=" + exact(frame.base[i]);
  return out;
}

// Closer to a grazing than this, a state at phase 0 in double does not determine the start.
constexpr double least_speed = 1e-3, least_gap = 1e-5, largest_multiplier = 1e4;

bool weak(const Frame& frame, const Values<double>& y) {
  for (std::size_t k = 1; k < frame.size(); k += frame.block())
    if (y[k] < least_speed) return true;
  return gap(frame, y) > -least_gap;
}

/// A case of a model with more than one barrier or mass.
Case random_other(Random& random, std::optional<std::size_t> name, Model model) {
  constexpr int most_settled = 6;
  for (;;) {
    Case out;
    constexpr std::array<std::size_t, 10> often = {ETA, ETA, ETA, ETA, R, R, XI, XI, K_R, B};
    const std::size_t pick = often[random.below(often.size())];
    out.frame.model = model;
    out.frame.name = name.value_or(pick);
    for (std::size_t i = 0; i < parameter_names(model).size(); ++i) {
      const Range range = range_of(model, i);
      out.frame.base[i] = i <= XI ? drawn(random, i) : rounded(random.between(range.low, range.high), 3);
    }
    const Range range = range_of(model, out.frame.name);
    const double value = out.frame.base[out.frame.name];
    out.to = rounded(random.between(range.low, range.high), 3);
    const std::size_t which = random.below(2), place = random.below(2);
    const int periods = 1 + static_cast<int>(random.below(3));
    if (std::fabs(out.to - value) < 0.05 * (range.high - range.low)) continue;
    if (place == 0) {
      const std::optional<Orbit> orbit = settled(out.frame, value, 4, most_settled);
      if (!orbit) continue;
      out.frame = orbit->frame;
      out.start = orbit->y;
    } else {
      out.frame.half = model == Model::equal_stops;
      out.frame.periods = out.frame.half ? 1 + 2 * static_cast<int>(random.below(2)) : periods;
      const SingleImpact<double> form = single_impact(out.frame, value);
      const Values<double> speeds = form.speeds();
      if (speeds.empty()) continue;
      out.start = form.block(speeds[which % speeds.size()]);
      out.start.push_back(value);
    }
    if (!admissible(out.frame, out.start) || weak(out.frame, out.start)) continue;
    if (std::fabs(power_sums(monodromy(out.frame, out.start))[0]) > largest_multiplier) continue;
    return out;
  }
}

}  // namespace

Case random_case(std::uint64_t seed, std::uint64_t index, std::optional<std::size_t> name, Model model) {
  // Of ten cases, one each starts near a fold, near a doubling and near a grazing. Two start on an attractor with at most
  // `most_settled` impacts.
  constexpr std::size_t near_places = 3, first_settled = 8;
  constexpr int most_settled = 6;
  Random random(seed, index);
  if (model != Model::barrier) return random_other(random, name, model);
  const std::size_t parameters = parameter_names(model).size();
  for (;;) {
    Case out;
    constexpr std::array<std::size_t, 10> often = {ETA, ETA, ETA, ETA, R, R, XI, XI, K_R, B};
    const std::size_t pick = often[random.below(often.size())];
    out.frame.name = name.value_or(pick);
    out.frame.periods = 1 + static_cast<int>(random.below(4));
    for (std::size_t i = 0; i < parameters; ++i) out.frame.base[i] = drawn(random, i);
    const Range range = range_of(out.frame.name);
    out.to = rounded(random.between(range.low, range.high), 3);
    const std::size_t which = random.below(2);
    if (std::fabs(out.to - out.frame.base[out.frame.name]) < 0.05 * (range.high - range.low)) continue;
    const std::size_t place = random.below(10);
    const double closeness = std::pow(10.0, -random.between(1.5, 5.0));
    if (place >= first_settled) {
      const std::optional<Orbit> orbit = settled(out.frame, out.frame.base[out.frame.name], 4, most_settled);
      if (!orbit) continue;
      out.frame = orbit->frame;
      out.start = orbit->y;
      if (weak(out.frame, out.start)) continue;
      return out;
    }
    OneImpactForm<double> form = one_impact(out.frame.base, out.frame.periods);
    Values<double> speeds = form.speeds();
    if (place < near_places) {
      // Near a point: the forcing amplitude is chosen so that the orbit has the impact speed of that point.
      const double at = place == 0 ? form.fold_speed() : form.flip_speed();
      const double speed = place == 2 ? 100.0 * closeness : at * (1.0 + (which == 0 ? closeness : -closeness));
      const double xi = form.amplitude_of(speed) / impactless_amplitude(form.q) * form.q[XI];
      if (!(speed > 0.0 && xi > 0.1 && xi < 10.0)) continue;
      out.frame.base[XI] = xi;
      form = one_impact(out.frame.base, out.frame.periods);
      speeds = {speed};
      if (out.frame.name == XI && std::fabs(out.to - xi) < 0.05 * (range.high - range.low)) continue;
    }
    if (speeds.empty()) continue;
    const OneImpact<double> orbit = form.orbit(speeds[which % speeds.size()]);
    out.start = {orbit.phase, orbit.speed, out.frame.base[out.frame.name]};
    if (!admissible(out.frame, out.start) || weak(out.frame, out.start)) continue;
    if (std::fabs(form.trace(orbit.speed)) > largest_multiplier) continue;
    return out;
  }
}

std::string arguments(const Case& one) {
  std::string out = settings(one.frame);
  const State state = states_of(one.frame, one.start).front();
  out += " --param " + std::string(parameter_names(one.frame.model)[one.frame.name]) + " --from " + exact(one.start.back()) +
         " --to " + exact(one.to) + " --period " + std::to_string(one.frame.periods) + " --settle 0 --start ";
  for (std::size_t k = 0; k < state.size(); ++k) out += (k == 0 ? "" : ",") + exact(state[k]);
  return out;
}

SkeletonCase random_skeleton(std::uint64_t seed, std::uint64_t index, std::optional<std::size_t> name) {
  // Fraction of the parameter's whole range: a skeleton of more takes long.
  constexpr double least_part = 0.05, largest_part = 0.25;
  Random random(seed ^ 0x5ca1ab1eu, index);
  for (;;) {
    SkeletonCase out;
    constexpr std::array<std::size_t, 6> often = {ETA, ETA, ETA, R, XI, K_R};
    const std::size_t pick = often[random.below(often.size())];
    out.frame.name = name.value_or(pick);
    for (std::size_t i = 0; i < parameter_names(out.frame.model).size(); ++i) out.frame.base[i] = drawn(random, i);
    const Range all = range_of(out.frame.name);
    const double width = (all.high - all.low) * random.between(least_part, largest_part);
    out.range.low = rounded(random.between(all.low, all.high - width), 3);
    out.range.high = rounded(out.range.low + width, 3);
    if (!one_impact_families(out.frame, out.range, out.most_periods).empty()) return out;
  }
}

std::string arguments(const SkeletonCase& one) {
  return " --skeleton --all" + settings(one.frame) + " --param " + std::string(parameter_names(one.frame.model)[one.frame.name]) +
         " --from " + exact(one.range.low) + " --to " + exact(one.range.high) + " --max-period " +
         std::to_string(one.most_periods);
}

std::vector<Family> one_impact_families(const Frame& frame, const Range& range, int most_periods) {
  // A family shorter than a hundredth of the range may lie between two of the values, and is not required.
  constexpr int values = 101;
  std::vector<Family> out;
  for (int n = 1; n <= most_periods; ++n) {
    Frame own = frame;
    own.periods = n;
    own.stops = {0};
    for (int k = 0; k < values; ++k) {
      const double p = range.low + (range.high - range.low) * (k + 0.5) / values;
      const OneImpactForm<double> form = one_impact(own.at(p), n);
      for (const double speed : form.speeds()) {
        const OneImpact<double> orbit = form.orbit(speed);
        const Values<double> y = {orbit.phase, orbit.speed, p};
        if (!admissible(own, y)) continue;
        const std::vector<State> states = states_of(own, y);
        const bool known = std::any_of(out.begin(), out.end(), [&](const Family& family) {
          return family.frame.periods == n && !places(family, p, states, 1e-7 * (1.0 + speed)).empty();
        });
        if (!known) out.push_back(follow_both_ways(own, y, range));
      }
    }
  }
  return out;
}

}  // namespace graze::reference
