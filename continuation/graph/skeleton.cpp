// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/graph/skeleton.hpp>

#include <graze/continuation/graph/settling_chain.hpp>
#include <graze/floquet/follow/row_runner.hpp>
#include <graze/floquet/orbit/state_distance.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>

namespace graze {

namespace {

constexpr std::size_t ways = 3;         // of settling: see rows_of()
constexpr std::size_t long_rows = 2;    // of these; each keeps a thread busy
constexpr std::size_t block_size = 10;  // parameter values of the stable search that share a box

/// Number of events in a forcing period up to which the options are used unchanged. Above it, transients and numbers of values
/// shrink: at low frequencies a period holds hundreds of events, and costs (and dissipates) as much as many periods elsewhere.
constexpr double usual_events = 16.0;
constexpr int shortest_transient = 40, shortest_for_box = 16, fewest_values = 61, fewest_starts = 2;
/// Longest transient of an autonomous system, in returns.
constexpr int longest_settle_alone = 1000;

/// Impacts in a forcing period above which an orbit is likely to belong to a series towards complete chatter.
constexpr int few_impacts = 4;

/// Largest number of events in a forcing period among motions from rest and from states beside it, after their first periods.
double events_per_period(const HybridSystem& system, const Vector& p, const FlowOptions& flow) {
  constexpr int first = 20, counted = 10;
  Propagator propagator(system, p, {}, flow);
  Transition transition;
  double most = 0.0;
  for (const double start : {0.0, 1.0, -1.0}) {
    Vector x = Vector::Constant(static_cast<Eigen::Index>(system.states), start);
    if (!mode_at(system, 0.0, x, p)) continue;
    std::size_t events = 0;
    for (int k = 0; k < first + counted; ++k) {
      carry_period(propagator, x, {.sensitivity = Sensitivity::none}, transition);
      if (transition.termination != Termination::time) break;
      x = transition.x1;
      if (k >= first) events += transition.event_sequence.size();
    }
    most = std::max(most, static_cast<double>(events) / counted);
  }
  return most;
}

/// The start of the range, which has no other default here: there is no orbit yet.
double range_start(const ContinuationOptions& options) {
  if (!options.from) throw std::invalid_argument("a skeleton's range needs both ends; `from` is not set");
  return *options.from;
}

class SeedFinder {
 public:
  SeedFinder(const HybridSystem& system, const Vector& p, const SkeletonOptions& options)
      : system_(system), p_(p), options_(options),
        parameter_(static_cast<Eigen::Index>(parameter_index(system.parameters, options.continuation.parameter))),
        low_(std::min(range_start(options.continuation), options.continuation.to)),
        high_(std::max(range_start(options.continuation), options.continuation.to)) {
    shrink_to_effort();
    fineness_.max_period = longest();
    const bool forced = is_forced(system);  // orbits of autonomous systems are found by settling alone
    if (forced) {
      fineness_.values = std::max(2, options_.stable_values);
      fineness_.spacing = (high_ - low_) / (fineness_.values - 1);
      fineness_.starts = options_.stable_search.starts;
    }
    if (options_.families.all && forced) {
      fineness_.unstable_values = options_.searched_values;
      fineness_.unstable_period = std::min(options_.searched_period, longest());
    }
    blocks_ = divide_rounding_up(static_cast<std::size_t>(fineness_.values), block_size);
    found_.resize(ways + blocks_ +
                  static_cast<std::size_t>(fineness_.unstable_values) * static_cast<std::size_t>(fineness_.unstable_period));
    done_.resize(found_.size());
    if (options.searched_so_far.size() != done_.size()) return;
    done_ = options.searched_so_far;
    for (const SkeletonSeed& seed : options.seeds_so_far) {
      const auto part = static_cast<std::size_t>(seed.part);
      if (part < done_.size() && done_[part]) found_[part].push_back(seed.orbit);
    }
  }

