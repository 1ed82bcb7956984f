// SPDX-License-Identifier: GPL-3.0-or-later
// Systems as text for tests. Each piece is on a separate line of one source "system.toml", so that error places can be tested.
#pragma once

#include <graze/lib/equations/system_text.hpp>
#include <graze/lib/models/oscillator.hpp>

#include <fmt/format.h>

#include <algorithm>

namespace graze::support {

struct EventStrings {
  std::string name, kind, when, reset, from, to;
};

class SystemWriter {
 public:
  equations::SystemText system;

  SystemWriter() { system.source.file = "system.toml"; }

  /// The piece, on the next line of the source.
  equations::Text write(const std::string& piece) {
    std::string& text = system.source.text;
    const auto line = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + 1;
    text += piece + "\n";
    return {piece, {line, 1, equations::characters(piece)}};
  }
  SystemWriter& states(const std::vector<std::string>& names) {
    for (const std::string& name : names) system.states.push_back(write(name));
    return *this;
  }
  SystemWriter& forcing(const std::string& name) {
    system.forcing = write(name);
    return *this;
  }
  SystemWriter& parameter(const std::string& name, const std::string& value) {
    system.parameters.push_back({.name = write(name), .value = write(value)});
    return *this;
  }
  SystemWriter& parameter(const ParameterInfo& info) {
    parameter(info.name, fmt::format("{}", info.default_value));
    equations::ParameterText& text = system.parameters.back();
    if (std::isfinite(info.lower)) (info.lower_open ? text.above : text.min) = write(fmt::format("{}", info.lower));
    if (std::isfinite(info.upper)) text.max = write(fmt::format("{}", info.upper));
    text.unit = info.unit;
    text.meaning = info.meaning;
    return *this;
  }
  SystemWriter& definition(const std::string& name, const std::string& value) {
    system.definitions.push_back({write(name), write(value)});
    return *this;
  }
  SystemWriter& mode(const std::string& name, const std::string& equations) {
    system.modes.push_back({write(name), write(equations)});
    return *this;
  }
  SystemWriter& event(const EventStrings& strings) {
    equations::EventText text;
    text.name = write(strings.name);
    if (!strings.kind.empty()) text.kind = write(strings.kind);
    if (!strings.from.empty()) text.from = write(strings.from);
    if (!strings.to.empty()) text.to = write(strings.to);
    text.when = write(strings.when);
    if (!strings.reset.empty()) text.reset = write(strings.reset);
    system.events.push_back(std::move(text));
    return *this;
  }
  using Rows = std::vector<std::vector<std::string>>;
  struct Matrices {
    Rows mass, damping = {}, stiffness = {};
    std::vector<std::string> force = {};
  };
  SystemWriter& mechanics(const std::vector<std::string>& coordinates, const std::vector<std::string>& velocities,
                          const Matrices& matrices) {
    equations::MechanicsText text;
    text.place = write("[mechanics]").place;
    for (const std::string& name : coordinates) text.coordinates.push_back(write(name));
    for (const std::string& name : velocities) text.velocities.push_back(write(name));
    const auto matrix = [&](const Rows& rows) {
      std::vector<std::vector<equations::Text>> out;
      for (const auto& row : rows) {
        out.emplace_back();
        for (const std::string& entry : row) out.back().push_back(write(entry));
      }
      return out;
    };
    text.mass = matrix(matrices.mass);
    text.damping = matrix(matrices.damping);
    text.stiffness = matrix(matrices.stiffness);
    for (const std::string& entry : matrices.force) text.force.push_back(write(entry));
    system.mechanics = std::move(text);
    return *this;
  }
  SystemWriter& stop(const std::string& name, const std::string& gap, const std::string& law,
                     const std::vector<std::string>& values, bool adhesion = false) {
    equations::StopText text{write(name), write(gap), write(law), {}, adhesion};
    for (const std::string& value : values) text.values.push_back(write(value));
    system.stops.push_back(std::move(text));
    return *this;
  }
  SystemWriter& friction(const std::string& name, const std::string& speed, const std::string& normal, const std::string& law,
                         const std::string& sticking = "") {
    equations::FrictionText text{write(name), write(speed), write(normal), write(law), {}};
    if (!sticking.empty()) text.sticking = write(sticking);
    system.friction.push_back(std::move(text));
    return *this;
  }
  SystemWriter& surface(const std::string& function, const std::string& below, const std::string& above,
                        const std::string& sliding = "") {
    equations::SurfaceText text{write(function), write(below), write(above), {}};
    if (!sliding.empty()) text.sliding = write(sliding);
    system.surfaces.push_back(std::move(text));
    return *this;
  }
  SystemWriter& output(const std::string& name, const std::string& value) {
    system.outputs.push_back({write(name), write(value)});
    return *this;
  }
  SystemWriter& start(const std::string& state, const std::string& value) {
    system.start.push_back({write(state), write(value)});
    return *this;
  }
};

/// The parameters of a built-in oscillator with their ranges.
inline void write_parameters(SystemWriter& writer, const OscillatorKind& kind, const ContactLaw& law) {
  writer.system.name = kind.name + "-" + law.name;
  writer.forcing("eta");
  for (ParameterInfo info : oscillator_parameters()) {
    if (info.name == "beta") info.default_value = kind.beta;
    writer.parameter(info);
  }
  for (const ParameterInfo& info : law.parameters) writer.parameter(info);
}

/// The message of the mistake in a text; "none" if there is none.
inline std::string mistake(const equations::SystemText& text) {
  try {
    equations::make_system(text);
  } catch (const equations::EquationError& error) {
    return error.sentence();
  }
  return "none";
}

/// Largest difference relative to the size of the numbers.
inline double distance(const Matrix& a, const Matrix& b) {
  return (a - b).lpNorm<Eigen::Infinity>() / (1.0 + a.lpNorm<Eigen::Infinity>());
}

/// The value of a function; an empty function has the value zero.
inline Vector evaluate(const VectorFunction& f, double t, const Vector& x, const Vector& p, Eigen::Index size) {
  Vector out = Vector::Zero(size);
  if (f) f(t, x, p, out);
  return out;
}
inline Matrix evaluate(const MatrixFunction& f, double t, const Vector& x, const Vector& p, Eigen::Index columns) {
  Matrix out = Matrix::Zero(x.size(), columns);
  if (f) f(t, x, p, out);
  return out;
}

/// A built-in oscillator (make_oscillator) as a user would write it.
inline equations::SystemText oscillator_text(const OscillatorKind& kind, const ContactLaw& law) {
  SystemWriter writer;
  writer.states({"x", "v"});
  write_parameters(writer, kind, law);
  writer.definition("acceleration", "xi*cos(eta*t) - 2*b*v - x - beta*x*x*x");
  writer.mode("free", "x' = v\nv' = acceleration");
  if (law.name == "newton") {
    writer.event({"impact", "impact", "x - r", "v = -k_r*v", "", ""});
  } else {
    writer.mode("contact", law.name == "hertz" ? "x' = v\nv' = acceleration - k_H*(x - r)^(3/2)*(1 + b_H*v)"
                                               : "x' = v\nv' = acceleration - k_S*(x - r)");
    writer.event({"enter", "enter", "x - r", "", "free", "contact"});
    writer.event({"leave", "leave", "r - x", "", "contact", "free"});
  }
  return writer.system;
}

/// The same as mechanics: one mass, one stop.
inline equations::SystemText oscillator_mechanics(const OscillatorKind& kind, const ContactLaw& law) {
  SystemWriter writer;
  write_parameters(writer, kind, law);
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {{"2*b"}}, {{"1"}}, {"xi*cos(eta*t) - beta*x^3"}});
  std::vector<std::string> values;
  for (const ParameterInfo& info : law.parameters) values.push_back(info.name);
  writer.stop("wall", "r - x", law.name, values);
  return writer.system;
}

/// A Duffing oscillator between two rigid stops at -r and r.
inline equations::SystemText duffing_text() {
  SystemWriter writer;
  writer.system.name = "duffing";
  writer.states({"x", "v"}).forcing("eta");
  writer.parameter("b", "0.05").parameter("A", "0.6").parameter("eta", "0.8").parameter("beta", "1/2").parameter("r", "0.6");
  writer.parameter("k_r", "0.8").parameter("xi", "A*eta^2");
  writer.definition("spring", "x + beta*x^3");
  writer.mode("free", "x' = v\nv' = xi*cos(eta*t) - 2*b*v - spring");
  writer.event({"right", "impact", "x - r", "v = -k_r*v", "", ""});
  writer.event({"left", "impact", "-x - r", "v = -k_r*v", "", ""});
  writer.output("energy", "v^2/2 + x^2/2 + beta*x^4/4").output("power", "energy'");
  writer.start("x", "0.3").start("v", "0.1");
  return writer.system;
}

}  // namespace graze::support
