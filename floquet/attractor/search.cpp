// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/attractor_task.hpp>
#include <graze/floquet/attractor/search.hpp>
#include <graze/floquet/orbit/search_box.hpp>
#include <graze/floquet/orbit/shooting_nodes.hpp>
#include <graze/floquet/orbit/state_distance.hpp>
#include <graze/lib/numerics/parallel.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include <fmt/format.h>
#include <nlopt.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <random>
#include <span>
#include <stdexcept>
#include <utility>

namespace graze {

namespace {

/// Limits of the quick Newton iteration. Measured on the systems of tests/floquet/search.cpp: of the starts from which Newton
/// with 40 iterations and 12 halvings converges, these limits lose up to two in five, at a fifth of the cost.
constexpr int quick_iterations = 20, quick_halvings = 3;
/// Newton is hopeless if it has not halved its residual within this many iterations.
constexpr std::size_t quick_window = 4;
/// The quick iteration only has to distinguish orbits; shoot() polishes the new ones to the accuracy requested.
constexpr double quick_tolerance = 1e-8, quick_residual = 1e-7;
/// An iterate this close to a known orbit (relative to 1 + |x|) has found it again. Orbits closer together exist only within
/// about 1e-12 of a bifurcation.
constexpr double same_place = 1e-6;
/// Forcing phases (over 2 pi) of the states in Newton's equations, used in turn. If an orbit is in stiff contact at such a
/// phase, the return map bends so sharply that hardly any start converges; half a period away the mass is in free flight.
constexpr std::array section_phases = {0.0, 0.5};

FlowOptions quick_flow(FlowOptions options, std::size_t max_steps) {
  options.tolerance = std::max(options.tolerance, quick_tolerance);
  if (max_steps > 0) options.max_steps = max_steps;
  return options;
}

constexpr std::size_t most_events = 1000;

}  // namespace

/// The nodes of a start: Newton's method ends where it is hopeless, and takes no step out of the box. (In
/// no unnamed namespace: g++ 12 warns of tasks that hold one's types.)
class QuickNodes : public ShootingNodes {
 public:
  QuickNodes(ShootingEquations& equations, const Vector& lower, const Vector& upper)
      : ShootingNodes(equations, {.sensitivity = Sensitivity::state, .max_events = most_events}), lower_(lower), upper_(upper) {}

  std::optional<double> residual(const Vector& trial) {
    const auto x = trial.head(lower_.size()).array();
    const bool inside = (x >= lower_.array()).all() && (x <= upper_.array()).all();
    const bool is_start = std::exchange(is_start_, false);
    return inside || is_start ? ShootingNodes::residual(trial) : std::nullopt;
  }
  bool gives_up(const NewtonReport& report) const {
    const std::vector<double>& history = report.residual_history;
    return history.back() <= quick_residual ||
           (history.size() > quick_window && history.back() > 0.5 * history[history.size() - 1 - quick_window]);
  }

 private:
  const Vector &lower_, &upper_;
  bool is_start_ = true;
};

namespace {

/// Newton's method from one start, as one thread computes it: the shooting equations at each of the section phases.
class Shooter {
 public:
  Shooter(const HybridSystem& system, const Vector& p, int period, const SearchBox& box, const ShootingOptions& shooting)
      : lower_(2.0 * box.lower - box.upper), upper_(2.0 * box.upper - box.lower), shooting_(shooting) {
    const FlowOptions flow = quick_flow(shooting.flow, box.max_steps * static_cast<std::size_t>(period));
    for (const double phase : section_phases)
      sections_.push_back({{system, p, period, 1, {}, flow, phase}, {system, p, period, period, {}, flow, phase}});
  }

  Propagator& propagator() { return sections_.front().single.propagator(); }
  /// The shooting equations at a section phase, in one or in multiple shooting.
  ShootingEquations& equations(std::size_t section, bool multiple) {
    return multiple ? sections_[section].multiple : sections_[section].single;
  }