  /// Searches all parts in parallel. `keep` is called after each part.
  void search_all(const std::function<void()>& keep) {
    std::size_t count = static_cast<std::size_t>(std::count(done_.begin(), done_.end(), char{1}));
    std::mutex telling;
    const auto finish = [&](std::size_t part, std::vector<PeriodicOrbit> orbits) {
      std::erase_if(orbits, [&](const PeriodicOrbit& orbit) { return !wanted(orbit); });
      for (PeriodicOrbit& orbit : orbits) move_to_start(orbit);
      const std::lock_guard lock(telling);
      found_[part] = std::move(orbits);
      done_[part] = !cancelled();
      ++count;
      if (options_.progress)
        options_.progress("looking for orbits", static_cast<double>(count) / static_cast<double>(done_.size()));
      keep();
    };
    RowRunnerOptions running;
    running.flow = options_.continuation.shooting.flow;
    running.threads = long_rows;
    running.cancelled = options_.continuation.cancelled;
    RowRunner settling(system_, running);
    std::array<Way, ways> settled;
    for (const std::size_t way : {std::size_t{1}, std::size_t{2}, std::size_t{0}})  // the long rows first
      if (!done_[way]) settling.give(rows_of(way, settled[way], finish));
    settling.close();
    in_parallel_on(options_.continuation.threads, done_.size(), [&](std::size_t part) {
      if (part < long_rows) return settling.work();
      if (part < ways) return;
      if (!cancelled() && !done_[part]) finish(part, do_part(part));
    });
  }

  /// The seeds found so far, in a fixed order.
  std::vector<SkeletonSeed> seeds() const {
    std::vector<SkeletonSeed> list;
    add(list, options_.more_seeds, "given", -1);
    for (std::size_t part = 0; part < found_.size(); ++part)
      add(list, found_[part], part < ways ? "settled" : "searched", static_cast<int>(part));
    return list;
  }

  const std::vector<char>& done() const { return done_; }
  const SearchFineness& fineness() const { return fineness_; }

 private:
  bool cancelled() const { return options_.continuation.cancelled && options_.continuation.cancelled(); }

  /// Longest period that is searched.
  int longest() const {
    const int period = options_.continuation.max_period;
    return period > 0 ? period : options_.stable_search.settling.max_period;
  }

  void shrink_to_effort() {
    double events = 0.0;
    for (const double part : {0.0, 0.5, 1.0})
      events += events_per_period(system_, at(low_ + part * (high_ - low_)), options_.continuation.shooting.flow) / 3.0;
    const double effort = std::max(1.0, events / usual_events);
    const auto shrink = [](int& number, double by, int least) {
      number = std::max(std::min(number, least), static_cast<int>(number / by));
    };
    StableSearchOptions& stable = options_.stable_search;
    if (!is_forced(system_)) {  // only the general integrator applies
      options_.settled_values = std::min(options_.settled_values, fewest_values);
      options_.settle = std::min(options_.settle, longest_settle_alone);
    }
    shrink(options_.settle, effort, shortest_transient);
    shrink(options_.settled_values, std::sqrt(effort), fewest_values);
    shrink(stable.settling.periods, std::sqrt(effort), shortest_transient);
    shrink(stable.starts, effort, fewest_starts);
    shrink(stable.box_periods, effort, shortest_for_box);
    stable.settling.max_period = std::min(stable.settling.max_period, stable.settling.periods);
  }

  Vector at(double value) const {
    Vector p = p_;
    p[parameter_] = value;
    return p;
  }

  bool wanted(const PeriodicOrbit& orbit) const {
    const int longest = options_.continuation.max_period;
    return orbit.converged() && orbit.admissible == Admissibility::admissible && (longest <= 0 || orbit.period <= longest);
  }

  std::vector<PeriodicOrbit> do_part(std::size_t part) const {
    return part < ways + blocks_ ? search_stable(part - ways) : search(static_cast<int>(part - ways - blocks_));
  }

