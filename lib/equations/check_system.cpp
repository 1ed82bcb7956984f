// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/check_system.hpp>

#include <graze/lib/equations/functions.hpp>
#include <graze/lib/equations/not_finite.hpp>
#include <graze/lib/system/guard_rounding.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace graze::equations {

namespace {

/// Number of states on a guard at which its reset is tested, including one from the start.
constexpr int reset_trials = 40;
/// Tolerance for the periodicity of the field, relative to its size: far above rounding, far below the effect of a wrong
/// period.
constexpr double period_tolerance = 1e-8;

class Checks {
 public:
  Checks(const HybridSystem& system, const Names& names, const Pieces& pieces)
      : system_(system), names_(names), text_(names.text), graph_(names.graph), pieces_(pieces),
        states_(static_cast<Eigen::Index>(system.states)) {}

  void run() const {
    check_values();
    check_period();
    check_resets();
  }

 private:
  void check_period() const {
    if (!is_forced(system_)) return;
    const double T = forcing_period(system_, names_.defaults);
    const Vector x = names_.start ? *names_.start : Vector::Constant(states_, 0.1);
    // Instants without a simple relation to the period.
    for (const double phase : {0.137, 0.618}) {
      for (std::size_t m = 0; m < pieces_.modes.size(); ++m) {
        const ModePiece& mode = pieces_.modes[m];
        const std::vector<double> before = values(graph_, mode.field, phase * T, x, names_.defaults);
        const std::vector<double> after = values(graph_, mode.field, (1.0 + phase) * T, x, names_.defaults);
        for (std::size_t i = 0; i < before.size(); ++i)
          if (std::abs(after[i] - before[i]) > period_tolerance * (1.0 + std::abs(before[i])))
            names_.refuse(mode.equation[i],
                          fmt::format("the equation of {} does not repeat with the period {}", names_.symbols.states[i], T));
      }
    }
  }

  /// Checks divisions, roots and logarithms: those of parameters in every mode, those of the motion in the mode of the start.
  void check_values() const {
    const Vector zero = Vector::Zero(states_);
    std::optional<std::size_t> start_mode;
    if (names_.start) {
      // Checked before the mode is determined: a guard may divide by zero, too.
      for (const EventPiece& event : pieces_.events) check_values(event.guard, *names_.start, true, event.when);
      start_mode = mode_at(system_, 0.0, *names_.start, names_.defaults);
      if (!start_mode) {
        std::vector<std::string> contacts, others;  // each name once; a stop has guards in many modes
        for (const EventPiece& event : pieces_.events) {
          std::vector<std::string>& list = begins_contact(event.kind) ? contacts : others;
          const bool beyond = values(graph_, {&event.guard, 1}, 0.0, *names_.start, names_.defaults)[0] > 0.0;
          if (beyond && std::find(list.begin(), list.end(), event.name) == list.end()) list.push_back(event.name);
        }
        names_.refuse(text_.start.front().state.place, fmt::format("the start lies beyond a guard of every mode ({})",
                                                                   fmt::join(contacts.empty() ? others : contacts, ", ")));
      }
    }
    for (std::size_t m = 0; m < pieces_.modes.size(); ++m)
      for (std::size_t i = 0; i < pieces_.modes[m].field.size(); ++i)
        check_values(pieces_.modes[m].field[i], names_.start ? *names_.start : zero, start_mode == m,
                     pieces_.modes[m].equation[i]);
    for (const EventPiece& event : pieces_.events) {
      if (!names_.start) check_values(event.guard, zero, false, event.when);
      for (const Expression one : event.map) check_values(one, zero, false, event.reset);
    }
  }

  void check_values(Expression root, const Vector& x, bool with_motion, const Place& otherwise) const {
    const auto check = [&](Expression part) {
      if (const auto found = find_not_finite({graph_, names_.symbols, names_.hazards}, part, 0.0, x, names_.defaults, otherwise))
        names_.refuse(found->place,
                      fmt::format("{} {}", found->sentence, found->moves ? "at the start" : "at the default parameters"));
    };
    for (const Expression part : reachable(graph_, root))
      if (operands(graph_.node(part).operation) > 0 && !dependence(graph_, part).moves()) check(part);
    if (with_motion) check(root);
  }

  /// Checks that a reset within a mode leaves its guard, at states on the guard near the start and at random ones.
  void check_resets() const {
    std::mt19937 engine(1);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    const Vector& p = names_.defaults;
    Vector f(states_), gradient(states_), after(states_);
    for (std::size_t e = 0; e < pieces_.events.size(); ++e) {
      const Event& event = system_.events[e];
      const EventPiece& piece = pieces_.events[e];
      if (event.from != event.to || piece.text >= text_.events.size()) continue;
      const Mode& mode = system_.modes[event.from];
      const auto rate = [&](double t, const Vector& x) {
        mode.field(t, x, p, f);
        return transversality(event.guard, t, x, f, p);
      };
      for (int trial = 0; trial < reset_trials; ++trial) {
        Vector x = names_.start ? *names_.start : Vector::Zero(states_);
        for (double& value : x)
          if (trial > 0) value += any(engine) * (1.0 + std::abs(value));
        double h = event.guard.value(0.0, x, p);
        for (int i = 0; i < 30 && h != 0.0; ++i) {
          event.guard.dx(0.0, x, p, gradient);
          x -= gradient * (h / gradient.squaredNorm());
          h = event.guard.value(0.0, x, p);
        }
        if (!x.allFinite() || !(std::abs(h) <= guard_width(guard_scale(event.guard, 0.0, x, p), 0.0, x))) continue;
        const double arrives = rate(0.0, x);
        if (!(arrives > 1e-6 * (1.0 + f.lpNorm<Eigen::Infinity>()))) continue;
        if (event.reset.map) {
          event.reset.map(0.0, x, p, after);
        } else {
          after = x;
        }
        if (!after.allFinite()) continue;
        const double beyond = event.guard.value(0.0, after, p), leaves = rate(0.0, after);
        const double reach = 100.0 * guard_width(guard_scale(event.guard, 0.0, after, p), 0.0, after);
        const Place& place = piece.reset.line > 0 ? piece.reset : piece.when;
        if (beyond > reach || (beyond >= -reach && leaves > 1e-9 * (1.0 + f.lpNorm<Eigen::Infinity>())))
          names_.refuse(
              place,
              fmt::format("{} leaves the state beyond its guard in mode {}: the guard is {:.3g} and rises at the rate {:.3g} "
                          "after it; to mark an "
                          "instant at which nothing changes, write two modes with the same equations and an event each way",
                          event.reset.map ? fmt::format("the reset of {}", event.name)
                                          : fmt::format("{} has no reset and", event.name),
                          mode.name, std::abs(beyond) <= reach ? 0.0 : beyond, leaves));
        break;
      }
    }
  }

  const HybridSystem& system_;
  const Names& names_;
  const SystemText& text_;
  Graph& graph_;
  const Pieces& pieces_;
  Eigen::Index states_;
};

}  // namespace

void check_system(const HybridSystem& system, const Names& names, const Pieces& pieces) { Checks(system, names, pieces).run(); }

}  // namespace graze::equations
