// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/published/attractors.hpp>
#include <graze/apps/published/claims.hpp>
#include <graze/apps/results/attractor_report.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace graze::apps {

namespace {

SweepOptions sweeping(const ClaimOptions& options, double from, double to, double step, double standard_error, int periods) {
  SweepOptions out;
  out.from = from;
  out.to = to;
  out.step = step;
  out.directions = {SweepDirection::up, SweepDirection::down};
  out.samples = 1;
  out.attractor.transient = 500;
  out.attractor.periods_on_orbit = 0;
  out.attractor.lyapunov.min_periods = 1000;
  out.attractor.lyapunov.max_periods = periods;
  out.attractor.lyapunov.standard_error = standard_error;
  out.threads = options.threads;
  out.cancelled = options.cancelled;
  return out;
}

std::vector<SweepRow> run(const Problem& problem, const SweepOptions& options) {
  return sweep(problem.system, problem.parameters, start_state(problem, std::nullopt), options);
}

}  // namespace

Claim claim_of_equal_exponents(const Published& published, const std::string& soft, const std::string& hard,
                               const ClaimOptions& options) {
  constexpr double unit = 1e-3;  // the last decimal that the source prints
  Claim claim;
  claim.name = "equal-exponents";
  claim.statement = fmt::format("near grazing {} and {} have the same exponents", soft, hard);
  claim.criterion = "at every value of eta, in each direction of the sweep, the first exponents differ by no more than a unit of "
                    "the third decimal and three standard errors";
  const Problem first = problem_of(published, soft);
  const double grazing = end_of_impactless(first).value_or(parameter(first, "eta")), step = 2.5e-4;
  const double from = std::round((grazing - 0.006) / step) * step, to = from + 0.02;
  const SweepOptions sweeps = sweeping(options, from, to, step, 3e-4, 100000);
  const std::vector<SweepRow> a = run(first, sweeps);
  if (options.progress) options.progress(0.5);
  const std::vector<SweepRow> b = run(problem_of(published, hard), sweeps);
  std::size_t equal = 0, same_kind = 0, equal_of_kind = 0, compared = 0;
  double largest = 0.0, at = from;
  claim.details["grazing"] = grazing;
  claim.details["systems"] = {soft, hard};
  claim.details["rows"] = Json::array();
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    const Attractor &x = a[k].attractor, &y = b[k].attractor;
    if (x.exponents.empty() || y.exponents.empty()) continue;
    const double difference = std::abs(x.exponents[0] - y.exponents[0]);
    const bool within = difference <= unit + 3.0 * std::hypot(x.standard_errors[0], y.standard_errors[0]);
    ++compared;
    equal += within ? 1 : 0;
    same_kind += x.type == y.type ? 1 : 0;
    equal_of_kind += within && x.type == y.type ? 1 : 0;
    if (difference > largest) {
      largest = difference;
      at = a[k].value;
    }
    claim.details["rows"].push_back({{"eta", a[k].value},
                                     {"direction", sweep_direction_name(a[k].direction)},
                                     {"exponents", {x.exponents[0], y.exponents[0]}},
                                     {"attractors", {attractor_name(x), attractor_name(y)}}});
  }
  claim.verdict = compared > 0 && equal == compared ? Verdict::agrees : Verdict::differs;
  claim.computed = fmt::format(
      "equal at {} of {} values between eta = {} and {} (grazing at {}); both are of one kind at {} values, and equal at {} of "
      "these; the largest difference is {} at {}",
      equal, compared, rounded(from, 6), rounded(to, 6), rounded(grazing, 9), same_kind, equal_of_kind, rounded(largest, 3),
      rounded(at, 6));
  return claim;
}

Claim claim_of_widest_chaos(const Published& published, const std::string& system, double clearance,
                            const ClaimOptions& options) {
  constexpr double step = 0.004, from = 0.4, to = 1.2;
  Claim claim;
  claim.name = "widest-chaos";
  claim.statement = fmt::format("chaos is widest at clearance r = {} ({})", rounded(clearance, 4), system);
  claim.criterion =
      fmt::format("of all clearances tried, r = {} has the most values of eta (from {} to {} by {}) that are chaotic in "
                  "the sweep up or in the sweep down",
                  rounded(clearance, 4), from, to, step);
  std::vector<double> clearances;
  for (int k = 1; k <= 16; ++k) clearances.push_back(clearance * k / 8.0);
  claim.details["system"] = system;
  claim.details["rows"] = Json::array();
  double widest = -1.0, at = 0.0;
  for (const double r : clearances) {
    Problem problem = problem_of(published, system);
    set_parameter(problem, "r", r);
    std::map<long, bool> chaotic;
    for (const SweepRow& row : run(problem, sweeping(options, from, to, step, 2e-3, 4000)))
      if (row.attractor.type == AttractorType::chaotic) chaotic[std::lround(row.value / step)] = true;
    if (options.cancelled && options.cancelled()) break;
    const double width = step * static_cast<double>(chaotic.size());
    claim.details["rows"].push_back({{"r", r}, {"width", width}});
    if (width > widest) {
      widest = width;
      at = r;
    }
    if (options.progress)
      options.progress(static_cast<double>(claim.details["rows"].size()) / static_cast<double>(clearances.size()));
  }
  const bool all = claim.details["rows"].size() == clearances.size();
  claim.verdict = all && at == clearance ? Verdict::agrees : Verdict::differs;
  claim.computed = fmt::format("widest at r = {}: {} of eta", rounded(at, 4), rounded(widest, 3));
  for (const Json& row : claim.details["rows"])
    if (row.at("r") == clearance)
      claim.computed += fmt::format("; at r = {}: {}", rounded(clearance, 4), rounded(row.at("width").get<double>(), 3));
  return claim;
}

const Columns<Claim>& claim_columns() {
  using C = Claim;
  static const Columns<C> list = {{"name", "of the claim", &C::name},
                                  {"claim", "statement of the source", &C::statement},
                                  {"criterion", "test of the claim", &C::criterion},
                                  {"computed", "computed result", &C::computed},
                                  {"verdict", "whether it agrees", &C::verdict},
                                  {"details", "the numbers", &C::details}};
  return list;
}

}  // namespace graze::apps
