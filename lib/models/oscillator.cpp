// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/models/oscillator.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

namespace graze {

using namespace oscillator_parameter;

const std::vector<ParameterInfo>& oscillator_parameters() {
  static const std::vector<ParameterInfo> list = [] {
    const double infinity = std::numeric_limits<double>::infinity();
    std::vector<ParameterInfo> p(law);
    p[b] = {"b", 0.05, 0.0, infinity, false, "dimensionless", "damping ratio, c / (2 sqrt(k m))"};
    p[beta] = {"beta", 0.0, -infinity, infinity, false, "dimensionless", "cubic stiffness (36/35 for the cantilever)"};
    p[xi] = {"xi", 1.0, -infinity, infinity, false, "dimensionless", "forcing amplitude"};
    p[eta] = {"eta", 0.95, 0.0, infinity, true, "dimensionless", "forcing frequency over the natural one; T = 2 pi / eta"};
    p[r] = {"r", 2.0, -infinity, infinity, false, "dimensionless", "clearance: the barrier is at x = r"};
    return p;
  }();
  return list;
}

const std::vector<OscillatorKind>& oscillator_kinds() {
  static const std::vector<OscillatorKind> list = {
      {"linear", "x'' + 2 b x' + x + F = xi cos(eta tau)", 0.0},
      {"cantilever", "x'' + 2 b x' + x + beta x^3 + F = xi cos(eta tau), beta = 36/35", 36.0 / 35.0},
  };
  return list;
}

const OscillatorKind& oscillator_kind(std::string_view name) {
  std::vector<std::string> names;
  for (const OscillatorKind& kind : oscillator_kinds()) {
    if (kind.name == name) return kind;
    names.push_back(kind.name);
  }
  throw std::invalid_argument(unknown_name("oscillator", name, names));
}

double barrier_acceleration(double t, const Vector& p) {
  return p[xi] * std::cos(p[eta] * t) - p[r] - p[beta] * p[r] * p[r] * p[r];
}

namespace {

/// Part of a text without a place in a file: errors in a law that a program passes are reported at 1:1.
equations::Text piece(std::string text) { return {std::move(text), {}}; }

equations::ParameterText parameter_text(const ParameterInfo& info) {
  equations::ParameterText text{.name = piece(info.name), .value = piece(fmt::format("{}", info.default_value))};
  const auto bound = [](double value) {
    return std::isfinite(value) ? std::optional(piece(fmt::format("{}", value))) : std::nullopt;
  };
  (info.lower_open ? text.above : text.min) = bound(info.lower);
  text.max = bound(info.upper);
  text.unit = info.unit;
  text.meaning = info.meaning;
  return text;
}

}  // namespace

equations::TextSystem read_oscillator(const OscillatorKind& kind, const ContactLaw& law) {
  return read_oscillator(kind, law, {}, {});
}

equations::TextSystem read_oscillator(const OscillatorKind& kind, const ContactLaw& law, const std::vector<ParameterInfo>& added,
                                      const std::vector<equations::Definition>& tied) {
  equations::SystemText text;
  text.name = kind.name + "-" + law.name;
  for (const ParameterInfo& info : oscillator_parameters()) text.parameters.push_back(parameter_text(info));
  text.parameters[beta].value = piece(fmt::format("{}", kind.beta));
  for (const ParameterInfo& info : law.parameters) text.parameters.push_back(parameter_text(info));
  for (const ParameterInfo& info : added) text.parameters.push_back(parameter_text(info));
  bool own_frequency = true;
  for (const equations::Definition& one : tied) {
    const auto parameter = std::find_if(text.parameters.begin(), text.parameters.end(),
                                        [&](const equations::ParameterText& p) { return p.name.text == one.name.text; });
    if (parameter != text.parameters.end())
      parameter->value = one.value;
    else
      text.parameters.push_back({.name = one.name, .value = one.value});
    if (one.name.text == "eta") own_frequency = false;
  }
  (own_frequency ? text.forcing : text.period) = piece(own_frequency ? "eta" : "2*pi/eta");
  text.mechanics = equations::MechanicsText{.coordinates = {piece("x")},
                                            .velocities = {piece("v")},
                                            .mass = {{piece("1")}},
                                            .damping = {{piece("2*b")}},
                                            .stiffness = {{piece("1")}},
                                            .force = {piece("xi*cos(eta*t) - beta*x^3")}};
  equations::StopText stop{.name = piece("barrier"), .gap = piece("r - x"), .law = piece(law.stop), .values = {}};
  for (const std::string& value : law.values) stop.values.push_back(piece(value));
  text.stops.push_back(std::move(stop));

  equations::TextSystem out = equations::make_system(text);
  // There is one stop: modes and events need no stop name.
  out.system.modes.back().name = law.hard ? "held" : "contact";
  for (Event& event : out.system.events) event.name = event_kind_name(event.kind);
  return out;
}

HybridSystem make_oscillator(const OscillatorKind& kind, const ContactLaw& law) { return read_oscillator(kind, law).system; }

Vector steady_response(const Vector& p) {
  const double w = p[eta], stiffness = 1.0 - w * w, damping = 2.0 * p[b] * w;
  return p[xi] / (stiffness * stiffness + damping * damping) * Vector{{stiffness, damping * w}};
}

}  // namespace graze
