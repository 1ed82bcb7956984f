// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/commands/command.hpp>

namespace graze::apps {

const std::vector<Command>& commands() {
  static const std::vector<Command> list = {
      models_command(),    orbit_command(),      continue_command(),   locate_command(), diagram_command(),
      lyapunov_command(),  sweep_command(),      attractors_command(), map_command(),    verify_command(),
      reproduce_command(), trajectory_command(), poincare_command(),   plot_command(),   schema_command(),
  };
  return list;
}

}  // namespace graze::apps
