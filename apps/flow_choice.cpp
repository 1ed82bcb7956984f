// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/flow_choice.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace graze::apps {

namespace {

const std::vector<std::string> names = {"automatic", "alone", "general"};  // in the order of FlowKind

}  // namespace

FlowKind FlowChoice::kind() const {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw std::invalid_argument(fmt::format("flow is {}; allowed are {}", name, fmt::join(names, ", ")));
  return static_cast<FlowKind>(found - names.begin());
}

void add_flow_option(CLI::App& app, FlowChoice& choice) {
  add_choice(
      app, "--flow", choice.name, names,
      "what carries the motions: many side by side in SIMD lanes (automatic, the default), the same one by one (alone), or "
      "one by one by GSL's rk8pd (general); the last two are slower and there to compare with");
}

void put_flow(Json& options, FlowKind kind) {
  if (kind != FlowKind::automatic) options["flow"] = names.at(static_cast<std::size_t>(kind));
}

FlowKind flow_from(const Json& options) {
  return options.contains("flow") ? FlowChoice{options.at("flow")}.kind() : FlowKind::automatic;
}

}  // namespace graze::apps
