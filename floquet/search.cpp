// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/search.hpp>

#include <graze/floquet/settle.hpp>

#include <fmt/format.h>
#include <nlopt.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

namespace graze {

namespace {

/// The state of one search: what was found, and how long nothing new has come.
class Search {
 public:
  Search(const HybridSystem& system, const Vector& p, int period, const SearchOptions& options)
      : system_(system), p_(p), period_(period), options_(options), propagator_(system, p, {}, options.shooting.flow),
        forcing_period_(forcing_period(system, p)) {
    options_.shooting.reduce_period = true;
    options_.shooting.nodes = 0;
  }

  bool finished() const {
    return result.starts >= options_.max_starts || idle_ >= options_.patience || (options_.cancelled && options_.cancelled());
  }
  bool exhausted() const { return idle_ >= options_.patience; }
  void forget_patience() { idle_ = 0; }

  /// Newton from nodes; true if that brought a new orbit.
  bool polish(const std::vector<Vector>& nodes) {
    ++result.starts;
    ++idle_;
    for (const Vector& x : nodes)
      if (!x.allFinite() || (system_.initial_mode && !system_.initial_mode(0.0, x, p_))) return false;
    PeriodicOrbit orbit = shoot(system_, p_, nodes, period_, options_.shooting);
    if (options_.progress) options_.progress(result.starts, static_cast<int>(result.orbits.size()));
    if (!orbit.converged()) return false;
    ++result.converged;
    if (orbit.period != period_ || !orbit.multipliers.valid) return false;
    for (const PeriodicOrbit& known : result.orbits)
      if (same_orbit(system_, orbit, known)) return false;
    result.orbits.push_back(std::move(orbit));
    idle_ = 0;
    return true;
  }

