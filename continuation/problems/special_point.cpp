// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/problems/special_point.hpp>

#include <graze/lib/system/parameters.hpp>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace graze {

namespace {
constexpr std::array<std::pair<PointType, std::string_view>, 8> names{{{PointType::EP, "EP"},
                                                                       {PointType::LP, "LP"},
                                                                       {PointType::PD, "PD"},
                                                                       {PointType::BP, "BP"},
                                                                       {PointType::NS, "NS"},
                                                                       {PointType::GR, "GR"},
                                                                       {PointType::UZ, "UZ"},
                                                                       {PointType::MX, "MX"}}};
}  // namespace

std::string_view point_type_name(PointType type) {
  for (const auto& [value, name] : names)
    if (value == type) return name;
  return "MX";
}

PointType point_type(std::string_view given) {
  std::vector<std::string> list;
  for (const auto& [value, name] : names) {
    if (name == given) return value;
    list.emplace_back(name);
  }
  throw std::invalid_argument(unknown_name("type of special point", given, list));
}

std::string_view grazing_scenario_name(GrazingScenario scenario) {
  switch (scenario) {
  case GrazingScenario::unknown:
    break;
  case GrazingScenario::smooth:
    return "smooth";
  case GrazingScenario::persistence:
    return "persistence";
  case GrazingScenario::nonsmooth_fold:
    return "nonsmooth-fold";
  case GrazingScenario::none:
    return "none";
  case GrazingScenario::undecided:
    return "undecided";
  }
  return "unknown";
}

void set_impacts(SpecialPoint& grazing, int before, int after) {
  const int in_chatter = grazing.orbit.impacts - grazing.orbit.isolated_impacts;
  grazing.orbit.impacts = before;
  grazing.orbit.isolated_impacts = before - in_chatter;
  std::vector<EventRecord>& events = grazing.orbit.events;
  std::erase_if(events, [&](const EventRecord& event) {
    return std::any_of(grazing.touching.begin(), grazing.touching.end(),
                       [&](const EventRecord& touch) { return touch.event == event.event && touch.t == event.t; });
  });
  if (after < before) events.insert(events.end(), grazing.touching.begin(), grazing.touching.end());
  std::stable_sort(events.begin(), events.end(), [](const EventRecord& a, const EventRecord& b) { return a.t < b.t; });
  grazing.details["kind"] = after < before ? "lost" : "gained";
  grazing.details["impacts"] = std::vector<double>{static_cast<double>(before), static_cast<double>(after)};
}

bool is_marginal(PointType type) {
  return type == PointType::LP || type == PointType::PD || type == PointType::BP || type == PointType::NS;
}

bool is_smooth(const SpecialPoint& grazing) {
  const Detail smooth = std::string(grazing_scenario_name(GrazingScenario::smooth));
  const auto scenario = grazing.details.find("scenario");
  return scenario != grazing.details.end() && scenario->second == smooth;
}

std::optional<bool> stable_at(const SpecialPoint& point) {
  const bool differentiable = point.type != PointType::GR || is_smooth(point);
  if (is_marginal(point.type) || !differentiable || !point.orbit.multipliers.valid) return std::nullopt;
  return point.orbit.stable();
}

}  // namespace graze