  /// An orbit on which friction holds a body all along is one of a continuum. Its place becomes that of the start, if friction
  /// holds it there too: the same for all such orbits.
  void move_to_start(PeriodicOrbit& orbit) const {
    const std::vector<KeptState> kept = kept_states(orbit.monodromy);
    if (kept.empty() || !is_forced(system_)) return;
    Vector x = orbit.state;
    for (const KeptState& one : kept) one.set(x, one.of(start()));
    if (!mode_at(system_, 0.0, x, orbit.parameters)) return;
    PeriodicOrbit moved = shoot(system_, orbit.parameters, x, orbit.period, options_.continuation.shooting);
    const bool stays = state_distance(moved.state, x) < same_orbit_tolerance * (1.0 + state_size(x));
    if (wanted(moved) && stays && kept_states(moved.monodromy) == kept) orbit = std::move(moved);
  }

  Vector start() const { return options_.start.value_or(Vector::Zero(static_cast<Eigen::Index>(system_.states))); }

  std::vector<PeriodicOrbit> search_stable(std::size_t block) const {
    StableSearchOptions searching = options_.stable_search;
    searching.settling.cancelled = options_.continuation.cancelled;
    searching.settling.shooting = options_.continuation.shooting;
    searching.seed = options_.search.seed + static_cast<unsigned>(block);
    const std::size_t end = std::min(static_cast<std::size_t>(fineness_.values), (block + 1) * block_size);
    std::vector<Vector> parameters;
    for (std::size_t i = block * block_size; i < end; ++i)
      parameters.push_back(at(low_ + static_cast<double>(i) / (fineness_.values - 1) * (high_ - low_)));
    return search_stable_orbits(system_, parameters, searching);
  }

  /// The orbits of a way of settling, in the order of its values, and the number of its rows that are not finished.
  struct Way {
    std::vector<std::optional<PeriodicOrbit>> orbits = {};
    std::atomic<std::size_t> open = 0;
  };

  /// Way 0: from rest at each value, a row each; 1: a row up; 2: a row down. `finish` receives the orbits of the whole way.
  std::vector<std::shared_ptr<Row>> rows_of(std::size_t way, Way& out, const auto& finish) const {
    const int count = std::max(2, options_.settled_values);
    std::vector<Vector> all;
    for (int i = 0; i < count; ++i) {
      const double part = static_cast<double>(i) / (count - 1);
      all.push_back(at(way == 2 ? high_ - part * (high_ - low_) : low_ + part * (high_ - low_)));
    }
    AttractorOptions settling;
    settling.transient = options_.settle;
    settling.max_period = std::min(settling.max_period, options_.settle);
    settling.recurrence = usual_recurrence;
    settling.periods_on_orbit = 0;
    settling.lyapunov.flow = options_.continuation.shooting.flow;
    out.orbits.resize(all.size());
    const std::size_t length = way == 0 ? 1 : all.size();
    out.open = all.size() / length;
    std::vector<std::shared_ptr<Row>> rows;
    for (std::size_t first = 0; first < all.size(); first += length) {
      const auto begin = all.begin() + static_cast<std::ptrdiff_t>(first);
      Row::Listener listener;
      listener.commit = [&out, first](std::size_t number, const RowPoint& point) {
        if (point.attractor.orbit) out.orbits[first + number] = *point.attractor.orbit->whole;
      };
      listener.finished = [&out, way, finish] {
        if (--out.open > 0) return;
        std::vector<PeriodicOrbit> orbits;
        for (std::optional<PeriodicOrbit>& orbit : out.orbits)
          if (orbit) orbits.push_back(std::move(*orbit));
        finish(way, std::move(orbits));
      };
      auto chain =
          std::make_unique<SettlingChain>(system_, std::vector<Vector>(begin, begin + static_cast<std::ptrdiff_t>(length)),
                                          start(), settling, options_.continuation.shooting);
      rows.push_back(std::make_shared<Row>(std::move(chain), std::move(listener)));
    }
    return rows;
  }

