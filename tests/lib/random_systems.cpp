// SPDX-License-Identifier: GPL-3.0-or-later
// Random systems of 1 to 6 states with two modes and jumps, written as text, against one slow reference that shares no code
// with the library. The reference evaluates the same expressions by recursion in long double. It uses classical Runge-Kutta
// steps of 1/500, bisection for events, and central differences for derivatives.
#include "support/checks.hpp"
#include "support/system_texts.hpp"

#include <memory>
#include <random>

using namespace graze;
using namespace graze::support;

namespace {

using Real = long double;
using Numbers = std::vector<Real>;

/// A smooth function of states x, parameters p and time: as text, and as a recursive function.
struct Term {
  std::string text;
  std::function<Real(Real t, const Numbers& x, const Numbers& p)> value;
};

/// Terms of moderate size for any state.
class Terms {
 public:
  Terms(std::mt19937& engine, std::size_t states, std::size_t parameters)
      : engine_(engine), states_(states), parameters_(parameters) {}

  double number(double from, double to) {  // with few digits, so that the text holds all of them
    return std::round(std::uniform_real_distribution<double>(from, to)(engine_) * 1000.0) / 1000.0;
  }
  static Term constant(double c) {
    return {fmt::format("({})", c), [c](Real, const Numbers&, const Numbers&) { return Real(c); }};
  }
  static Term state(std::size_t i) {
    return {fmt::format("x{}", i + 1), [i](Real, const Numbers& x, const Numbers&) { return x[i]; }};
  }
  static Term parameter(std::size_t i) {
    return {fmt::format("p{}", i + 1), [i](Real, const Numbers&, const Numbers& p) { return p[i]; }};
  }
  static Term sum(const Term& a, const Term& b) {
    return {fmt::format("({} + {})", a.text, b.text),
            [=](Real t, const Numbers& x, const Numbers& p) { return a.value(t, x, p) + b.value(t, x, p); }};
  }
  static Term product(const Term& a, const Term& b) {
    return {fmt::format("{}*{}", a.text, b.text),
            [=](Real t, const Numbers& x, const Numbers& p) { return a.value(t, x, p) * b.value(t, x, p); }};
  }
  /// f(a) with a function of the language.
  static Term of(const std::string& pattern, Real (*f)(Real), const Term& a) {
    std::string text = pattern;
    text.replace(text.find('#'), 1, a.text);
    return {text, [=](Real t, const Numbers& x, const Numbers& p) { return f(a.value(t, x, p)); }};
  }

  /// A function with the period of the forcing.
  static Term clock() {
    return {"cos(p1*t)", [](Real t, const Numbers&, const Numbers& p) { return std::cos(p[0] * t); }};
  }

  /// A term between -1 and 1.
  Term bounded(int depth) {
    const Term inner = depth == 0 ? leaf() : sum(product(constant(number(-1.5, 1.5)), bounded(depth - 1)), leaf());
    switch (engine_() % 7) {
    case 0:
      return of(
          "sin(#)", [](Real a) { return std::sin(a); }, inner);
    case 1:
      return of(
          "cos(#)", [](Real a) { return std::cos(a); }, inner);
    case 2:
      return of(
          "tanh(#)", [](Real a) { return std::tanh(a); }, inner);
    case 3:
      return of(
          "exp(-(#)^2)", [](Real a) { return std::exp(-a * a); }, inner);
    case 4:
      return of(
          "(2/pi*atan(#))", [](Real a) { return 2 / std::acos(Real(-1)) * std::atan(a); }, inner);
    case 5:
      return of(
          "1/sqrt(1 + (#)^2)", [](Real a) { return 1 / std::sqrt(1 + a * a); }, inner);
    default:
      return depth == 0 ? of(
                              "sin(#)", [](Real a) { return std::sin(a); }, inner)
                        : product(bounded(depth - 1), bounded(depth - 1));
    }
  }

