// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/settling_orbit.hpp>
#include <graze/floquet/basins/attractor_classifier.hpp>
#include <graze/floquet/basins/attractor_states.hpp>
#include <graze/floquet/basins/basin_shares.hpp>
#include <graze/floquet/basins/basins.hpp>
#include <graze/floquet/basins/probed_contacts.hpp>
#include <graze/floquet/orbit/stroboscopic_states.hpp>
#include <graze/lib/numerics/parallel.hpp>
#include <graze/lib/numerics/spread_order.hpp>
#include <graze/lib/tasks/observe.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <mutex>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>

namespace graze {

namespace {

constexpr std::size_t most_attractors = 200;  // more mean that nothing can be distinguished at this parameter
constexpr double return_distance = 1e-3;      // relative to 1 + |x|: returns this close trigger a search for an orbit
constexpr double patience = 128.0;            // periods: a search with Newton's method costs more than these
constexpr int first_look = 64;                // periods
constexpr std::size_t largest_group = 1024;   // motions

/// Size of a group of motions: the threads get equally many groups of similar size, each a multiple of the motions that a thread
/// carries at once. If that is one, each motion is a group, so that all threads have work even in a small round.
std::size_t motions_of_a_group(std::size_t motions, std::size_t threads, std::size_t at_once) {
  if (at_once == 1) return 1;
  const std::size_t turns = divide_rounding_up(motions, largest_group * threads);
  return divide_rounding_up(divide_rounding_up(motions, turns * threads), at_once) * at_once;
}

struct Run {
  enum class End { cancelled, reached, new_orbit, unrecognised, inadmissible, lost };
  End end = End::cancelled;
  std::size_t attractor = 0;
  Vector state;                        ///< empty: not carried yet
  std::unique_ptr<StableOrbit> orbit;  ///< by pointer: most runs have none
  std::int64_t periods = 0;
  bool analysed = false;  ///< it has been analysed, while others waited
};

class Search {
 public:
  Search(const HybridSystem& system, const Vector& p, const Matrix& starts, const BasinOptions& options, Basins out)
      : system_(system), p_(p), starts_(starts), options_(options), at_once_(motions_at_once(system, p, options.flow)),
        table_(probed_contacts(system, p, starts, options.flow)), out_(std::move(out)) {
    for (CoexistingAttractor& found : out_.attractors) {
      std::vector<Vector> before = found.states;
      known_.add(describe(found));
      if (cancelled()) found.states = std::move(before);  // perhaps incomplete; no others will be computed
    }
    told_ = static_cast<std::size_t>(std::count_if(out_.outcomes.begin(), out_.outcomes.end(),
                                                   [](const StartOutcome& outcome) { return outcome.fate != Fate::not_run; }));
  }

  Basins search() {
    const SpreadOrder order(out_.outcomes.size());
    std::size_t begin = 0;
    for (std::size_t round = 0; begin < order.size(); ++round) {
      const std::size_t end = std::min(order.size(), begin + round_size(round));
      std::vector<std::size_t> todo;
      for (std::size_t k = begin; k < end; ++k)
        if (const std::size_t i = order[k]; out_.outcomes[i].fate == Fate::not_run) todo.push_back(i);
      if (!do_round(todo)) break;
      begin = end;
    }
    if (options_.progress) options_.progress(told_, out_.attractors.size());
    return with_shares(std::move(out_));
  }

 private:
  bool cancelled() const { return options_.cancelled && options_.cancelled(); }
  static std::size_t round_size(std::size_t round) { return std::size_t{16} << (2 * std::min<std::size_t>(round, 5)); }

  /// False: interrupted. Then the round keeps only starts that reached attractors known before it. Analysed starts are redone,
  /// because their order determines the next one; the others give the same result later.
  bool do_round(const std::vector<std::size_t>& todo) {
    const std::size_t attractors = out_.attractors.size();
    std::vector<Run> runs(todo.size());
    std::vector<std::size_t> open(todo.size());
    std::iota(open.begin(), open.end(), std::size_t{0});
    for (bool first = true; !open.empty(); first = false) {
      const std::size_t together = motions_of_a_group(open.size(), available_threads(), at_once_);
      const std::size_t groups = divide_rounding_up(open.size(), together);
      in_parallel(groups, [&](std::size_t group) {
        const std::span its(open.data() + group * together, std::min(together, open.size() - group * together));
        if (first)  // (they lie far apart in memory: fetch several at once)
          for (const std::size_t k : its) __builtin_prefetch(&starts_(0, static_cast<Eigen::Index>(todo[k])));
        std::vector<Watch> watches;
        watches.reserve(its.size());
        for (const std::size_t k : its) watches.emplace_back(*this, runs[k], todo[k], first);
        carry_all_watched(system_, p_, options_.flow, {table_, known_.ellipses()}, watches, [this] { return cancelled(); });
      });
      std::vector<std::size_t> left;
      bool analysed = false, whole = true;
      for (const std::size_t k : open) {
        Run& run = runs[k];
        if (run.end == Run::End::new_orbit) enter_orbit(run);
        // Analyse one at a time: the other motions may be on the same attractor.
        if (run.end == Run::End::unrecognised && !analysed) {
          analyse(run);
          analysed = true;
          if (run.end != Run::End::cancelled) tell();
        }
        if (run.end == Run::End::unrecognised) left.push_back(k);
        whole = whole && run.end != Run::End::cancelled;
      }
      if (!whole) {
        out_.attractors.erase(out_.attractors.begin() + static_cast<std::ptrdiff_t>(attractors), out_.attractors.end());
        known_.keep(attractors);
        for (Run& run : runs)
          if (run.analysed) run.end = Run::End::cancelled;
        take(todo, runs);
        return false;
      }
      open = std::move(left);
    }
    take(todo, runs);
    return true;
  }

