// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/published/points.hpp>
#include <graze/apps/published/reproduction.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <mutex>
#include <numeric>

namespace graze::apps {

namespace {

// Progress at which the diagrams and the rows are complete, from their shares of the run time.
constexpr double until_diagrams = 0.45, until_rows = 0.8;

SweptDiagram sweep_diagram(const Published& published, const PublishedDiagram& diagram, const ReproductionOptions& options,
                           const std::vector<SweepRow>& so_far, const std::function<void(double)>& progress) {
  SweptDiagram out{diagram, problem_of(published, diagram.system), {}};
  SweepOptions sweeping;
  sweeping.from = diagram.from;
  sweeping.to = diagram.to;
  sweeping.step = diagram.step;
  sweeping.directions = {SweepDirection::up, SweepDirection::down};
  sweeping.samples = options.samples;
  sweeping.attractor.transient = 500;
  sweeping.attractor.periods_on_orbit = 0;  // the multipliers are sufficient
  sweeping.attractor.lyapunov.min_periods = 5000;
  sweeping.attractor.lyapunov.max_periods = options.sweep_periods;
  sweeping.attractor.lyapunov.standard_error = options.sweep_error;
  sweeping.threads = options.threads;
  sweeping.cancelled = options.cancelled;
  const auto all = 2.0 * static_cast<double>(sweep_values(diagram.from, diagram.to, diagram.step).size());
  sweeping.progress = [&](std::size_t rows, double) { progress(static_cast<double>(rows) / all); };
  out.rows = sweep(out.problem.system, out.problem.parameters, start_state(out.problem, std::nullopt), sweeping, so_far);
  return out;
}

/// Rows of the points and exponents, in parallel; the slow ones come first.
class Rows {
 public:
  Rows(const Published& published, const ReproductionOptions& options, const std::vector<SweptDiagram>& diagrams,
       const std::vector<Comparison>& so_far)
      : published_(published), options_(options), diagrams_(diagrams), so_far_(so_far), points_(published.points.size()),
        motions_(published.exponents.size()) {}

  void compute(const std::function<void(double)>& progress) {
    std::vector<std::size_t> order(motions_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return cost(a) > cost(b); });
    const std::size_t count = order.size() + points_.size();
    std::mutex telling;
    std::size_t done = 0;
    in_parallel_on(options_.threads, count, [&](std::size_t k) {
      if (k < order.size())
        motions_[order[k]] = motion(published_.exponents[order[k]]);
      else
        points_[k - order.size()] = points(published_.points[k - order.size()]);
      if (cancelled()) return;
      const std::lock_guard lock(telling);
      progress(static_cast<double>(++done) / static_cast<double>(count));
    });
  }

  void append(Reproduction& out) {
    for (std::vector<Comparison>& rows : points_) std::move(rows.begin(), rows.end(), std::back_inserter(out.rows));
    for (Comparison& row : motions_)
      if (!row.quantity.empty()) out.rows.push_back(std::move(row));
  }

 private:
  bool cancelled() const { return options_.cancelled && options_.cancelled(); }

  int cost(std::size_t k) const {
    const PublishedExponents& item = published_.exponents[k];
    return (item.beta.value_or(0.0) != 0.0 ? 2 : 0) + (item.attractor.type == "chaotic" ? 1 : 0);
  }

  /// An interrupted row carries no information, and is left out.
  std::vector<Comparison> points(const PublishedPoint& item) const {
    if (cancelled()) return {};
    std::vector<Comparison> rows = compare_point(published_, item, options_.cancelled);
    return cancelled() ? std::vector<Comparison>() : rows;
  }

  /// The row of the earlier run, if it has one; otherwise a new one, empty if it was interrupted.
  Comparison motion(const PublishedExponents& item) const {
    for (const Comparison& row : so_far_)
      if (row.quantity == "exponents" && row.system == item.system && row.figure == item.figure &&
          row.published == Json(item.lambda) && row.details.value("beta", 0.0) == item.beta.value_or(0.0) &&
          (!item.eta || row.eta == item.eta))
        return row;
    if (cancelled()) return {};
    ExponentsOptions asking = options_.exponents;
    asking.cancelled = options_.cancelled;
    std::vector<Start> starts;
    for (const SweptDiagram& swept : diagrams_)
      if (swept.diagram.system == item.system && item.eta && !item.beta)
        for (Start& start : starts_from(swept, *item.eta)) starts.push_back(std::move(start));
    Comparison row = compare_exponents(published_, item, starts, asking);
    return cancelled() ? Comparison() : row;
  }

  const Published& published_;
  const ReproductionOptions& options_;
  const std::vector<SweptDiagram>& diagrams_;
  const std::vector<Comparison>& so_far_;
  std::vector<std::vector<Comparison>> points_;
  std::vector<Comparison> motions_;
};

bool has_system(const Published& published, const std::string& id) {
  return std::any_of(published.systems.begin(), published.systems.end(), [&](const auto& system) { return system.id == id; });
}

}  // namespace

Reproduction reproduce(const Published& published, const ReproductionOptions& options, const Reproduction& so_far) {
  Reproduction out;
  const auto stopped = [&] { return options.cancelled && options.cancelled(); };
  const auto tell = [&](const std::string& what, double fraction) {
    if (options.progress) options.progress(what, fraction);
  };
  const auto count = static_cast<double>(published.diagrams.size());
  for (const PublishedDiagram& diagram : published.diagrams) {
    const auto earlier = std::find_if(so_far.diagrams.begin(), so_far.diagrams.end(),
                                      [&](const SweptDiagram& swept) { return swept.diagram.figure == diagram.figure; });
    const auto begun = static_cast<double>(out.diagrams.size());
    out.diagrams.push_back(
        sweep_diagram(published, diagram, options, earlier == so_far.diagrams.end() ? std::vector<SweepRow>() : earlier->rows,
                      [&](double share) { tell("figure " + diagram.figure, until_diagrams * (begun + share) / count); }));
    if (stopped()) return out;
  }
  Rows rows(published, options, out.diagrams, so_far.rows);
  rows.compute([&](double share) { tell("exponents", until_diagrams + (until_rows - until_diagrams) * share); });
  rows.append(out);
  for (const SweptDiagram& swept : out.diagrams)
    for (Comparison& row : compare_windows(swept)) out.rows.push_back(std::move(row));
  if (stopped()) return out;
  if (!options.claims) {
    out.complete = true;
    return out;
  }
  ClaimOptions asking{options.threads, options.cancelled, {}};
  const double half = 0.5 * (1.0 - until_rows);
  const auto add = [&](Claim claim) {
    if (!stopped()) out.claims.push_back(std::move(claim));
  };
  const auto kept = [&](const char* name) {
    const auto found = std::find_if(so_far.claims.begin(), so_far.claims.end(), [&](const Claim& c) { return c.name == name; });
    if (found != so_far.claims.end()) out.claims.push_back(*found);
    return found != so_far.claims.end();
  };
  if (has_system(published, "hertz-undamped") && has_system(published, "newton-elastic") && !kept("equal-exponents")) {
    asking.progress = [&](double share) { tell("the exponents near grazing", until_rows + half * share); };
    add(claim_of_equal_exponents(published, "hertz-undamped", "newton-elastic", asking));
  }
  if (!stopped() && has_system(published, "hertz-damped") && !kept("widest-chaos")) {
    asking.progress = [&](double share) { tell("the width of chaos", until_rows + half + half * share); };
    add(claim_of_widest_chaos(published, "hertz-damped", 2.0, asking));
  }
  out.complete = !stopped();
  return out;
}

}  // namespace graze::apps
