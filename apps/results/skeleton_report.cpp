// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/branch_report.hpp>
#include <graze/apps/results/cascades.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/results/same_points.hpp>
#include <graze/apps/results/skeleton_report.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <stdexcept>

namespace graze::apps {

namespace {

/// A curve of orbits: one branch, or two that were followed in both directions from one seed. The first of two is traversed
/// backwards.
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
      if (!curve.points.empty()) curve.points.pop_back();  // the seed, which both branches contain
      for (const BranchPoint& point : branch.points) curve.points.push_back(&point);
    }
    list.push_back(std::move(curve));
  }
  return list;
}

/// "1/1 2/1 1/2": the labels z = p/n along a curve, one at each change.
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

/// "1" or, for a curve that was followed in both directions, "1 and 2".
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

/// A special point in the table, and the branches that contain it.
struct ListedPoint {
  std::vector<PointOfBranch> points;
  const SpecialPoint& first() const { return *points.front().point; }
};

/// Each point once, the largest value first.
std::vector<ListedPoint> listed_points(const std::vector<Branch>& branches) {
  const SamePoints same = same_points(branches);
  std::vector<ListedPoint> list;
  for (const Branch& branch : branches)
    for (const SpecialPoint& point : branch.special_points) {
      if (point.type == PointType::EP) continue;
      const auto known = same.find(&point);
      const SpecialPoint* first = known == same.end() ? nullptr : known->second.point;
      const auto place =
          std::find_if(list.begin(), list.end(), [&](const ListedPoint& listed) { return &listed.first() == first; });
      if (place == list.end())
        list.push_back({{{&branch, &point}}});
      else
        place->points.push_back({&branch, &point});
    }
  std::stable_sort(list.begin(), list.end(),
                   [](const ListedPoint& a, const ListedPoint& b) { return a.first().value > b.first().value; });
  return list;
}

/// "19 and 20": the texts of the branches, without repetition.
std::string texts_of(const ListedPoint& listed, const auto& text_of) {
  std::vector<std::string> texts;
  for (const PointOfBranch& entry : listed.points)
    if (std::string text = text_of(entry); !text.empty() && std::find(texts.begin(), texts.end(), text) == texts.end())
      texts.push_back(std::move(text));
  return fmt::format("{}", fmt::join(texts, " and "));
}

Table special_points_overview(const std::vector<Branch>& branches, const std::string& parameter) {
  Table table{{"point", parameter, "+-", "branch", "z", "details"}, {}};
  for (const ListedPoint& listed : listed_points(branches)) {
    std::string details = listed.first().status == PointStatus::bracketed ? "bracketed" : "";
    for (const char* name : {"criticality", "kind", "scenario"}) {
      const std::string text = texts_of(listed, [name](const PointOfBranch& entry) {
        const auto found = entry.point->details.find(name);
        return found == entry.point->details.end() ? "" : std::get<std::string>(found->second);
      });
      if (!text.empty()) details += (details.empty() ? "" : ", ") + text;
    }
    table.rows.push_back({texts_of(listed, [](const PointOfBranch& entry) { return entry.point->label; }),
                          rounded(listed.first().value, 12), rounded(listed.first().precision, 2),
                          texts_of(listed, [](const PointOfBranch& entry) { return std::to_string(entry.branch->id); }),
                          texts_of(listed,
                                   [](const PointOfBranch& entry) {
                                     const PeriodicOrbit& orbit = entry.point->orbit;
                                     return label(orbit.impacts, orbit.isolated_impacts, orbit.period);
                                   }),
                          details});
  }
  return table;
}

const Columns<PeriodicOrbit>& seed_orbit_columns() {
  using O = PeriodicOrbit;
  static const Columns<O> list = {{"period", "of the orbit", &O::period},
                                  impacts_column<O>(),
                                  states_columns<O>().front(),
                                  {"stable", "no multiplier lies outside the unit circle", &O::stable}};
  return list;
}