  /// Stores the outcomes of the finished runs whose attractors are known.
  void take(const std::vector<std::size_t>& todo, const std::vector<Run>& runs) {
    for (std::size_t k = 0; k < todo.size(); ++k) {
      StartOutcome& outcome = out_.outcomes[todo[k]];
      const Run& run = runs[k];
      const bool reached = run.end == Run::End::reached;
      if (reached ? run.attractor >= out_.attractors.size() : run.end != Run::End::inadmissible && run.end != Run::End::lost)
        continue;
      outcome.fate = reached ? Fate::reached : run.end == Run::End::inadmissible ? Fate::inadmissible : Fate::lost;
      outcome.attractor = reached ? static_cast<std::uint32_t>(run.attractor) : 0;
      out_.periods += run.periods;
    }
  }

  /// A motion under observation until it is recognised, or until the end of the transient.
  class Watch {
   public:
    Watch(Search& search, Run& run, std::size_t start, bool first)
        : search_(search), run_(run), start_(search.starts_.col(static_cast<Eigen::Index>(start)).data()), first_(first),
          residences_(search.known_.residences()),
          // In later rounds, at least as long as recognition by cells takes.
          budget_(first ? search.options_.transient : std::max(search.options_.transient, 4 * VisitedCells::window)) {
      run.end = Run::End::cancelled;
    }

    bool open() const { return open_; }
    Eigen::Map<const Vector> state() const {
      return {run_.state.size() > 0 ? run_.state.data() : start_, search_.starts_.rows()};
    }

    /// Number of next periods that it need not see unless they end in an ellipse of AttractorClassifier.
    int skippable_periods() const {
      return residences_.empty() && looked_ < 0 && !nearing_ ? std::max(0, std::min(look_, budget_ - 1) - k_) : 0;
    }
    /// Counts periods that were left out.
    void leave_out(int periods) {
      k_ += periods;
      run_.periods += periods;
    }
    /// Takes the result of the next period.
    void see(Termination termination, const Vector& state) {
      if (termination == Termination::event_limit && search_.look_for_rest(run_, this->state())) return close(run_.end);
      if (termination != Termination::time) {
        const bool wrong_start = first_ && k_ == 0 && termination == Termination::inadmissible_start;
        return close(termination == Termination::interrupted ? Run::End::cancelled
                     : wrong_start                           ? Run::End::inadmissible
                                                             : Run::End::lost);
      }
      ++run_.periods;
      if (reached_known(state)) return close(Run::End::reached);
      run_.state = state;
      if (returned_to_orbit()) return close(run_.end);
      if (++k_ < budget_) return;
      const bool found = search_.near_orbit(run_.state, false) && search_.look_for_orbit(run_, search_.options_.max_period);
      close(found ? run_.end : Run::End::unrecognised);
    }

   private:
    void close(Run::End end) {
      run_.end = end;
      open_ = false;
      if (end != Run::End::cancelled && end != Run::End::unrecognised) search_.tell();
    }

    bool reached_known(const Vector& state) {
      const auto known = search_.known_.reached(state, residences_);
      run_.attractor = known.value_or(0);
      return known.has_value();
    }

    bool comes_closer_to_known() {
      if (search_.known_.has_come_closer(*nearing_, run_.state)) {
        run_.end = Run::End::reached;
        run_.attractor = nearing_->attractor;
        return true;
      }
      until_ += static_cast<int>(nearing_->periods);
      if (++nearing_->times * nearing_->periods <= patience && until_ < budget_) return false;
      nearing_.reset();
      return search_.look_for_orbit(run_, return_period_);
    }

    bool waits_for_known(int period) {
      nearing_ = search_.known_.nearing(run_.state, period);
      if (nearing_ && nearing_->periods >= budget_ - k_) nearing_.reset();
      if (!nearing_) return false;
      until_ = k_ + static_cast<int>(nearing_->periods);
      return_period_ = period;
      return true;
    }

