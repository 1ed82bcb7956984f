// SPDX-License-Identifier: GPL-3.0-or-later
// Difference: whether two results are of the same run, so that one can go on with the other, and if not, why not.
#pragma once

#include <graze/apps/text/json.hpp>

#include <optional>
#include <string>

namespace graze::apps {

/// What of a result's head its numbers depend on: these parts of it. Where the problem's file lies and what --set has put into
/// the parameters is left out: they have it all.
Json essence(const Json& head, const std::vector<std::string>& parts);

/// The parts of a result's head that its numbers depend on; maps have their own.
inline const std::vector<std::string> run_essentials = {"model", "parameters", "systems", "options"};

/// The first difference: "parameters.b is 0.05 there and 0.06 now"; nullopt: there is none.
std::optional<std::string> difference(const Json& there, const Json& now);
/// The first in the essence of two heads.
std::optional<std::string> difference(const Json& there, const Json& now, const std::vector<std::string>& parts);

}  // namespace graze::apps