  /// The state carried over this time, from the phase at `start`; nullopt if the motion ends before.
  std::optional<Vector> carried(const Vector& x, double start, double time) {
    if (time == 0.0) return x;
    carry(propagator(), start, start + time, x, {.sensitivity = Sensitivity::none, .max_events = most_events}, transition_);
    if (transition_.termination != Termination::time) return std::nullopt;
    return transition_.x1;
  }

  /// The unknowns to which Newton's method converges from these states, one a node; the first one is carried to those that are
  /// missing. Few halvings; it gives up as soon as it is hopeless.
  std::optional<Vector> newton(std::size_t section, bool multiple, std::span<const Vector> states) {
    ShootingEquations& its = equations(section, multiple);
    const Eigen::Index n = states.front().size();
    Vector u = Vector::Zero(its.unknowns());
    const double stretch = its.duration(u) / its.nodes();
    for (int j = 0; j < its.nodes(); ++j) {
      const auto given = static_cast<std::size_t>(j);
      if (given < states.size()) {
        u.segment(j * n, n) = states[given];
        continue;
      }
      const std::optional<Vector> next = carried(its.node(u, j - 1), its.node_time(u, j - 1), stretch);
      if (!next) return std::nullopt;
      u.segment(j * n, n) = *next;
    }
    QuickNodes nodes(its, lower_, upper_);
    const NewtonRule rule{.max_iterations = std::min(quick_iterations, shooting_.max_iterations),
                          .acceptance = quick_residual,
                          .tolerance = quick_residual,
                          .rounding = quick_residual,
                          .max_halvings = std::min(quick_halvings, shooting_.max_halvings),
                          .max_step = shooting_.max_step};
    const NewtonReport report = result_at_once(newton_loop(nodes, rule, u));
    if (report.residual_history.empty() || report.residual() > quick_residual) return std::nullopt;
    return u;
  }

 private:
  struct Section {
    ShootingEquations single, multiple;
  };
  Vector lower_, upper_;  ///< the box extended by its own size on each side; Newton gives up outside
  ShootingOptions shooting_;
  std::vector<Section> sections_;
  Transition transition_;
};

/// Starts that are tried together: few, because those beside known orbits do not know the orbits found meanwhile.
constexpr std::size_t starts_of_a_round = 16;

/// A start of Newton's method: a state at the section phase, or one for each period.
struct SearchStart {
  std::size_t section = 0;
  std::vector<Vector> states = {};
};

/// State of one search: the orbits found, and the number of starts since the last new one.
class Search {
 public:
  Search(const HybridSystem& system, const Vector& p, int period, const SearchBox& box, const SearchOptions& options)
      : system_(system), p_(p), period_(period), options_(options), T_(forcing_period(system, p)) {
    options_.shooting.reduce_period = true;
    options_.shooting.nodes = 0;
    const std::size_t threads = options.all_threads ? available_threads() : 1;
    for (std::size_t i = 0; i < threads; ++i) shooters_.emplace_back(system, p, period, box, options.shooting);
  }

  bool finished() const { return result.starts >= options_.max_starts || idle_ >= options_.patience || cancelled(); }
  bool exhausted() const { return idle_ >= options_.patience; }
  void reset_patience() { idle_ = 0; }

  /// The section of a start that follows `before` others which have not been tried.
  std::size_t section_in_turn(std::size_t before) const {
    return (static_cast<std::size_t>(result.starts) + before) / 2 % section_phases.size();
  }
  /// A state beside a known orbit: orbits are born in pairs, at folds and at grazings, and stay close together. Empty if none is
  /// known.
  Vector near_known(std::size_t section, std::mt19937_64& random, double size) const {
    const std::vector<Vector>& known = known_states_[section];
    if (known.empty()) return {};
    std::uniform_int_distribution<std::size_t> pick(0, known.size() - 1);
    std::uniform_real_distribution<double> distance(std::log(1e-3 * size), std::log(1e-1 * size));
    std::normal_distribution<double> normal;
    Vector direction(known.front().size());
    for (double& d : direction) d = normal(random);
    return known[pick(random)] + std::exp(distance(random)) * direction.normalized();
  }