    bool returned_to_orbit() {
      if (nearing_) return k_ >= until_ && comes_closer_to_known();
      if (looked_ >= 0) {
        const int n = k_ - looked_;
        const double scale = 1.0 + looked_at_.lpNorm<Eigen::Infinity>();
        const bool returned = (run_.state - looked_at_).lpNorm<Eigen::Infinity>() < return_distance * scale;
        // Near a known orbit its region is soon reached, at less cost than Newton's method.
        if (returned && !search_.near_orbit(run_.state, true) && !waits_for_known(n) && search_.look_for_orbit(run_, n))
          return true;
        if (returned || n >= search_.options_.max_period) looked_ = -1;
      } else if (k_ >= look_) {
        looked_ = k_;
        looked_at_ = run_.state;
        look_ = std::max(2 * look_, k_ + search_.options_.max_period);
      }
      return false;
    }

    Search& search_;
    Run& run_;
    const double* start_;
    bool first_, open_ = true;
    std::vector<CellResidence> residences_;
    int budget_, k_ = 0, look_ = first_look, looked_ = -1, until_ = 0, return_period_ = 0;
    Vector looked_at_;
    std::optional<ApproachTest> nearing_ = std::nullopt;
  };

  /// Whether a known orbit is so near that it may be the one sought.
  bool near_orbit(const Vector& x, bool with_region) const {
    return known_.orbit_near(x, return_distance * (1.0 + x.lpNorm<Eigen::Infinity>()), with_region);
  }

  bool look_for_orbit(Run& run, int period) const {
    return take_orbit(run, settling_orbit(system_, p_, run.state, std::min(period, options_.max_period), options_.flow));
  }

  bool look_for_rest(Run& run, const Vector& state) const {
    Propagator propagator(system_, p_, {}, options_.flow);
    // The state may be older than the last period, because periods are left out.
    const auto all = static_cast<std::size_t>(options_.transient) + 1;
    auto rest = resting_orbit(propagator, stroboscopic_states(propagator, state, all).back());
    return rest && take_orbit(run, StableOrbit(std::move(*rest)));
  }

  bool take_orbit(Run& run, std::optional<StableOrbit> orbit) const {
    if (!orbit) return false;
    run.orbit = std::make_unique<StableOrbit>(std::move(*orbit));
    run.end = Run::End::new_orbit;
    if (const auto same = known_.orbit_at(run.orbit->states.front(), run.orbit->period)) {
      run.end = Run::End::reached;
      run.attractor = *same;
    }
    return true;
  }

  void enter_orbit(Run& run) {
    Attractor attractor;
    settle_on(attractor, std::move(*run.orbit));
    run.orbit.reset();
    enter(run, std::move(attractor));
  }

  /// Conservative orbits may fill a region; those of one family count as one attractor.
  static bool one_of_a_family(const Attractor& attractor) {
    return attractor.motion == ConservativeMotion::neutral && !attractor.rests &&
           std::all_of(attractor.multipliers.begin(), attractor.multipliers.end(),
                       [](const std::complex<double>& mu) { return std::abs(mu - 1.0) < 1e-6; });
  }

  /// Assigns an attractor to a run; adds it unless it is known by now.
  void enter(Run& run, Attractor attractor) {
    run.end = Run::End::reached;
    if (attractor.type == AttractorType::periodic) {
      if (const auto same = known_.orbit_at(attractor.state, attractor.period)) {
        run.attractor = *same;
        return;
      }
      if (one_of_a_family(attractor))
        for (std::size_t i = 0; i < out_.attractors.size(); ++i)
          if (const Attractor& other = out_.attractors[i].attractor;
              one_of_a_family(other) && other.period == attractor.period && other.impacts == attractor.impacts) {
            run.attractor = i;
            return;
          }
    }
    CoexistingAttractor found;
    found.attractor = std::move(attractor);
    std::vector<Vector> states;
    KnownAttractor known = describe(found, &states);
    if (cancelled()) {  // perhaps incomplete
      run.end = Run::End::cancelled;
      return;
    }
    if (found.attractor.type != AttractorType::periodic)
      for (std::size_t i = 0; i < known_.size(); ++i) {
        constexpr double alike = 0.9;
        // Each conservative motion has its own cells: such motions are compared by their kind.
        const Attractor &other = out_.attractors[i].attractor, &its = found.attractor;
        const bool alike_in_kind = its.conservative && other.conservative && its.motion == other.motion && its.type == other.type;
        const bool alike_in_cells = known_[i].type != AttractorType::periodic && known_[i].cells.share(states) > alike &&
                                    known.cells.share(out_.attractors[i].states) > alike;
        const bool same = alike_in_kind || alike_in_cells;
        if (!same && !known_[i].orbit.holds(states.back())) continue;
        run.attractor = i;
        return;
      }
    if (out_.attractors.size() >= most_attractors) {
      run.end = Run::End::lost;
      return;
    }
    run.attractor = out_.attractors.size();
    out_.attractors.push_back(std::move(found));
    known_.add(std::move(known));
  }

