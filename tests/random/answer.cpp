// SPDX-License-Identifier: GPL-3.0-or-later
#include "answer.hpp"

#include <nlohmann/json.hpp>

namespace graze::reference {

namespace {

using Json = nlohmann::json;

double number(const Json& value) { return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN(); }

std::string text(const Json& object, const char* name) {
  return object.contains(name) && object[name].is_string() ? object[name].get<std::string>() : std::string();
}

State state(const Json& values) {
  State out;
  for (const Json& value : values) out.push_back(number(value));
  return out;
}

std::vector<State> states(const Json& object) {
  std::vector<State> out;
  if (object.contains("states"))
    for (const Json& one : object["states"]) out.push_back(state(one));
  else
    out.push_back(state(object.at("state")));
  return out;
}

std::vector<std::complex<double>> multipliers(const Json& object) {
  std::vector<std::complex<double>> out;
  if (object.contains("multipliers") && object["multipliers"].is_array())
    for (const Json& mu : object["multipliers"])
      if (mu.is_array()) out.emplace_back(number(mu.at(0)), number(mu.at(1)));
  return out;
}

AnswerSpecial special(const Json& object) {
  AnswerSpecial out;
  out.label = text(object, "label");
  out.type = text(object, "type");
  out.status = text(object, "status");
  out.value = number(object.at("value"));
  out.precision = number(object.at("precision"));
  out.interval = {number(object.at("interval").at(0)), number(object.at("interval").at(1))};
  out.after_point = object.at("after_point").get<int>();
  out.period = object.at("period").get<int>();
  out.impacts = object.at("impacts").get<int>();
  out.states = states(object);
  out.multipliers = multipliers(object);
  const Json& details = object.at("details");
  out.kind = text(details, "kind");
  out.scenario = text(details, "scenario");
  out.criticality = text(details, "criticality");
  if (details.contains("impacts"))
    out.change = {static_cast<int>(number(details["impacts"].at(0))), static_cast<int>(number(details["impacts"].at(1)))};
  return out;
}

AnswerBranch branch(const Json& object) {
  AnswerBranch out;
  out.id = object.at("id").get<int>();
  if (object.at("parent").is_object()) {
    out.parent = object["parent"].at("branch").get<int>();
    out.parent_label = text(object["parent"], "label");
  }
  out.period = object.at("period").get<int>();
  out.stop = text(object.at("stop"), "reason");
  out.stop_value = number(object.at("stop").at("at"));
  for (const Json& point : object.at("points")) {
    out.points.push_back({number(point.at("value")),
                          states(point),
                          point.at("impacts").get<int>(),
                          point.contains("sticking") && point["sticking"] == true,
                          multipliers(point),
                          {}});
    if (point.contains("stable") && point["stable"].is_boolean()) out.points.back().stable = point["stable"].get<bool>();
  }
  for (const Json& point : object.at("special_points")) out.special_points.push_back(special(point));
  return out;
}

}  // namespace

Answer parse_answer(const std::string& json) {
  Answer out;
  try {
    const Json all = Json::parse(json);
    out.interrupted = text(all, "status") == "interrupted";
    for (const Json& one : all.at("branches")) out.branches.push_back(branch(one));
    if (out.branches.empty()) out.failure = "no branches";
  } catch (const std::exception& error) {
    out.failure = std::string("not the JSON that is promised: ") + error.what();
  }
  return out;
}

}  // namespace graze::reference