  /// Newton from these starts, up to the end of the search. Single and multiple shooting take turns for starts of one state,
  /// because each converges where the other fails.
  void try_all(std::span<const SearchStart> starts) {
    for (std::size_t begin = 0; begin < starts.size() && !finished(); begin += starts_of_a_round)
      try_round(starts.subspan(begin, std::min(starts_of_a_round, starts.size() - begin)));
  }

  /// |P^n(x) - x|^2 with its gradient 2 (M - I)^T (P^n(x) - x), for NLopt; 1e6 with zero gradient where the map is undefined.
  double mismatch(const Vector& x, double* gradient) {
    constexpr double undefined = 1e6;
    carry(propagator(), 0.0, period_ * T_, x,
          {.sensitivity = gradient ? Sensitivity::state : Sensitivity::none, .max_events = most_events}, transition_);
    if (transition_.termination != Termination::time) {
      if (gradient) std::fill_n(gradient, x.size(), 0.0);
      return undefined;
    }
    const Vector gap = transition_.x1 - x;
    if (gradient) {
      const Vector slope = 2.0 * (transition_.Phi.transpose() * gap - gap);
      std::copy(slope.begin(), slope.end(), gradient);
    }
    return gap.squaredNorm();
  }

  Propagator& propagator() { return shooters_.front().propagator(); }
  SearchResult result;

 private:
  bool cancelled() const { return options_.cancelled && options_.cancelled(); }

  void try_round(std::span<const SearchStart> starts) {
    std::vector<std::optional<Vector>> converged(starts.size());
    const auto is_multiple = [&, first = static_cast<std::size_t>(result.starts)](std::size_t i) {
      return starts[i].states.size() > 1 || (first + i) % 2 == 0;
    };
    const std::size_t parts = std::min(shooters_.size(), starts.size());
    in_parallel(parts, [&](std::size_t part) {
      for (std::size_t i = part; i < starts.size() && !cancelled(); i += parts)
        converged[i] = shooters_[part].newton(starts[i].section, is_multiple(i), starts[i].states);
    });
    for (std::size_t i = 0; i < starts.size() && !finished(); ++i) {
      count_start();
      if (converged[i]) add_if_new(starts[i].section, is_multiple(i), *converged[i]);
    }
  }

  void count_start() {
    ++result.starts;
    ++idle_;
    if (options_.progress) options_.progress(result.starts, static_cast<int>(result.orbits.size()));
  }

  /// Polishes a converged start and stores the orbit if it is new.
  void add_if_new(std::size_t section, bool multiple, const Vector& u) {
    const Eigen::Index n = static_cast<Eigen::Index>(system_.states);
    const double close = same_place * (1.0 + u.head(n).lpNorm<Eigen::Infinity>());
    const auto found_again = [&](const Vector& x) { return (x - u.head(n)).lpNorm<Eigen::Infinity>() < close; };
    if (std::any_of(known_states_[section].begin(), known_states_[section].end(), found_again)) {
      ++result.converged;
      return;
    }
    Shooter& shooter = shooters_.front();
    const ShootingEquations& equations = shooter.equations(section, multiple);
    const double phase = section_phases[section];
    std::vector<Vector> nodes;
    for (int j = 0; j < equations.nodes(); ++j) {
      const std::optional<Vector> x = shooter.carried(equations.node(u, j), phase * T_, phase > 0.0 ? (1.0 - phase) * T_ : 0.0);
      if (!x || !mode_at(system_, 0.0, *x, p_)) return;
      nodes.push_back(*x);
    }
    PeriodicOrbit orbit = shoot(system_, p_, nodes, period_, options_.shooting);
    if (!orbit.converged()) return;
    ++result.converged;
    if (!orbit.multipliers.valid) return;
    if (orbit.period == period_) {
      for (const PeriodicOrbit& known : result.orbits)
        if (same_orbit(orbit, known) || same_but_place(orbit, known)) return;
      idle_ = 0;
    }
    // Shorter orbits are stored too: most starts may lead to them.
    for (std::size_t other = 0; other < section_phases.size(); ++other)
      for (const Vector& state : orbit.states)
        if (const std::optional<Vector> x = shooter.carried(state, 0.0, section_phases[other] * T_))
          known_states_[other].push_back(*x);
    if (orbit.period == period_) result.orbits.push_back(std::move(orbit));
  }

