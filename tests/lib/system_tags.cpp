// SPDX-License-Identifier: GPL-3.0-or-later
// The tags of a system (levels, rebounds, continuity, structure) agree with its functions, for any coordinate and mass.
#include "support/checks.hpp"
#include "support/two_mass_oscillator.hpp"

#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/trajectory.hpp>
#include <graze/lib/motion/transition.hpp>

using namespace graze;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

std::size_t index_of(const HybridSystem& system, const char* name) { return parameter_index(system.parameters, name); }

/// The two masses with rebounds instead of explicit resets.
HybridSystem with_rebounds() {
  HybridSystem system = two_mass_oscillator();
  const std::size_t k_r = index_of(system, "k_r");
  const std::size_t levels[2] = {index_of(system, "r1"), index_of(system, "r2")};
  for (std::size_t mass : {0, 1}) {
    system.events[mass].guard = make_level_guard({.coordinate = 2 * mass, .level = levels[mass], .sign = 1.0});
    system.events[mass].reset =
        make_rebound({.coordinate = 2 * mass, .velocity = 2 * mass + 1, .level = levels[mass], .coefficient = k_r});
  }
  return system;
}

}  // namespace

TEST_CASE("a rebound moves the coordinate and the velocity that it names") {
  const HybridSystem written = two_mass_oscillator(), rebounds = with_rebounds();
  const Vector p = parameters(written, {{"xi", 1.4}, {"r1", 0.6}, {"r2", 0.5}});
  const double T = forcing_period(written, p);
  const std::vector<std::size_t> active{index_of(written, "r2"), index_of(written, "k_r")};
  Propagator a(written, p, active), b(rebounds, p, active);
  Transition as_written, by_rebounds;
  const Vector x0 = vector({0.1, 0.8, -0.2, 0.5});
  const TransitionOptions options{.sensitivity = Sensitivity::state_and_parameters};
  carry(a, 0.0, 2.0 * T, x0, options, as_written);
  carry(b, 0.0, 2.0 * T, x0, options, by_rebounds);
  REQUIRE(by_rebounds.event_sequence.size() > 3);
  REQUIRE(by_rebounds.event_sequence == as_written.event_sequence);
  CHECK((by_rebounds.x1 - as_written.x1).norm() < 1e-12);
  CHECK((by_rebounds.Phi - as_written.Phi).norm() < 1e-10);
  CHECK((by_rebounds.Psi - as_written.Psi).norm() < 1e-10);
}

TEST_CASE("validate refuses a tag that contradicts its function") {
  const HybridSystem good = with_rebounds();
  REQUIRE_NOTHROW(validate(good));
  HybridSystem system = good;
  system.events[1].reset.rebound->velocity = 1;
  CHECK_THROWS_WITH(validate(system), Contains("the rebound given for event impact-2 is not its reset"));
  system = good;
  system.events[1].reset.map = [](double, const Vector&, const Vector&, Vector& out) { out[3] = -out[3]; };
  CHECK_THROWS_WITH(validate(system), Contains("the rebound given for event impact-2 is not its reset"));
  system = good;
  system.events[1].reset.rebound->coordinate = 0;
  CHECK_THROWS_WITH(validate(system), Contains("event impact-2 rebounds at another level than its guard watches"));
  system = good;
  system.events[0].guard.level->sign = -1.0;
  CHECK_THROWS_WITH(validate(system), Contains("the level given for event impact-1 is not that of its guard"));
  system = good;
  system.events[0].continuous = true;
  CHECK_THROWS_WITH(validate(system), Contains("event impact-1 is called continuous, but state or field jumps at its guard"));
  HybridSystem oscillator = make_oscillator("linear", "hertz");
  const MatrixFunction dx = oscillator.modes[0].field_dx;
  const VectorFunction field = oscillator.modes[0].field;
  oscillator.modes[0].field = [field](double t, const Vector& x, const Vector& p, Vector& f) {
    field(t, x, p, f);
    f[1] -= 0.1 * x[0] * x[0];
  };
  CHECK_THROWS_WITH(validate(oscillator), Contains("the structure given for mode free is not that of its field"));
}

TEST_CASE("the energy lost in a contact is that of the mass at the barrier") {
  HybridSystem system = with_rebounds();
  const auto mu = static_cast<Eigen::Index>(index_of(system, "mu"));
  system.events[1].effective_mass = [mu](double, const Vector&, const Vector& p) { return p[mu]; };
  const Vector p = parameters(system, {{"xi", 1.4}, {"r1", 0.6}, {"r2", 0.5}});
  const Trajectory run = simulate(system, p, 0.0, vector({0.1, 0.8, -0.2, 0.5}), {.t_end = 3.0 * forcing_period(system, p)});
  const std::vector<Contact> list = contacts(run.events);
  REQUIRE(list.size() == run.events.size());
  int of_second = 0;
  for (std::size_t k = 0; k < list.size(); ++k) {
    const double mass = run.events[k].event == 1 ? p[mu] : 1.0;
    const Eigen::Index velocity = run.events[k].event == 1 ? 3 : 1;
    const double in = run.events[k].x_minus[velocity], out = run.events[k].x_plus[velocity];
    CHECK(list[k].energy_lost == Approx(0.5 * mass * (in * in - out * out)).epsilon(1e-12));
    of_second += run.events[k].event == 1 ? 1 : 0;
  }
  CHECK(of_second > 0);
}

TEST_CASE("the flow alone carries Newton's law flight by flight too") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = default_parameters(system.parameters);
  CHECK(Propagator(system, p).one_lane() != nullptr);
  CHECK(Propagator(system, p, {}, {.kind = FlowKind::alone}).one_lane() == nullptr);
}
