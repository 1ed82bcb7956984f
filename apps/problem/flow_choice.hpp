// SPDX-License-Identifier: GPL-3.0-or-later
// FlowChoice: --flow, what carries the motions (FlowKind), so that a user can compare the fast paths with slower, independent
// ones.
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

/// --flow.
void add_flow_option(CLI::App& app, FlowChoice& choice);

/// Puts it among a result's options as "flow", unless it is automatic.
void put_flow(Json& options, FlowKind kind);

/// What stands there. @throws Json::exception, std::invalid_argument if it is none.
FlowKind flow_from(const Json& options);

}  // namespace graze::apps