 private:
  Term leaf() {
    switch (engine_() % 6) {
    case 0:
      return parameter(engine_() % parameters_);
    case 1:
      return clock();
    default:
      return state(engine_() % states_);
    }
  }

  std::mt19937& engine_;
  std::size_t states_, parameters_;
};

struct Jump {
  Term guard;
  std::vector<Term> reset;
  std::size_t from = 0, to = 0;
};

struct RandomSystem {
  std::size_t states = 0;
  std::vector<double> parameters;
  std::vector<std::vector<Term>> fields;  ///< by mode
  std::vector<Jump> jumps;
  std::vector<double> start;

  std::string text_of_mode(std::size_t mode) const {
    std::string text;
    for (std::size_t i = 0; i < states; ++i) text += fmt::format("x{}' = {}\n", i + 1, fields[mode][i].text);
    return text;
  }
};

/// x_i' = -c x_i + bounded terms. Four jumps: from each mode one into the other mode and one within it. Each jump moves the
/// state back behind its guard by a finite length.
RandomSystem draw(std::size_t states, unsigned seed) {
  std::mt19937 engine(seed);
  RandomSystem out;
  out.states = states;
  Terms terms(engine, states, 3);
  out.parameters = {terms.number(0.7, 2.0), terms.number(0.3, 1.2), terms.number(-0.8, 0.8)};
  for (std::size_t mode = 0; mode < 2; ++mode) {
    out.fields.emplace_back();
    for (std::size_t i = 0; i < states; ++i)
      out.fields[mode].push_back(Terms::sum(Terms::product(Terms::constant(terms.number(-0.9, -0.1)), Terms::state(i)),
                                            Terms::sum(Terms::product(Terms::constant(terms.number(0.8, 2.2)), terms.bounded(1)),
                                                       Terms::product(Terms::parameter(1), terms.bounded(2)))));
  }
  for (std::size_t k = 0; k < 4; ++k) {
    Jump jump;
    jump.from = k % 2;
    jump.to = k < 2 ? 1 - jump.from : jump.from;
    // s x_i + (bounded function of the other states and time)/4 - level; with one state, of time alone.
    const std::size_t i = engine() % states;
    const double sign = engine() % 2 ? 1.0 : -1.0, level = terms.number(0.15, 0.8);
    const Term along = Terms::product(Terms::constant(sign), Terms::state(i));
    const Term other = states == 1 ? Terms::clock() : Terms::sum(Terms::state((i + 1) % states), Terms::clock());
    const Term bend = Terms::of(
        "sin(#)", [](Real a) { return std::sin(a); }, other);
    jump.guard = Terms::sum(Terms::sum(along, Terms::product(Terms::constant(0.25), bend)), Terms::constant(-level));
    // The coordinate of the guard moves back. The other coordinates change smoothly, except the one in the curvature of the
    // guard.
    for (std::size_t q = 0; q < states; ++q) {
      Term to = Terms::state(q);
      if (q == i)
        to = Terms::sum(
            Terms::product(Terms::constant(terms.number(0.3, 0.9)), to),
            Terms::sum(Terms::constant(-sign * terms.number(0.3, 0.5)), Terms::product(Terms::constant(0.05), terms.bounded(1))));
      else if (q != (i + 1) % states)
        to = Terms::sum(Terms::product(Terms::constant(terms.number(0.6, 1.1)), to),
                        Terms::product(Terms::constant(0.2), terms.bounded(1)));
      jump.reset.push_back(to);
    }
    out.jumps.push_back(std::move(jump));
  }
  for (std::size_t i = 0; i < states; ++i) out.start.push_back(terms.number(-0.3, 0.1));
  return out;
}

equations::TextSystem read(const RandomSystem& random) {
  SystemWriter writer;
  writer.system.name = "random";
  std::vector<std::string> names;
  for (std::size_t i = 0; i < random.states; ++i) names.push_back(fmt::format("x{}", i + 1));
  writer.states(names).forcing("p1");
  for (std::size_t i = 0; i < random.parameters.size(); ++i)
    writer.parameter(fmt::format("p{}", i + 1), fmt::format("{}", random.parameters[i]));
  for (const std::size_t mode : {0, 1}) writer.mode(mode == 0 ? "one" : "two", random.text_of_mode(mode));
  for (std::size_t k = 0; k < random.jumps.size(); ++k) {
    const Jump& jump = random.jumps[k];
    std::string reset;
    for (std::size_t i = 0; i < random.states; ++i) reset += fmt::format("x{} = {}\n", i + 1, jump.reset[i].text);
    writer.event(
        {fmt::format("jump{}", k + 1), "", jump.guard.text, reset, jump.from == 0 ? "one" : "two", jump.to == 0 ? "one" : "two"});
  }
  return equations::make_system(writer.system);
}

/// The slow reference.
struct Run {
  Numbers x;
  std::vector<std::size_t> jumps;
  std::vector<Real> times;
  /// Smallest rate of a guard at its jump; smallest distance of a maximum of a guard from zero.
  Real slowest = 1.0L, nearest = 1.0L;
};

Numbers step(const RandomSystem& system, std::size_t mode, Real t, const Numbers& x, const Numbers& p, Real h) {
  const auto field = [&](Real at, const Numbers& state) {
    Numbers f;
    for (const Term& term : system.fields[mode]) f.push_back(term.value(at, state, p));
    return f;
  };
  const auto moved = [&](const Numbers& by, Real length) {
    Numbers y = x;
    for (std::size_t i = 0; i < y.size(); ++i) y[i] += length * by[i];
    return y;
  };
  const Numbers a = field(t, x), b = field(t + h / 2, moved(a, h / 2)), c = field(t + h / 2, moved(b, h / 2)),
                d = field(t + h, moved(c, h));
  Numbers y = x;
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
  return y;
}

Run run(const RandomSystem& system, Numbers x, const Numbers& p, Real end) {
  constexpr Real h = 1.0L / 500;
  Run out;
  std::size_t mode = 0;
  std::vector<Real> before(system.jumps.size(), -1.0L), earlier = before;
  for (Real t = 0; t < end;) {
    Real length = std::min(h, end - t);
    Numbers next = step(system, mode, t, x, p, length);
    std::size_t fired = system.jumps.size();
    // The first guard that rises through zero within the step.
    for (std::size_t k = 0; k < system.jumps.size(); ++k) {
      const Jump& jump = system.jumps[k];
      if (jump.from != mode || !(jump.guard.value(t + length, next, p) > 0)) continue;
      Real low = 0, high = length;
      for (int i = 0; i < 70; ++i) {
        const Real middle = (low + high) / 2;
        (jump.guard.value(t + middle, step(system, mode, t, x, p, middle), p) > 0 ? high : low) = middle;
      }
      length = high;
      next = step(system, mode, t, x, p, length);
      fired = k;
    }
    for (std::size_t k = 0; k < system.jumps.size(); ++k) {
      if (system.jumps[k].from != mode) continue;
      const Real now = system.jumps[k].guard.value(t + length, next, p);
      if (fired == system.jumps.size() && before[k] > now && before[k] >= earlier[k])
        out.nearest = std::min(out.nearest, -before[k]);
      if (k == fired) {
        constexpr Real back = 1e-6L;
        out.slowest = std::min(
            out.slowest, -system.jumps[k].guard.value(t + length - back, step(system, mode, t, x, p, length - back), p) / back);
      }
      earlier[k] = std::exchange(before[k], now);
    }
    t += length;
    x = next;
    if (fired == system.jumps.size()) continue;
    const Jump& jump = system.jumps[fired];
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = jump.reset[i].value(t, next, p);
    mode = jump.to;
    out.jumps.push_back(fired);
    out.times.push_back(t);
    for (std::size_t k = 0; k < system.jumps.size(); ++k)
      if (system.jumps[k].from == mode && system.jumps[k].guard.value(t, x, p) >= 0) out.nearest = 0;  // another jump immediately
    if (out.nearest == 0) break;
    std::fill(before.begin(), before.end(), -1.0L);
    earlier = before;
  }
  out.x = x;
  return out;
}

Numbers numbers(const std::vector<double>& values) { return {values.begin(), values.end()}; }

}  // namespace