/// Further columns of a seed in an unfinished result: with them the orbit is read back identical to the last bit.
const Columns<SkeletonSeed>& kept_columns() {
  using O = PeriodicOrbit;
  static const Columns<O> of_orbit = {{"states", "at forcing phase 0, after each period", &O::states},
                                      {"nodes", "of the shooting equations, equally spaced in time", &O::nodes},
                                      {"section_phase", "forcing phase over 2 pi of the first node", &O::section_phase},
                                      {"duration [time]", "of the orbit", &O::duration},
                                      multipliers_column<O>(),
                                      {"newton", "how Newton's method came to it", &O::newton},
                                      admissible_column<O>(),
                                      {"isolated_impacts", "impacts outside complete chatters", &O::isolated_impacts}};
  static const Columns<SkeletonSeed> list =
      joined<SkeletonSeed>({{{"part", "of the search for seeds", &SkeletonSeed::part}}, of_part(of_orbit, &SkeletonSeed::orbit)});
  return list;
}

PeriodicOrbit kept_orbit(const Json& json, const Problem& at) {
  SkeletonSeed seed;
  PeriodicOrbit& orbit = seed.orbit;
  const bool whole = json.contains("admissible");
  read(of_part<SkeletonSeed, PeriodicOrbit>(seed_orbit_columns(), &SkeletonSeed::orbit), json, seed);
  if (whole) read(kept_columns(), json, seed);
  for (const std::vector<Vector>* list : {&orbit.states, &orbit.nodes})
    for (const Vector& state : *list)
      if (static_cast<std::size_t>(state.size()) != at.system.states) throw std::invalid_argument("a state of another size");
  if (orbit.states.empty() || orbit.nodes.empty()) throw std::invalid_argument("an orbit without states");
  // Results of older versions contain less: the orbit is the same to rounding.
  if (!whole) return shoot(at.system, at.parameters, orbit.states.front(), orbit.period);
  orbit.parameters = at.parameters;
  orbit.state = orbit.states.front();
  return orbit;
}

/// The fineness of the search in one sentence.
std::string fineness_text(const Json& search, const std::string& parameter) {
  if (search.at("values") == 0) return "orbits are those that motions from the start settle on, and up and down from there\n";
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

/// A line that names the branches of which a mirror image, which is not listed, is a branch too; empty if there are none.
std::string mirrored_text(const std::vector<Branch>& branches) {
  std::vector<std::string> list;
  for (const Branch& branch : branches)
    if (branch.mirrored) list.push_back(fmt::format("branch {}", branch.id));
  return list.empty() ? ""
                      : fmt::format("  not listed: the mirror images of {}, which are branches too\n", fmt::join(list, ", "));
}

}  // namespace

Columns<SkeletonSeed> seed_columns(std::size_t parameter) {
  const auto value = [=](const SkeletonSeed& seed) { return seed.orbit.parameters[static_cast<Eigen::Index>(parameter)]; };
  return joined<SkeletonSeed>({{{"value", "of the parameter", value}},
                               of_part(seed_orbit_columns(), &SkeletonSeed::orbit),
                               {{"origin", "how it was found", &SkeletonSeed::origin}}});
}

const Columns<SearchFineness>& fineness_columns() {
  using F = SearchFineness;
  static const Columns<F> list = {
      {"max_period", "longest period in the search for stable orbits", &F::max_period},
      {"values", "parameter values of the search", &F::values},
      {"spacing", "of these values", &F::spacing},
      {"starts", "at each", &F::starts},
      object<F>("unstable", "the search for unstable orbits; 0: none",
                {{"max_period", "longest period", &F::unstable_period}, {"values", "of the parameter", &F::unstable_values}})};
  return list;
}

const Columns<CutOff>& cut_off_columns() {
  static const Columns<CutOff> list = {{"branch", "branch at which it begins; 0: at a seed", &CutOff::branch},
                                       {"label", "of the special point", &CutOff::label},
                                       {"reason", "why it was not followed", &CutOff::reason},
                                       {"families", "number of families that begin there", &CutOff::families,
                                        only([](const CutOff& cut) { return cut.families > 0; })}};
  return list;
}

