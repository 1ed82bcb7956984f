// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/problem/flow_choice.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr std::array<const char*, 3> names = {"automatic", "alone", "general"};  // in the order of FlowKind

}  // namespace

FlowKind FlowChoice::kind() const {
  const auto* const found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw std::invalid_argument(fmt::format("flow is {}; allowed are {}", name, fmt::join(names, ", ")));
  return static_cast<FlowKind>(found - names.begin());
}

void add_flow_option(CLI::App& app, FlowChoice& choice) {
  add_choice(app, "--flow", choice.name, {names.begin(), names.end()},
             "integrator (default automatic: many motions side by side in SIMD lanes; alone: one at a time; general: one at a "
             "time by GSL's rk8pd; the last two are slower, for comparison)");
}

void put_flow(Json& options, FlowKind kind) {
  if (kind != FlowKind::automatic) options["flow"] = names.at(static_cast<std::size_t>(kind));
}

FlowKind flow_from(const Json& options) {
  return options.contains("flow") ? FlowChoice{options.at("flow")}.kind() : FlowKind::automatic;
}

}  // namespace graze::apps