  std::vector<PeriodicOrbit> search(int number) const {
    const int period = number % fineness_.unstable_period + 1, place = number / fineness_.unstable_period;
    SearchOptions searching = options_.search;
    searching.cancelled = options_.continuation.cancelled;
    searching.shooting = options_.continuation.shooting;
    const double part = options_.searched_values > 1 ? static_cast<double>(place) / (options_.searched_values - 1) : 0.5;
    return search_orbits(system_, at(low_ + part * (high_ - low_)), period, searching).orbits;
  }

  void add(std::vector<SkeletonSeed>& list, const std::vector<PeriodicOrbit>& orbits, const char* origin, int part) const {
    for (const PeriodicOrbit& orbit : orbits) {
      const bool known = std::any_of(list.begin(), list.end(), [&](const SkeletonSeed& seed) {
        return seed.orbit.parameters == orbit.parameters && (same_orbit(seed.orbit, orbit) || same_but_place(seed.orbit, orbit));
      });
      if (!known && wanted(orbit)) list.push_back({orbit, origin, part});
    }
  }

  const HybridSystem& system_;
  const Vector& p_;
  SkeletonOptions options_;
  Eigen::Index parameter_;
  double low_, high_;
  SearchFineness fineness_;
  std::size_t blocks_ = 0;                         ///< number of blocks of values in the stable search
  std::vector<std::vector<PeriodicOrbit>> found_;  ///< orbits of each part: ways of settling, stable blocks, searches
  std::vector<char> done_;                         ///< written by several threads, hence not vector<bool>
};

}  // namespace

std::vector<SkeletonSeed> skeleton_seeds(const HybridSystem& system, const Vector& p, const SkeletonOptions& options) {
  SeedFinder finder(system, p, options);
  finder.search_all([] {});
  return finder.seeds();
}

Skeleton skeleton(const HybridSystem& system, const Vector& p, const SkeletonOptions& options) {
  SeedFinder finder(system, p, options);
  finder.search_all([&] {
    if (options.keep)
      options.keep([&] { return Skeleton{finder.seeds(), finder.done(), finder.fineness(), {options.so_far, {}, true}}; });
  });
  Skeleton out{finder.seeds(), finder.done(), finder.fineness(), {}};
  std::vector<BranchSeed> starts;
  for (const SkeletonSeed& seed : out.seeds) starts.push_back({seed.orbit});
  // Searched orbits are followed in the order of their period: a doubled orbit is then met where it is born.
  const auto searched = std::find_if(out.seeds.begin(), out.seeds.end(),
                                     [](const SkeletonSeed& seed) { return seed.part >= static_cast<int>(ways); });
  std::stable_sort(starts.begin() + (searched - out.seeds.begin()), starts.end(),
                   [](const BranchSeed& a, const BranchSeed& b) { return a.orbit.period < b.orbit.period; });
  // A series towards complete chatter is followed from its beginning and explains the seeds further along it.
  if (!options.families.all)
    std::stable_partition(starts.begin(), starts.end(),
                          [](const BranchSeed& seed) { return seed.orbit.isolated_impacts <= few_impacts * seed.orbit.period; });
  ContinuationOptions following = options.continuation;
  following.follow_parents = true;
  following.switch_generations = std::max(following.switch_generations, 64);  // max_period is the limit
  following.max_multiple = options.max_multiple > 0 ? options.max_multiple : std::max(1, following.max_period);
  if (options.keep)
    following.complete = [&](const std::vector<Branch>& branches) {
      options.keep([&] { return Skeleton{out.seeds, out.searched, out.fineness, {branches, {}, true}}; });
    };
  out.graph = follow_branches(system, starts, following, options.so_far, options.families);
  return out;
}

}  // namespace graze
