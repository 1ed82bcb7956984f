// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/commands/command.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace graze::apps {

namespace {

std::vector<Command>& list() {
  static std::vector<Command> all = {
      models_command(),    orbit_command(),      continue_command(),   locate_command(), diagram_command(),
      lyapunov_command(),  sweep_command(),      attractors_command(), map_command(),    verify_command(),
      reproduce_command(), trajectory_command(), poincare_command(),   plot_command(),   schema_command(),
  };
  return all;
}

}  // namespace

const std::vector<Command>& commands() { return list(); }

void add_command(Command command) {
  const auto has_its_name = [&](const Command& other) { return other.name == command.name; };
  if (std::any_of(list().begin(), list().end(), has_its_name))
    throw std::invalid_argument(fmt::format("there is a command {} already; give yours another name", command.name));
  list().push_back(std::move(command));
}

}  // namespace graze::apps