TEST_CASE("random systems of 1 to 6 states agree with a slow reference in motion and derivatives") {
  constexpr Real end = 3.0L;
  int compared = 0, events = 0, switched = 0;
  for (unsigned seed = 1; seed <= 48; ++seed) {
    const std::size_t n = 1 + seed % 6;
    const RandomSystem random = draw(n, seed);
    const Numbers x0 = numbers(random.start), p0 = numbers(random.parameters);
    const equations::TextSystem text = read(random);
    const HybridSystem& system = text.system;
    std::string guards;
    for (const Jump& jump : random.jumps) guards += fmt::format("{} -> {}: {}\n", jump.from, jump.to, jump.guard.text);
    INFO("seed " << seed << ":\n" << random.text_of_mode(0) << random.text_of_mode(1) << guards);
    const Vector start = Eigen::Map<const Vector>(random.start.data(), static_cast<Eigen::Index>(n));
    const Vector p = default_parameters(system.parameters);
    if (!mode_at(system, 0.0, start, p)) continue;
    const Run reference = run(random, x0, p0, end);
    // Distance from touching and from weak crossings, where a difference quotient would follow another event sequence.
    constexpr Real clear = 1e-3L;
    if (reference.slowest < clear || reference.nearest < clear) continue;
    for (const FlowKind kind : {FlowKind::automatic, FlowKind::general}) {
      Propagator propagator(system, p, {0, 1, 2}, {.kind = kind});
      Transition got;

      carry(propagator, 0.0, static_cast<double>(end), start,
            {.sensitivity = Sensitivity::state_and_parameters, .keep_events = true}, got);
      REQUIRE(got.termination == Termination::time);
      REQUIRE(got.event_sequence.size() == reference.jumps.size());
      for (std::size_t k = 0; k < got.events.size(); ++k) {
        CHECK(system.events[got.event_sequence[k]].name == fmt::format("jump{}", reference.jumps[k] + 1));
        CHECK(got.events[k].t == Approx(static_cast<double>(reference.times[k])).margin(1e-10));
        switched += random.jumps[reference.jumps[k]].from != random.jumps[reference.jumps[k]].to ? 1 : 0;
      }
      events += static_cast<int>(got.events.size());
      const double scale = 1.0 + got.Phi.cwiseAbs().maxCoeff() + got.Psi.cwiseAbs().maxCoeff();
      for (std::size_t i = 0; i < n; ++i)
        CHECK(got.x1[static_cast<Eigen::Index>(i)] == Approx(static_cast<double>(reference.x[i])).margin(1e-11 * scale));
      // Columns of Phi and Psi by central differences of the reference.
      constexpr Real h = 1e-5L;
      for (std::size_t c = 0; c < n + 3; ++c) {
        Run ends[2];
        for (const int side : {0, 1}) {
          Numbers x = x0, q = p0;
          (c < n ? x[c] : q[c - n]) += side == 0 ? h : -h;
          ends[side] = run(random, x, q, end);
          REQUIRE(ends[side].jumps == reference.jumps);
        }
        for (std::size_t i = 0; i < n; ++i) {
          const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(c < n ? c : c - n);
          const double wanted = static_cast<double>((ends[0].x[i] - ends[1].x[i]) / (2 * h));
          CHECK((c < n ? got.Phi : got.Psi)(row, column) == Approx(wanted).margin(1e-7 * scale * scale));
        }
        if (kind == FlowKind::general) break;  // the derivatives of the two flows are compared below
      }
      if (std::isfinite(got.log_det) && std::isfinite(got.liouville)) CHECK(got.log_det == Approx(got.liouville).margin(1e-9));
    }
    ++compared;
  }
  CHECK(compared >= 20);
  CHECK(events >= 100);
  CHECK(switched >= 15);
}
