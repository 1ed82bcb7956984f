// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/basins.hpp>

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace graze {

void check_basins(const HybridSystem& system, const Matrix& starts, const BasinOptions& options, const Basins& so_far) {
  const auto count = static_cast<std::size_t>(starts.cols());
  if (count == 0) throw std::invalid_argument("there are no starts; at least one is needed");
  if (static_cast<std::size_t>(starts.rows()) != system.states)
    throw std::invalid_argument(
        fmt::format("a start has {} entries; system {} has {}", starts.rows(), system.name, system.states));
  for (const auto& [name, value] : {std::pair{"transient", options.transient},
                                    {"max_period", options.max_period},
                                    {"periods", options.periods},
                                    {"kept_states", options.kept_states}})
    if (value < 1) throw std::invalid_argument(fmt::format("{} is {}; allowed is a whole number >= 1", name, value));
  if (!so_far.outcomes.empty() && so_far.outcomes.size() != count)
    throw std::invalid_argument(
        fmt::format("the result to go on from has {} starts; here are {}", so_far.outcomes.size(), count));
  for (const StartOutcome& outcome : so_far.outcomes)
    if (outcome.fate == Fate::reached && outcome.attractor >= so_far.attractors.size())
      throw std::invalid_argument("the result to go on from names an attractor that it does not have");
}

}  // namespace graze
