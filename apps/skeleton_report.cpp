// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/branch_report.hpp>
#include <graze/apps/cascades.hpp>
#include <graze/apps/number.hpp>
#include <graze/apps/orbit_report.hpp>
#include <graze/apps/long_text.hpp>
#include <graze/apps/skeleton_report.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <stdexcept>

namespace graze::apps {

namespace {

/// A curve of orbits: a branch, or two that were followed both ways from one seed, the first of them run through backwards.
struct WholeCurve {
  std::vector<const Branch*> branches;
  std::vector<const BranchPoint*> points;
};

std::vector<WholeCurve> whole_curves(const std::vector<Branch>& branches) {
  std::vector<WholeCurve> list;
  for (const std::vector<std::size_t>& places : curves_of(branches)) {
    WholeCurve curve;
    for (const std::size_t place : places) {
      const Branch& branch = branches[place];
      curve.branches.push_back(&branch);
      std::reverse(curve.points.begin(), curve.points.end());
      if (!curve.points.empty()) curve.points.pop_back();  // the seed, which both have
      for (const BranchPoint& point : branch.points) curve.points.push_back(&point);
    }
    list.push_back(std::move(curve));
  }
  return list;
}

/// "1/1 2/1 1/2": the labels z = p/n along a curve, each where it changes.
std::string labels_along(const WholeCurve& curve) {
  std::string text, last;
  for (const BranchPoint* point : curve.points) {
    const std::string z = label(point->impacts, point->isolated_impacts, curve.branches.front()->period);
    if (z == last) continue;
    text += (text.empty() ? "" : " ") + z;
    last = z;
  }
  return text;
}

/// "1" or, of a curve that was followed both ways, "1 and 2".
std::string of_each(const WholeCurve& curve, const auto& text) {
  std::string out;
  for (const Branch* branch : curve.branches) out += (out.empty() ? "" : " and ") + std::string(text(*branch));
  return out;
}

Table curves_overview(const std::vector<Branch>& branches, const std::string& parameter) {
  Table table{{"branch", "born at", "period", "z along it", parameter + " from", "to", "points", "stable", "ends"}, {}};
  for (const WholeCurve& curve : whole_curves(branches)) {
    if (curve.points.empty()) continue;
    const Branch& first = *curve.branches.front();
    double low = curve.points.front()->value, high = low;
    std::size_t stable = 0;
    for (const BranchPoint* point : curve.points) {
      low = std::min(low, point->value);
      high = std::max(high, point->value);
      stable += point->stable ? 1 : 0;
    }
    table.rows.push_back({of_each(curve, [](const Branch& branch) { return std::to_string(branch.id); }),
                          first.parent ? fmt::format("{} of {}", first.parent->label, first.parent->branch) : "seed",
                          std::to_string(first.period), labels_along(curve), rounded(low, 9), rounded(high, 9),
                          std::to_string(curve.points.size()),
                          stable == 0                     ? "no"
                          : stable == curve.points.size() ? "yes"
                                                          : "in part",
                          of_each(curve, [](const Branch& branch) { return branch_stop_name(branch.stop); })});
  }
  return table;
}

Table special_points_overview(const std::vector<Branch>& branches, const std::string& parameter) {
  std::vector<std::pair<const Branch*, const SpecialPoint*>> list;
  for (const Branch& branch : branches)
    for (const SpecialPoint& point : branch.special_points)
      if (point.type != PointType::EP) list.emplace_back(&branch, &point);
  std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.second->value > b.second->value; });
  Table table{{"point", parameter, "+-", "branch", "z", "details"}, {}};
  for (const auto& [branch, point] : list) {
    std::string details = point->status == PointStatus::bracketed ? "bracketed" : "";
    for (const char* name : {"criticality", "kind", "scenario"}) {
      const auto found = point->details.find(name);
      if (found != point->details.end()) details += (details.empty() ? "" : ", ") + std::get<std::string>(found->second);
    }
    table.rows.push_back({point->label, rounded(point->value, 12), rounded(point->precision, 2), std::to_string(branch->id),
                          label(point->orbit.impacts, point->orbit.isolated_impacts, point->orbit.period), details});
  }
  return table;
}

Json seeds_json(const std::vector<SkeletonSeed>& seeds, std::size_t parameter) {
  Json list = Json::array();
  for (const SkeletonSeed& seed : seeds)
    list.push_back({{"value", seed.orbit.parameters[static_cast<Eigen::Index>(parameter)]},
                    {"period", seed.orbit.period},
                    {"impacts", seed.orbit.impacts},
                    {"state", to_json(seed.orbit.state)},
                    {"stable", seed.orbit.stable()},
                    {"origin", seed.origin}});
  return list;
}

Json fineness_json(const SearchFineness& fineness) {
  Json json = {{"max_period", fineness.max_period},
               {"values", fineness.values},
               {"spacing", fineness.spacing},
               {"starts", fineness.starts}};
  json["unstable"] = {{"max_period", fineness.unstable_period}, {"values", fineness.unstable_values}};
  return json;
}

/// What fineness_json holds in a sentence.
std::string fineness_text(const Json& search, const std::string& parameter) {
  std::string text = fmt::format("orbits up to period {} were searched at {} values of {}, {} apart, as the ends of motions "
                                 "from {} starts each",
                                 search.at("max_period").get<int>(), search.at("values").get<int>(), parameter,
                                 rounded(search.at("spacing"), 4), search.at("starts").get<int>());
  const Json& unstable = search.at("unstable");
  if (const int values = unstable.at("values"); values > 0)
    text += fmt::format(";\nunstable ones up to period {} at {} values", unstable.at("max_period").get<int>(), values);
  else
    text += ";\nunstable ones were not (--all)";
  return text + "\n";
}

}  // namespace