Json skeleton_schema() {
  const Json count = JsonForm<int>::schema();
  Json seed = merged_schemas({schema_of(seed_columns(0)), schema_of(kept_columns())});
  seed["required"] = schema_of(seed_columns(0))["required"];
  return object_schema(
      {{"search", "how fine the search for seeds was", schema_of(fineness_columns()), false},
       {"seeds", "orbits from which branches are followed; those of an unfinished result can be read back", list_schema(seed),
        false},
       {"branches", "each with its special points", branches_schema()},
       {"cascades", "of period doublings", JsonForm<std::vector<Cascade>>::schema()},
       {"cut_off", "branches that were not followed", JsonForm<std::vector<CutOff>>::schema(), false},
       {"seed_search", "of an unfinished result",
        object_schema({{"parts", "number of parts of the search", count}, {"done", "their numbers, from 0", list_schema(count)}}),
        false}});
}

void put_skeleton(Json& result, const Skeleton& found, std::size_t parameter, int threads) {
  if (result.is_null()) result = Json::object();
  reserve_members(result, result.size() + 9);
  result["search"] = json_of(fineness_columns(), found.fineness);
  result["seeds"] = Json::array();
  const Columns<SkeletonSeed> of_seed = seed_columns(parameter);
  for (const SkeletonSeed& seed : found.seeds) {
    result["seeds"].push_back(json_of(of_seed, seed));
    if (found.graph.interrupted && seed.part >= 0) result["seeds"].back().update(json_of(kept_columns(), seed));
  }
  const std::vector<Branch>& branches = found.graph.branches;
  Json& list = result["branches"] = Json::array_t(branches.size());
  in_parallel_on(threads, branches.size(), [&](std::size_t k) { list[k] = json_of(branches[k]); });
  put_same_points(list, branches);
  for (const std::vector<std::size_t>& curve : curves_of(found.graph.branches))
    for (const std::size_t place : curve) result["branches"][place]["family"] = found.graph.branches[curve.front()].id;
  result["cascades"] = json_of(cascades(found.graph.branches));
  if (found.graph.interrupted) {
    result["seed_search"] = {{"parts", found.searched.size()}, {"done", Json::array()}};
    for (std::size_t part = 0; part < found.searched.size(); ++part)
      if (found.searched[part]) result["seed_search"]["done"].push_back(part);
  }
  result["cut_off"] = json_of(found.graph.cut_off);
}

PartialSeeds seeds_from(const Json& result, const Problem& problem, const std::string& parameter) {
  PartialSeeds out;
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
    seed.orbit = kept_orbit(json, at);
    if (!seed.orbit.converged()) out.searched.at(static_cast<std::size_t>(seed.part)) = 0;
    out.seeds.push_back(std::move(seed));
  }
  return out;
}

std::string skeleton_text(const Json& search, std::size_t seeds, const std::vector<Branch>& branches,
                          const std::vector<CutOff>& cut_off, const std::string& parameter) {
  const std::size_t curves = curves_of(branches).size();
  std::string count = curves == 1 ? "1 branch" : fmt::format("{} branches", curves);
  if (curves < branches.size()) count += fmt::format(" ({} of them in two halves, from a seed inside)", branches.size() - curves);
  std::string text = fmt::format("{}, {}\n", counted(seeds, "seed"), count) + fineness_text(search, parameter) + "\n" +
                     aligned(curves_overview(branches, parameter)) + mirrored_text(branches) + "\n" +
                     aligned(special_points_overview(branches, parameter)) + cascades_text(cascades(branches), parameter);
  if (cut_off.empty()) return text;
  text += fmt::format("\nnot followed ({}):\n", cut_off.size());
  // One line per reason for all directions from seeds, which have no names, and one for everything that an interruption left
  // over.
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
