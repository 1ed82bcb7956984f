// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/run_identity.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

namespace graze::apps {

namespace {

std::string words(const Json& value) {
  return value.is_null() ? "not given" : value.is_string() ? value.get<std::string>() : flat(value);
}

/// The first line in which two texts differ: "line 3 of NAME is ... there and ... now".
std::string line_difference(const std::string& name, const std::string& there, const std::string& now) {
  std::istringstream one(there), other(now);
  std::string a, b;
  for (int line = 1;; ++line) {
    const bool more = static_cast<bool>(std::getline(one, a)), more_now = static_cast<bool>(std::getline(other, b));
    const auto shown = [](bool is_there, const std::string& text) {
      return is_there ? "\"" + text + "\"" : std::string("not there");
    };
    if (more != more_now || a != b || !more)
      return fmt::format("line {} of {} is {} there and {} now", line, name, shown(more, a), shown(more_now, b));
  }
}

std::optional<std::string> difference_in(const Json& there, const Json& now, const std::string& name) {
  if (!there.is_object() || !now.is_object()) {
    if (there == now) return std::nullopt;
    const auto is_text = [](const Json& value) {
      return value.is_string() && value.get<std::string>().find('\n') != std::string::npos;
    };
    if (is_text(there) && is_text(now)) return line_difference(name, there.get<std::string>(), now.get<std::string>());
    return fmt::format("{} is {} there and {} now", name, words(there), words(now));
  }
  std::vector<std::string> keys;
  for (const Json* object : {&now, &there})
    for (const auto& [key, value] : object->items())
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
  for (const std::string& key : keys)
    if (auto found =
            difference_in(there.value(key, Json()), now.value(key, Json()), name.empty() ? key : fmt::format("{}.{}", name, key)))
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