  const HybridSystem& system_;
  const Vector& p_;
  int period_;
  SearchOptions options_;
  double T_;
  std::deque<Shooter> shooters_;                                         ///< of each thread
  std::array<std::vector<Vector>, section_phases.size()> known_states_;  ///< of the orbits found so far, at each section phase
  Transition transition_;
  int idle_ = 0;
};

/// True if no earlier point is near; then stores the point.
bool remember_if_new(std::vector<Vector>& earlier, const Vector& point, double near) {
  if (std::any_of(earlier.begin(), earlier.end(), [&](const Vector& x) { return (x - point).norm() < near; })) return false;
  earlier.push_back(point);
  return true;
}

/// A chaotic motion passes the unstable orbits inside its attractor closely again and again: near returns of a settled run are
/// good guesses.
void from_recurrences(Search& search, double T, int period, std::mt19937_64& random, const Vector& lower, const Vector& upper) {
  constexpr int transient = 200, samples = 1300, attractors = 3;
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double size = (upper - lower).norm(), near = 0.1 * size, alike = 3e-3 * size;
  std::vector<Vector> tried;
  for (int run = 0; run < attractors && !search.finished(); ++run) {
    Vector x(lower.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = lower[i] + (upper[i] - lower[i]) * unit(random);
    std::vector<Vector> states;
    Transition transition;
    for (int k = 0; k < transient + samples && !search.finished(); ++k) {
      carry(search.propagator(), 0.0, T, x, {.sensitivity = Sensitivity::none}, transition);
      if (transition.termination != Termination::time) break;
      x = transition.x1;
      if (k >= transient) states.push_back(x);
    }
    std::vector<std::pair<double, std::size_t>> returns;
    const auto n = static_cast<std::size_t>(period);
    std::vector<SearchStart> starts;
    for (std::size_t k = 0; k + n < states.size(); ++k) returns.emplace_back((states[k + n] - states[k]).norm(), k);
    std::sort(returns.begin(), returns.end());
    for (const auto& [distance, k] : returns) {
      if (distance > near) break;
      const auto first = states.begin() + static_cast<std::ptrdiff_t>(k);
      if (remember_if_new(tried, states[k], alike)) starts.push_back({0, {first, first + period}});
      if (distance < 1e-9) break;  // the run has settled on an orbit: all its returns are alike
    }
    search.try_all(starts);
  }
}

/// Runs NLopt's multi-level single linkage on the squared mismatch, and Newton from the minima of its local searches.
void from_nlopt(Search& search, const Vector& lower, const Vector& upper, unsigned seed, const std::function<bool()>& cancelled) {
  const auto n = static_cast<unsigned>(lower.size());
  const double size = (upper - lower).norm();
  struct Context {
    Search& search;
    const std::function<bool()>& cancelled;
    nlopt::opt& global;
    double small;
    std::vector<Vector> candidates;
  };
  nlopt::opt global(nlopt::GD_MLSL_LDS, n), local(nlopt::LD_SLSQP, n);
  Context context{search, cancelled, global, 1e-4 * size * size, {}};
  const auto objective = [](unsigned count, const double* x, double* gradient, void* data) -> double {
    auto& c = *static_cast<Context*>(data);
    if (c.cancelled && c.cancelled()) c.global.force_stop();
    const Vector point = Eigen::Map<const Vector>(x, count);
    const double value = c.search.mismatch(point, gradient);
    if (value < c.small) c.candidates.push_back(point);
    return value;
  };
  try {
    nlopt::srand(seed);
    local.set_maxeval(25);
    local.set_ftol_rel(1e-6);
    global.set_local_optimizer(local);
    global.set_population(40);
    global.set_lower_bounds(std::vector<double>(lower.begin(), lower.end()));
    global.set_upper_bounds(std::vector<double>(upper.begin(), upper.end()));
    global.set_min_objective(objective, &context);
    global.set_maxeval(3000);
    const Vector middle = 0.5 * (lower + upper);
    std::vector<double> x(middle.begin(), middle.end());
    double value = 0.0;
    global.optimize(x, value);
  } catch (const nlopt::forced_stop&) {
  } catch (const std::runtime_error&) {  // SLSQP fails at a kink, which ends NLopt's run; its candidates are kept
  }
  // Of points close together the last one is the best: it is where a local search ended.
  std::vector<Vector> tried;
  std::vector<SearchStart> starts;
  for (auto candidate = context.candidates.rbegin(); candidate != context.candidates.rend(); ++candidate)
    if (remember_if_new(tried, *candidate, 1e-2 * size)) starts.push_back({0, {*candidate}});
  search.try_all(starts);
}

/// Additive recurrence on the n-dimensional golden ratio, shifted by the seed: evenly spread for any number of points.
class LowDiscrepancy {
 public:
  LowDiscrepancy(Eigen::Index n, std::mt19937_64& random) : step_(n), point_(n) {
    double golden = 2.0;  // root of g^(n+1) = g + 1
    for (int i = 0; i < 60; ++i) golden = std::pow(1.0 + golden, 1.0 / static_cast<double>(n + 1));
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (Eigen::Index i = 0; i < n; ++i) {
      step_[i] = std::pow(1.0 / golden, static_cast<double>(i + 1));
      point_[i] = unit(random);
    }
  }
  const Vector& next() {
    for (Eigen::Index i = 0; i < point_.size(); ++i) point_[i] = std::fmod(point_[i] + step_[i], 1.0);
    return point_;
  }

 private:
  Vector step_, point_;
};

/// @throws std::invalid_argument for an invalid box.
void check_box(const HybridSystem& system, const Vector& lower, const Vector& upper) {
  const auto n = static_cast<Eigen::Index>(system.states);
  const bool sizes = lower.size() == n && upper.size() == n;
  if (!sizes || !lower.allFinite() || !upper.allFinite() || !((upper - lower).minCoeff() > 0.0))
    throw std::invalid_argument("the search box needs a finite lower and a larger upper bound for each state");
}

MotionTask<> settle_to(TaskSlot& slot, const MotionFrom& start, const AttractorOptions& settling,
                       std::shared_ptr<const StableOrbit>& reached) {
  if (!mode_at(slot.system(), 0.0, start.state, start.p)) co_return;
  const Attractor attractor = co_await approach_attractor(slot, start.p, start.state, settling);
  reached = attractor.orbit;
}

}  // namespace

std::vector<PeriodicOrbit> settled_orbits(const HybridSystem& system, const std::vector<MotionFrom>& starts,
                                          const SettlingOptions& options) {
  AttractorOptions settling;
  settling.transient = options.periods;
  settling.recurrence = usual_recurrence;
  settling.max_period = options.max_period;
  settling.periods_on_orbit = 0;
  settling.lyapunov.cancelled = options.cancelled;
  settling.lyapunov.flow = options.shooting.flow;
  std::vector<std::shared_ptr<const StableOrbit>> reached(starts.size());
  run_tasks(system, options.shooting.flow, options.all_threads, starts.size(),
            [&](std::size_t i, TaskSlot& slot) { return settle_to(slot, starts[i], settling, reached[i]); });
  std::vector<PeriodicOrbit> found;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const StableOrbit* const orbit = reached[i].get();
    if (!orbit) continue;
    const Vector& p = starts[i].p;
    const auto same = [&](const PeriodicOrbit& other) {
      if (other.parameters != p || other.period != orbit->period) return false;
      if (orbit->whole) return same_orbit(other, *orbit->whole) || same_but_place(other, *orbit->whole);
      return nearest_distance(orbit->states, other.state) < same_orbit_tolerance * (1.0 + state_size(other.state));
    };
    if (std::any_of(found.begin(), found.end(), same)) continue;
    PeriodicOrbit whole = orbit->whole ? *orbit->whole : shoot(system, p, orbit->states, orbit->period, options.shooting);
    if (whole.converged() && whole.admissible == Admissibility::admissible) found.push_back(std::move(whole));
  }
  return found;
}

std::vector<PeriodicOrbit> search_stable_orbits(const HybridSystem& system, const std::vector<Vector>& parameters,
                                                const StableSearchOptions& options) {
  if (parameters.empty()) return {};
  Vector lower = options.lower, upper = options.upper;
  if (lower.size() == 0 && upper.size() == 0) {
    const FlowOptions& flow = options.settling.shooting.flow;
    const auto first = search_box(system, parameters.front(), flow, options.box_periods);
    const auto last = search_box(system, parameters.back(), flow, options.box_periods);
    lower = first.lower.cwiseMin(last.lower);
    upper = first.upper.cwiseMax(last.upper);
  }
  check_box(system, lower, upper);
  std::mt19937_64 random(options.seed);
  LowDiscrepancy sequence(lower.size(), random);
  std::vector<MotionFrom> starts;
  for (const Vector& p : parameters) {
    forcing_period(system, p);
    for (int k = 0; k < options.starts; ++k) starts.push_back({p, lower + (upper - lower).cwiseProduct(sequence.next())});
  }
  return settled_orbits(system, starts, options.settling);
}

SearchResult search_orbits(const HybridSystem& system, const Vector& p, int period, const SearchOptions& options) {
  if (period < 1) throw std::invalid_argument(fmt::format("period n is {}; allowed is a whole number from 1", period));
  forcing_period(system, p);
  const bool given = options.lower.size() > 0 || options.upper.size() > 0;
  const SearchBox box = given ? SearchBox{options.lower, options.upper, Termination::time, options.max_steps}
                              : search_box(system, p, options.shooting.flow);
  const Vector &lower = box.lower, &upper = box.upper;
  check_box(system, lower, upper);
  if (box.ended != Termination::time) {
    SearchResult nothing;
    nothing.ended = box.ended;
    return nothing;
  }
  Search search(system, p, period, box, options);
  std::mt19937_64 random(options.seed);
  from_recurrences(search, forcing_period(system, p), period, random, lower, upper);
  if (!search.finished()) from_nlopt(search, lower, upper, options.seed, options.cancelled);
  search.reset_patience();
  LowDiscrepancy sequence(lower.size(), random);
  for (int k = 0; !search.finished();) {
    std::vector<SearchStart> starts;
    for (; starts.size() < starts_of_a_round; ++k) {
      SearchStart start{search.section_in_turn(starts.size()), {}};
      Vector x;
      if (k % 3 == 2) x = search.near_known(start.section, random, (upper - lower).norm());
      if (x.size() == 0) x = lower + (upper - lower).cwiseProduct(sequence.next());
      start.states.push_back(std::move(x));
      starts.push_back(std::move(start));
    }
    search.try_all(starts);
  }
  search.result.complete = search.exhausted();
  auto& orbits = search.result.orbits;
  std::stable_sort(orbits.begin(), orbits.end(), [](const PeriodicOrbit& a, const PeriodicOrbit& b) {
    return std::abs(a.multipliers.values.front()) < std::abs(b.multipliers.values.front());
  });
  return std::move(search.result);
}

}  // namespace graze