void put_skeleton(Json& result, const Skeleton& found, std::size_t parameter, int threads) {
  if (result.is_null()) result = Json::object();
  reserve_members(result, result.size() + 9);
  result["search"] = fineness_json(found.fineness);
  result["seeds"] = seeds_json(found.seeds, parameter);
  const std::vector<Branch>& branches = found.graph.branches;
  Json& list = result["branches"] = Json::array_t(branches.size());
  on_threads(threads, branches.size(), [&](std::size_t k) { list[k] = branch_json(branches[k]); });
  for (const std::vector<std::size_t>& curve : curves_of(found.graph.branches))
    for (const std::size_t place : curve) result["branches"][place]["family"] = found.graph.branches[curve.front()].id;
  result["cascades"] = cascades_json(cascades(found.graph.branches));
  if (found.graph.interrupted) {
    for (std::size_t i = 0; i < found.seeds.size(); ++i)
      if (found.seeds[i].part >= 0) result["seeds"][i]["part"] = found.seeds[i].part;
    result["seed_search"] = {{"parts", found.searched.size()}, {"done", Json::array()}};
    for (std::size_t part = 0; part < found.searched.size(); ++part)
      if (found.searched[part]) result["seed_search"]["done"].push_back(part);
  }
  result["cut_off"] = Json::array();
  for (const CutOff& cut : found.graph.cut_off) {
    result["cut_off"].push_back({{"branch", cut.branch}, {"label", cut.label}, {"reason", cut.reason}});
    if (cut.families > 0) result["cut_off"].back()["families"] = cut.families;
  }
}

SeedsSoFar seeds_from(const Json& result, const Problem& problem, const std::string& parameter) {
  SeedsSoFar out;
  const Json& search = result.at("seed_search");
  out.searched.resize(search.at("parts").get<std::size_t>());
  for (const Json& part : search.at("done")) out.searched.at(part.get<std::size_t>()) = 1;
  for (const Json& json : result.at("seeds")) {
    SkeletonSeed seed;
    seed.part = json.value("part", -1);
    if (seed.part < 0) continue;
    seed.origin = json.at("origin");
    Problem at = problem;
    set_parameter(at, parameter, json.at("value"));
    const Vector state = vector_from(json.at("state"));
    if (static_cast<std::size_t>(state.size()) != problem.system.states) throw std::invalid_argument("a state of another size");
    // It is that of a converged orbit: Newton's method has nothing to do but to find what belongs to it.
    seed.orbit = shoot(at.system, at.parameters, state, json.at("period").get<int>());
    if (!seed.orbit.converged()) out.searched.at(static_cast<std::size_t>(seed.part)) = 0;
    out.seeds.push_back(std::move(seed));
  }
  return out;
}

std::vector<CutOff> cut_off_from(const Json& list) {
  std::vector<CutOff> out;
  for (const Json& cut : list)
    out.push_back({cut.at("branch").get<int>(), cut.at("label").get<std::string>(), cut.at("reason").get<std::string>(),
                   cut.value("families", 0)});
  return out;
}

std::string skeleton_text(const Json& search, std::size_t seeds, const std::vector<Branch>& branches,
                          const std::vector<CutOff>& cut_off, const std::string& parameter) {
  const std::size_t curves = curves_of(branches).size();
  std::string count = curves == 1 ? "1 branch" : fmt::format("{} branches", curves);
  if (curves < branches.size()) count += fmt::format(" ({} of them in two halves, from a seed inside)", branches.size() - curves);
  std::string text = fmt::format("{}, {}\n", counted(seeds, "seed"), count) + fineness_text(search, parameter) + "\n" +
                     aligned(curves_overview(branches, parameter)) +
                     "\n" + aligned(special_points_overview(branches, parameter)) + cascades_text(cascades(branches), parameter);
  if (cut_off.empty()) return text;
  text += fmt::format("\nnot followed ({}):\n", cut_off.size());
  // One line for all ways from seeds of a reason, which have no names, and for all that an interruption left over.
  std::map<std::string, std::size_t> seeds_left;
  std::size_t points_left = 0;
  for (const CutOff& cut : cut_off) {
    if (cut.branch == 0 && cut.families > 0)
      text += fmt::format("  {} left out: {} (--all keeps them)\n", cut.families, cut.reason);
    else if (cut.branch == 0)
      ++seeds_left[cut.reason];
    else if (cut.reason.ends_with(was_interrupted))
      ++points_left;
    else
      text += fmt::format("  {} of branch {}: {}\n", cut.label, cut.branch, cut.reason);
  }
  if (points_left > 0) seeds_left.try_emplace(was_interrupted, 0);
  for (const auto& [reason, seed_count] : seeds_left) {
    std::string left = seed_count > 0 ? counted(seed_count, "way") + " from seeds (two from each)" : "";
    if (points_left > 0 && reason == was_interrupted)
      left += (left.empty() ? "" : " and ") + counted(points_left, "special point");
    text += fmt::format("  {}: {}\n", left, reason);
  }
  return text;
}

}  // namespace graze::apps