  /// Analyses a motion that was not recognised during the transient: classifies it by its exponents.
  void analyse(Run& run) {
    run.analysed = true;
    AttractorOptions finding;
    finding.transient = 0;
    finding.max_period = options_.max_period;
    finding.periods_on_orbit = 0;
    finding.lyapunov.standard_error = 0.0;  // always all periods: it may still settle
    finding.lyapunov.max_periods = options_.periods;
    finding.lyapunov.flow = options_.flow;
    finding.lyapunov.all_threads = true;
    finding.lyapunov.table = table_;
    finding.lyapunov.cancelled = options_.cancelled;
    Attractor attractor = find_attractor(system_, p_, run.state, finding);
    run.periods += attractor.time_average.periods;
    run.end = Run::End::cancelled;
    if (cancelled()) return;
    if (attractor.termination != Termination::time || attractor.time_average.stop == LyapunovStop::failed) {
      run.end = attractor.termination == Termination::interrupted ? Run::End::cancelled : Run::End::lost;
      return;
    }
    enter(run, std::move(attractor));
  }

  /// Recognition data of an attractor, from its type, state and period alone, so that it is the same when a run is resumed.
  /// Also fills in `states`.
  KnownAttractor describe(CoexistingAttractor& found, std::vector<Vector>* all = nullptr) const {
    const Attractor& attractor = found.attractor;
    KnownAttractor known;
    known.type = attractor.type;
    std::vector<Vector> states;
    if (attractor.type == AttractorType::periodic) {
      known.orbit = trapping_region(system_, p_, attractor.state, attractor.period, options_.flow);
      states = known.orbit.centres;
    } else {
      const auto count = static_cast<std::size_t>(std::max(1, options_.periods));
      states = attractor_states(system_, p_, attractor, count, options_.flow, table_);
      known.cells = VisitedCells(states);
    }
    if (all) *all = states;
    if (attractor.type != AttractorType::periodic)
      states.resize(std::min(states.size(), static_cast<std::size_t>(options_.kept_states)));
    found.states = std::move(states);
    return known;
  }

  void tell() {
    if (!options_.progress) return;
    constexpr std::size_t reports = 500;  // many starts may finish at once
    if (++told_ % (out_.outcomes.size() / reports + 1) != 0) return;
    // If another thread is reporting, skip: its next report will include this start.
    if (const std::unique_lock lock(telling_, std::try_to_lock); lock) options_.progress(told_, out_.attractors.size());
  }

  const HybridSystem& system_;
  const Vector& p_;
  const Matrix& starts_;
  const BasinOptions& options_;
  const std::size_t at_once_;
  const std::shared_ptr<const ContactTable> table_;
  Basins out_;
  AttractorClassifier known_;
  std::mutex telling_;
  std::atomic<std::size_t> told_ = 0;
};

}  // namespace

Basins find_attractors(const HybridSystem& system, const Vector& p, const Matrix& starts, const BasinOptions& options,
                       const Basins& so_far) {
  check_basins(system, starts, options, so_far);
  Basins out = so_far;
  out.outcomes.resize(static_cast<std::size_t>(starts.cols()));
  oneapi::tbb::task_arena arena(std::max(1, options.threads));
  return arena.execute([&] { return Search(system, p, starts, options, std::move(out)).search(); });
}

void check_basins(const HybridSystem& system, const Matrix& starts, const BasinOptions& options, const Basins& so_far) {
  const auto count = static_cast<std::size_t>(starts.cols());
  if (count == 0) throw std::invalid_argument("there are no starts; at least one is needed");
  if (static_cast<std::size_t>(starts.rows()) != system.states)
    throw std::invalid_argument(
        fmt::format("a start has {} entries; system {} has {}", starts.rows(), system.name, system.states));
  for (const auto& [name, value] : {std::pair{"transient", options.transient},
                                    {"max_period", options.max_period},
                                    {"periods", options.periods},
                                    {"kept_states", options.kept_states}})
    if (value < 1) throw std::invalid_argument(fmt::format("{} is {}; allowed is a whole number >= 1", name, value));
  if (!so_far.outcomes.empty() && so_far.outcomes.size() != count)
    throw std::invalid_argument(
        fmt::format("the result to go on from has {} starts; here are {}", so_far.outcomes.size(), count));
  for (const StartOutcome& outcome : so_far.outcomes)
    if (outcome.fate == Fate::reached && outcome.attractor >= so_far.attractors.size())
      throw std::invalid_argument("the result to go on from names an attractor that it does not have");
}

}  // namespace graze
