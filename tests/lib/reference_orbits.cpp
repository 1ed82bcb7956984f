// SPDX-License-Identifier: GPL-3.0-or-later
// Every orbit of data/reference.toml (quadruple precision, independent), carried over its period by the library. It must
// return, with the reference's impacts and monodromy matrix. There is no shooting: the motion itself is compared.
#include "support/checks.hpp"

#include <graze/lib/models/oscillator.hpp>

#include <toml++/toml.h>

using namespace graze;
using namespace graze::support;

namespace {

std::vector<double> doubles(const toml::array& list) {
  std::vector<double> values;
  for (const toml::node& node : list) values.push_back(*node.value<double>());
  return values;
}

/// Checks one orbit with one kind of flow.
void check_orbit(const toml::table& entry, FlowKind kind) {
  const toml::table& values = *entry["parameters"].as_table();
  const bool cubic = *values["beta"].value<double>() != 0.0;
  const HybridSystem system = make_oscillator(cubic ? "cantilever" : "linear", *entry["contact"].value<std::string>());
  Vector p = default_parameters(system.parameters);
  for (const auto& [name, value] : values)
    p[static_cast<Eigen::Index>(parameter_index(system.parameters, name.str()))] = *value.value<double>();
  if (const auto digits = entry["eta_digits"].value<std::string>()) p[oscillator_parameter::eta] = std::stod(*digits);
  const auto period = *entry["period"].value<int>();
  const std::vector<double> state = doubles(*entry["state"].as_array()), times = doubles(*entry["impact_times"].as_array()),
                            speeds = doubles(*entry["impact_speeds"].as_array());
  Propagator propagator(system, p, {}, {.kind = kind});
  Transition transition;
  const Vector x0 = vector({state[0], state[1]});
  carry(propagator, 0.0, period * forcing_period(system, p), x0, {.keep_events = true}, transition);
  REQUIRE(transition.termination == Termination::time);
  // An error of 1e-14 on the way (rounding of the start or of an event time) grows by the largest of the partial products. 1e3
  // bounds them over the longest of these orbits (24 periods).
  const double grown = 2e-13 * (1.0 + 20.0 * period);
  REQUIRE((transition.x1 - x0).norm() < grown);
  std::size_t impact = 0;
  for (const EventRecord& event : transition.events) {
    if (event.kind != EventKind::impact && event.kind != EventKind::enter) continue;
    REQUIRE(impact < times.size());
    REQUIRE(std::abs(event.t - times[impact]) < grown / speeds[impact]);
    REQUIRE(std::abs(event.normal_speed - speeds[impact]) < 3.0 * grown / speeds[impact]);
    ++impact;
  }
  REQUIRE(impact == times.size());
  const toml::array& rows = *entry["monodromy"].as_array();
  Matrix M(2, 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const std::vector<double> row = doubles(*rows[i].as_array());
    M.row(static_cast<Eigen::Index>(i)) << row[0], row[1];
  }
  REQUIRE((transition.Phi - M).norm() < 20.0 * grown * (1.0 + M.norm()) / *std::min_element(speeds.begin(), speeds.end()));
}

}  // namespace

TEST_CASE("every reference orbit returns with its impacts and monodromy matrix by the fast flows and by the general one") {
  const toml::table file = toml::parse_file(GRAZE_DATA_DIR "/reference.toml");
  int orbits = 0;
  for (const char* list : {"orbit", "special_point"}) {
    for (const toml::node& node : *file[list].as_array()) {
      const toml::table& entry = *node.as_table();
      for (const FlowKind kind : {FlowKind::automatic, FlowKind::general}) {
        INFO(*entry["name"].value<std::string>() << (kind == FlowKind::general ? ", general flow" : ""));
        check_orbit(entry, kind);
      }
      ++orbits;
    }
  }
  REQUIRE(orbits > 40);
}
