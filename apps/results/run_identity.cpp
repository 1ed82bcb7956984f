// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/run_identity.hpp>

#include <fmt/format.h>

#include <algorithm>

namespace graze::apps {

namespace {

std::string words(const Json& value) {
  return value.is_null() ? "not given" : value.is_string() ? value.get<std::string>() : flat(value);
}

std::optional<std::string> difference_in(const Json& there, const Json& now, const std::string& name) {
  if (!there.is_object() || !now.is_object()) {
    if (there == now) return std::nullopt;
    return fmt::format("{} is {} there and {} now", name, words(there), words(now));
  }
  std::vector<std::string> keys;
  for (const Json* object : {&now, &there})
    for (const auto& [key, value] : object->items())
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
  for (const std::string& key : keys)
    if (auto found = difference_in(there.value(key, Json()), now.value(key, Json()), name.empty() ? key : name + "." + key))
      return found;
  return std::nullopt;
}

}  // namespace

Json identity_of(const Json& head, const std::vector<std::string>& parts) {
  Json out = Json::object();
  for (const std::string& part : parts) out[part] = head.value(part, Json());
  if (out.contains("options") && out["options"].is_object())
    for (const char* key : {"problem", "set"}) out["options"].erase(key);
  return out;
}

std::optional<std::string> difference(const Json& there, const Json& now) { return difference_in(there, now, {}); }

std::optional<std::string> difference(const Json& there, const Json& now, const std::vector<std::string>& parts) {
  return difference(identity_of(there, parts), identity_of(now, parts));
}

}  // namespace graze::apps
