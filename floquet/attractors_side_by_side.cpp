// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/approach.hpp>
#include <graze/floquet/rounds.hpp>
#include <graze/floquet/side_by_side.hpp>

#include <algorithm>
#include <iterator>
#include <numeric>

namespace graze {

namespace {

/// find_attractor from many starts in lanes.
class SideBySide {
 public:
  SideBySide(const HybridSystem& system, const std::vector<AverageStart>& starts, const AttractorOptions& options)
      : system_(system), starts_(starts), options_(options), many_(system, options.lyapunov.flow), out_(starts.size()) {
    for (const AverageStart& start : starts) sets_.push_back(many_.add_parameters(start.p));
  }

  std::vector<Attractor> find() {
    std::vector<std::size_t> all(starts_.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    for (std::size_t i : all) out_[i].state = starts_[i].state;
    std::vector<std::size_t> left = find(all, 0, options_);
    AttractorOptions longer = options_;
    for (int round = 1; !left.empty(); ++round) {
      longer.transient = longer_transient(longer.transient);
      left = find(left, round, longer);
    }
    return std::move(out_);
  }

 private:
  bool unsettled(std::size_t i) const {
    return out_[i].termination == Termination::time && out_[i].type != AttractorType::periodic;
  }

  /// From where they are. Returns those that have to be followed on.
  std::vector<std::size_t> find(const std::vector<std::size_t>& which, int round, const AttractorOptions& options) {
    approach(which, options);
    std::vector<std::size_t> open, repeating;
    std::copy_if(which.begin(), which.end(), std::back_inserter(open), [&](std::size_t i) { return unsettled(i); });
    std::vector<Vector> begin;
    for (const std::size_t i : open) begin.push_back(out_[i].state);
    average(open, options);
    confirm(open, options);
    if (cancelled(options)) return {};  // where averages were broken off says nothing
    const std::vector<SettlingLook> looks = look(open, std::vector(open.size(), options.max_period));
    std::vector<Lingering> watches;
    std::vector<std::size_t> sets, going_on;
    for (std::size_t k = 0; k < open.size(); ++k) {
      Attractor& attractor = out_[open[k]];
      if (looks[k].orbit) settle_on(attractor, *looks[k].orbit);
      if (looks[k].orbit || looks[k].closest == 0) continue;
      watches.push_back(watch_end(attractor, looks[k].closest, forcing_period(system_, starts_[open[k]].p), options));
      sets.push_back(sets_[open[k]]);
      repeating.push_back(k);
    }
    const auto stop = [&] { return cancelled(options); };
    if (!carry_side_by_side(many_, sets, watches, stop)) return {};
    for (std::size_t k = 0; k < repeating.size(); ++k)
      watches[k].look_back(begin[repeating[k]], periods_each(out_[open[repeating[k]]].time_average));
    if (!carry_side_by_side(many_, sets, watches, stop)) return {};
    for (std::size_t k = 0; k < repeating.size(); ++k) {
      if (!watches[k].goes_on()) continue;
      const std::size_t i = open[repeating[k]];
      if (round == most_rounds) {
        if (watches[k].always()) out_[i].type = AttractorType::undecided;
        continue;
      }
      going_on.push_back(i);
      if (watches[k].on_an_orbit()) push_off(system_, starts_[i].p, round, out_[i].state);
    }
    if (round < rounds_for_undecided && !stop())
      for (const std::size_t i : open)
        if (out_[i].type == AttractorType::undecided && std::find(going_on.begin(), going_on.end(), i) == going_on.end())
          going_on.push_back(i);
    return going_on;
  }

  void approach(const std::vector<std::size_t>& which, const AttractorOptions& options) {
    std::vector<Approach> approaches;
    std::vector<std::size_t> sets;
    for (const std::size_t i : which) {
      approaches.emplace_back(system_, starts_[i].p, Vector(out_[i].state), options);
      sets.push_back(sets_[i]);
    }
    carry_approaches(many_, sets, approaches, options, [&](const std::vector<std::size_t>& asking) {
      std::vector<int> most;
      std::vector<std::size_t> who;
      for (const std::size_t k : asking) {
        most.push_back(approaches[k].asks());
        who.push_back(which[k]);
        out_[which[k]].state = approaches[k].state();
      }
      std::vector<std::optional<PeriodicOrbit>> orbits;
      for (SettlingLook& one : look(who, most)) orbits.push_back(std::move(one.orbit));
      return orbits;
    });
    for (std::size_t k = 0; k < which.size(); ++k) out_[which[k]] = std::move(approaches[k]).result();
  }

  void average(const std::vector<std::size_t>& which, const AttractorOptions& options) {
    std::vector<AverageStart> starts;
    for (const std::size_t i : which) starts.push_back({starts_[i].p, out_[i].state});
    LyapunovOptions averaging = options.lyapunov;
    averaging.significance = options.significance;
    std::vector<LyapunovSpectrum> averages = lane_spectra(system_, starts, averaging);
    for (std::size_t k = 0; k < which.size(); ++k) take_average(std::move(averages[k]), options, out_[which[k]]);
  }

  void confirm(std::vector<std::size_t> which, const AttractorOptions& options) {
    std::erase_if(which, [&](std::size_t i) { return !wants_confirmation(options, out_[i]); });
    average(which, options);
  }

  /// Whether those motions are settling on orbits.
  std::vector<SettlingLook> look(const std::vector<std::size_t>& which, const std::vector<int>& most) {
    std::vector<SettlingMotion> motions;
    for (std::size_t k = 0; k < which.size(); ++k)
      motions.push_back({sets_[which[k]], starts_[which[k]].p, out_[which[k]].state, most[k]});
    return look_for_orbits(system_, many_, motions, nearness_of(options_), options_.lyapunov.flow);
  }

  const HybridSystem& system_;
  const std::vector<AverageStart>& starts_;
  const AttractorOptions& options_;
  ManyMotions many_;
  std::vector<std::size_t> sets_;
  std::vector<Attractor> out_;
};

}  // namespace

std::vector<Attractor> find_each_attractor(const HybridSystem& system, const std::vector<AverageStart>& starts,
                                           const AttractorOptions& options) {
  const bool side_by_side =
      options.recurrence > 0.0 && options.periods_on_orbit == 0 && lanes_know_each(system, starts, options.lyapunov.flow);
  if (side_by_side) return SideBySide(system, starts, options).find();
  std::vector<Attractor> out;
  for (const AverageStart& start : starts) out.push_back(find_attractor(system, start.p, start.state, options));
  return out;
}

}  // namespace graze
