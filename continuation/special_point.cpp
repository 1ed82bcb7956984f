// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/special_point.hpp>

#include <graze/lib/parameters.hpp>

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

void set_impacts(SpecialPoint& grazing, int before, int after) {
  const int in_chatter = grazing.orbit.impacts - grazing.orbit.isolated_impacts;
  grazing.orbit.impacts = before;
  grazing.orbit.isolated_impacts = before - in_chatter;
  grazing.details["kind"] = after < before ? "lost" : "gained";
  grazing.details["impacts"] = std::vector<double>{static_cast<double>(before), static_cast<double>(after)};
}

}  // namespace graze
