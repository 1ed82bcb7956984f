// SPDX-License-Identifier: GPL-3.0-or-later
// Members of JSON that was read, and may hold anything.
#pragma once

#include <graze/apps/text/json.hpp>

namespace graze::apps {

/// The text that a member of an object is; empty where there is no such member, or it is no text.
inline std::string text_of(const Json& object, const std::string& member) {
  if (!object.is_object() || !object.contains(member) || !object[member].is_string()) return {};
  return object[member];
}

}  // namespace graze::apps
