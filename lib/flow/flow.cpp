// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/flow/flow.hpp>

#include <graze/lib/flow/cubic_flow.hpp>
#include <graze/lib/flow/general_flow.hpp>
#include <graze/lib/flow/hertz_flow.hpp>
#include <graze/lib/flow/linear_flow.hpp>

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <variant>

namespace graze {

void validate(const FlowOptions& options) {
  const auto require = [](bool good, const char* name, double value, const char* allowed) {
    if (!good) throw std::invalid_argument(fmt::format("flow option {} is {}; allowed is {}", name, value, allowed));
  };
  require(options.tolerance > 0.0 && std::isfinite(options.tolerance), "tolerance", options.tolerance, "> 0");
  require(options.max_step >= 0.0, "max_step", options.max_step, ">= 0");
  require(options.accumulation_window >= 0.0, "accumulation_window", options.accumulation_window, ">= 0");
}

struct Flow::Kind {
  std::size_t mode;
  std::variant<LinearFlow, HertzFlow, CubicFlow, GeneralFlow> flow;
};

Flow::Flow(std::unique_ptr<Kind> kind) : kind_(std::move(kind)) {}
Flow::Flow(Flow&&) noexcept = default;
Flow& Flow::operator=(Flow&&) noexcept = default;
Flow::~Flow() = default;

void Flow::carry(const FlowTask& task, const Vector& x0, Segment& out) {
  out.mode = kind_->mode;
  std::visit([&](auto& flow) { flow.carry(task, x0, out); }, kind_->flow);
}

void Flow::field(double t, const Vector& x, Vector& out) const {
  std::visit([&](const auto& flow) { flow.field(t, x, out); }, kind_->flow);
}

const char* Flow::kind() const {
  switch (kind_->flow.index()) {
  case 0:
    return "closed form";
  case 1:
    return "regularised Hertz contact";
  case 2:
    return "Taylor series";
  default:
    return "general";
  }
}

Flow make_flow(const SharedSystem& system, std::size_t mode, const Vector& p, std::span<const std::size_t> active,
               const FlowOptions& options) {
  const Mode& description = system->modes[mode];
  if (options.kind != FlowKind::general && description.structure) {
    const ModeStructure structure = description.structure(p);
    if (const auto* linear = std::get_if<LinearOscillator>(&structure);
        linear && LinearFlow::applies(system, mode, active, *linear))
      return Flow(
          std::make_unique<Flow::Kind>(Flow::Kind{mode, LinearFlow(system, mode, p, active, *linear, options.max_steps)}));
    if (const auto* cubic = std::get_if<CubicOscillator>(&structure); cubic && CubicFlow::applies(system, mode))
      return Flow(std::make_unique<Flow::Kind>(Flow::Kind{mode, CubicFlow(system, mode, p, active, *cubic, options)}));
    if (const auto* hertz = std::get_if<HertzContact>(&structure); hertz && HertzFlow::applies(system, mode, *hertz))
      return Flow(std::make_unique<Flow::Kind>(Flow::Kind{mode, HertzFlow(system, mode, active, *hertz, options)}));
  }
  return Flow(std::make_unique<Flow::Kind>(Flow::Kind{mode, GeneralFlow(system, mode, p, active, options)}));
}

}  // namespace graze
