// SPDX-License-Identifier: GPL-3.0-or-later
// FlowChoice: the option --flow. It selects the propagation (FlowKind), so that a user can compare the fast paths with slower,
// independent ones.
#pragma once

#include <graze/apps/console/arguments.hpp>
#include <graze/apps/text/json.hpp>

#include <graze/lib/flow/flow.hpp>

#include <string>

namespace graze::apps {

/// "automatic", "alone" or "general".
struct FlowChoice {
  std::string name = "automatic";

  FlowKind kind() const;
};

/// Adds the option --flow.
void add_flow_option(CLI::App& app, FlowChoice& choice);

/// Adds the flow to a result's options as "flow", unless it is automatic.
void put_flow(Json& options, FlowKind kind);

/// The flow in a result's options. @throws Json::exception, std::invalid_argument if it is not a flow.
FlowKind flow_from(const Json& options);

}  // namespace graze::apps