  /// |P^n(x) - x|^2 with its gradient 2 (M - I)^T (P^n(x) - x), for NLopt; large where the map is not defined.
  double mismatch(const Vector& x, double* gradient) {
    constexpr double undefined = 1e6;
    const bool admissible = !system_.initial_mode || system_.initial_mode(0.0, x, p_);
    if (admissible)
      carry(propagator_, 0.0, period_ * forcing_period_, x,
            {.sensitivity = gradient ? Sensitivity::state : Sensitivity::none, .max_events = 1000}, transition_);
    if (!admissible || transition_.termination != Termination::time) {
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

  const HybridSystem& system() const { return system_; }
  SearchResult result;

 private:
  const HybridSystem& system_;
  const Vector& p_;
  int period_;
  SearchOptions options_;
  Propagator propagator_;
  double forcing_period_;
  Transition transition_;
  int idle_ = 0;
};

/// Unstable orbits inside a chaotic attractor are passed closely again and again: near returns of a settled run are good guesses.
void from_recurrences(Search& search, const Vector& p, int period, const SearchOptions& options, std::mt19937_64& random,
                      const Vector& lower, const Vector& upper) {
  constexpr int samples = 1500, attractors = 3;
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double T = forcing_period(search.system(), p), near = 0.1 * (upper - lower).norm();
  Propagator propagator(search.system(), p, {}, options.shooting.flow);
  for (int run = 0; run < attractors && !search.finished(); ++run) {
    Vector x(lower.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = lower[i] + (upper[i] - lower[i]) * unit(random);
    std::vector<Vector> states;
    Transition transition;
    for (int k = 0; k < samples; ++k) {
      carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::none}, transition);
      if (transition.termination != Termination::time) break;
      x = transition.x1;
      if (k > 200) states.push_back(x);
    }
    std::vector<std::pair<double, std::size_t>> returns;
    const auto n = static_cast<std::size_t>(period);
    for (std::size_t k = 0; k + n < states.size(); ++k) returns.emplace_back((states[k + n] - states[k]).norm(), k);
    std::sort(returns.begin(), returns.end());
    for (std::size_t i = 0; i < returns.size() && i < 400 && returns[i].first < near && !search.finished(); ++i) {
      const auto first = states.begin() + static_cast<std::ptrdiff_t>(returns[i].second);
      search.polish(std::vector<Vector>(first, first + period));
      if (returns[i].first < 1e-9) break;  // the run has settled on an orbit: all its returns are alike
    }
  }
}

/// NLopt's multi-level single linkage over the squared mismatch; every point at which a local search comes to rest is polished.
void from_nlopt(Search& search, const Vector& lower, const Vector& upper, unsigned seed, const std::function<bool()>& cancelled) {
  const auto n = static_cast<unsigned>(lower.size());
  struct Context {
    Search& search;
    const std::function<bool()>& cancelled;
    nlopt::opt& global;
    std::vector<Vector> candidates;
    double last = 1e300;
  };
  nlopt::opt global(nlopt::GD_MLSL_LDS, n), local(nlopt::LD_SLSQP, n);
  Context context{search, cancelled, global, {}};
  const auto objective = [](unsigned size, const double* x, double* gradient, void* data) -> double {
    auto& c = *static_cast<Context*>(data);
    if (c.cancelled && c.cancelled()) c.global.force_stop();
    const Vector point = Eigen::Map<const Vector>(x, size);
    const double value = c.search.mismatch(point, gradient);
    if (value < 1e-2) c.candidates.push_back(point);
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
  } catch (const std::runtime_error&) {  // a failed local search (SLSQP at a kink) ends NLopt's run; what it met is kept
  }
  // Of points that lie close together the last is the best: a local search came to it.
  const double close = 1e-2 * (upper - lower).norm();
  for (std::size_t i = 0; i < context.candidates.size() && !search.finished(); ++i) {
    const bool last_of_its_kind =
        std::none_of(context.candidates.begin() + static_cast<std::ptrdiff_t>(i) + 1, context.candidates.end(),
                     [&](const Vector& later) { return (later - context.candidates[i]).norm() < close; });
    if (last_of_its_kind) search.polish({context.candidates[i]});
  }
}

/// Additive recurrence on the n-dimensional golden ratio, shifted by the seed: evenly spread at every length.
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

}  // namespace

std::pair<Vector, Vector> search_box(const HybridSystem& system, const Vector& p, const FlowOptions& options) {
  const auto n = static_cast<Eigen::Index>(system.states);
  const double T = forcing_period(system, p);
  Propagator propagator(system, p, {}, options);
  Vector size = Vector::Constant(n, 0.0);
  Transition transition;
  for (const double scale : {0.0, 1.0, -1.0}) {
    Vector x = Vector::Constant(n, scale * 0.1);
    for (int k = 0; k < 300; ++k) {
      carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::none}, transition);
      if (transition.termination != Termination::time) break;
      x = transition.x1;
      size = size.cwiseMax(x.cwiseAbs());
    }
  }
  // Stroboscopic states show one phase only; a motion passes through the others, so every coordinate gets the largest size.
  const double reach = 1.5 * size.maxCoeff() + 1e-3;
  return {Vector::Constant(n, -reach), Vector::Constant(n, reach)};
}

SearchResult search_orbits(const HybridSystem& system, const Vector& p, int period, const SearchOptions& options) {
  if (period < 1) throw std::invalid_argument(fmt::format("period n is {}; allowed is a whole number from 1", period));
  forcing_period(system, p);
  Vector lower = options.lower, upper = options.upper;
  if (lower.size() == 0 && upper.size() == 0) std::tie(lower, upper) = search_box(system, p, options.shooting.flow);
  const auto n = static_cast<Eigen::Index>(system.states);
  if (lower.size() != n || upper.size() != n || !((upper - lower).minCoeff() > 0.0))
    throw std::invalid_argument("the search box needs a lower and a larger upper bound for each state");
  Search search(system, p, period, options);
  std::mt19937_64 random(options.seed);
  from_recurrences(search, p, period, options, random, lower, upper);
  from_nlopt(search, lower, upper, options.seed, options.cancelled);
  search.forget_patience();
  LowDiscrepancy sequence(n, random);
  while (!search.finished()) search.polish({lower + (upper - lower).cwiseProduct(sequence.next())});
  search.result.complete = search.exhausted();
  auto& orbits = search.result.orbits;
  std::stable_sort(orbits.begin(), orbits.end(), [](const PeriodicOrbit& a, const PeriodicOrbit& b) {
    return std::abs(a.multipliers.values.front()) < std::abs(b.multipliers.values.front());
  });
  return std::move(search.result);
}

}  // namespace graze
