// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/skeleton.hpp>

#include <graze/floquet/attractor.hpp>

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <stdexcept>

namespace graze {

namespace {

class SeedFinder {
 public:
  SeedFinder(const HybridSystem& system, const Vector& p, const SkeletonOptions& options)
      : system_(system), p_(p), options_(options),
        parameter_(static_cast<Eigen::Index>(parameter_index(system.parameters, options.continuation.parameter))),
        low_(std::min(*options.continuation.from, options.continuation.to)),
        high_(std::max(*options.continuation.from, options.continuation.to)) {}

  std::vector<SkeletonSeed> all() {
    const std::size_t searches = static_cast<std::size_t>(options_.searched_values) * options_.searched_period;
    std::vector<std::vector<PeriodicOrbit>> settled(3), searched(searches);
    const std::size_t jobs = settled.size() + searched.size();
    std::size_t done = 0;
    std::mutex telling;
    oneapi::tbb::task_arena arena(std::max(1, options_.continuation.threads));
    arena.execute([&] {
      oneapi::tbb::parallel_for(std::size_t{0}, jobs, [&](std::size_t job) {
        if (cancelled()) return;
        if (job < settled.size()) {
          settled[job] = attractors(static_cast<int>(job));
        } else {
          searched[job - settled.size()] = search(static_cast<int>(job - settled.size()));
        }
        const std::lock_guard lock(telling);
        ++done;
        if (options_.progress) options_.progress("looking for orbits", static_cast<double>(done) / static_cast<double>(jobs));
      });
    });
    add(options_.more_seeds, "given");
    for (auto& list : settled) add(list, "settled");
    for (auto& list : searched) add(list, "searched");
    return std::move(seeds_);
  }

 private:
  bool cancelled() const { return options_.continuation.cancelled && options_.continuation.cancelled(); }

  Vector at(double value) const {
    Vector p = p_;
    p[parameter_] = value;
    return p;
  }

  bool wanted(const PeriodicOrbit& orbit) const {
    const int longest = options_.continuation.max_period;
    return orbit.converged() && orbit.admissible == Admissibility::admissible && (longest <= 0 || orbit.period <= longest);
  }

  /// Way 0: from rest at each value; 1: sweep up; 2: sweep down.
  std::vector<PeriodicOrbit> attractors(int way) const {
    std::vector<PeriodicOrbit> found;
    const Vector rest = Vector::Zero(static_cast<Eigen::Index>(system_.states));
    std::optional<Vector> previous;
    const int count = std::max(2, options_.settled_values);
    for (int i = 0; i < count && !cancelled(); ++i) {
      const double part = static_cast<double>(i) / (count - 1);
      const Vector p = at(way == 2 ? high_ - part * (high_ - low_) : low_ + part * (high_ - low_));
      AttractorOptions settling;
      settling.transient = options_.settle;
      settling.recurrence = 1e-4;  // chaotic transients are long: without it they would have to be cut off long before
      settling.lyapunov.cancelled = options_.continuation.cancelled;
      settling.lyapunov.flow = options_.continuation.shooting.flow;
      for (const Vector& start : {previous.value_or(rest), rest}) {
        if (system_.initial_mode && !system_.initial_mode(0.0, start, p)) continue;
        const Attractor attractor = approach_attractor(system_, p, start, settling);
        if (attractor.termination != Termination::time) continue;
        if (way != 0) previous = attractor.state;
        if (attractor.orbit && wanted(*attractor.orbit)) found.push_back(*attractor.orbit);
        break;
      }
    }
    return found;
  }

  std::vector<PeriodicOrbit> search(int number) const {
    const int period = number % options_.searched_period + 1, place = number / options_.searched_period;
    SearchOptions searching = options_.search;
    searching.cancelled = options_.continuation.cancelled;
    searching.shooting = options_.continuation.shooting;
    const double part = options_.searched_values > 1 ? static_cast<double>(place) / (options_.searched_values - 1) : 0.5;
    std::vector<PeriodicOrbit> found = search_orbits(system_, at(low_ + part * (high_ - low_)), period, searching).orbits;
    std::erase_if(found, [&](const PeriodicOrbit& orbit) { return !wanted(orbit); });
    return found;
  }

  void add(const std::vector<PeriodicOrbit>& orbits, const char* origin) {
    for (const PeriodicOrbit& orbit : orbits) {
      const bool known = std::any_of(seeds_.begin(), seeds_.end(), [&](const SkeletonSeed& seed) {
        return seed.orbit.parameters == orbit.parameters && same_orbit(seed.orbit, orbit);
      });
      if (!known && wanted(orbit)) seeds_.push_back({orbit, origin});
    }
  }

  const HybridSystem& system_;
  const Vector& p_;
  const SkeletonOptions& options_;
  Eigen::Index parameter_;
  double low_, high_;
  std::vector<SkeletonSeed> seeds_;
};

}  // namespace

std::vector<SkeletonSeed> skeleton_seeds(const HybridSystem& system, const Vector& p, const SkeletonOptions& options) {
  if (!system.forcing_frequency) throw std::invalid_argument("the skeleton is that of a forced system; this one is autonomous");
  return SeedFinder(system, p, options).all();
}

Skeleton skeleton(const HybridSystem& system, const Vector& p, const SkeletonOptions& options) {
  Skeleton out;
  out.seeds = skeleton_seeds(system, p, options);
  std::vector<BranchSeed> starts;
  for (const SkeletonSeed& seed : out.seeds) starts.push_back({seed.orbit});
  ContinuationOptions following = options.continuation;
  following.follow_parents = true;
  following.switch_generations = std::max(following.switch_generations, 64);  // the period is the limit
  following.max_multiple = options.max_multiple > 0 ? options.max_multiple : std::max(1, following.max_period);
  out.graph = follow_branches(system, starts, following, options.so_far);
  return out;
}

}  // namespace graze
