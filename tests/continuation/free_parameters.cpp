// SPDX-License-Identifier: GPL-3.0-or-later
// Orbit equations with two free parameters: their derivatives agree with central differences and with the equations in one
// parameter, every conversion of an orbit keeps both values, and with one condition more they give curves in two parameters.
#include <graze/continuation/conditions/grazing.hpp>
#include <graze/continuation/conditions/multiplier_equations.hpp>
#include <graze/continuation/conditions/test_function.hpp>
#include <graze/continuation/problems/signature_problem.hpp>
#include <graze/continuation/trace/trace.hpp>

#include "support/checks.hpp"
#include "support/damped_hertz.hpp"
#include "support/newton_oscillator.hpp"
#include "support/van_der_pol_stop.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <vector>

using namespace graze;
using namespace graze::support;

namespace {

using Parameters = std::vector<FreeParameter>;

/// An orbit, and its equations for any list of free parameters.
struct OrbitCase {
  const char* name;
  const HybridSystem* system;
  Vector p;
  Vector orbit;  ///< the unknowns without the parameters
  std::function<std::unique_ptr<BranchProblem>(const Parameters& free)> problem;

  FreeParameter free(const char* parameter) const { return {parameter_index(system->parameters, parameter), 0.5}; }
  Vector unknowns(const Parameters& free) const {
    Vector u(orbit.size() + std::ssize(free));
    u.head(orbit.size()) = orbit;
    for (std::size_t i = 0; i < free.size(); ++i)
      u[orbit.size() + static_cast<Eigen::Index>(i)] = p[static_cast<Eigen::Index>(free[i].index)];
    return u;
  }
};

OrbitCase in_states(const char* name, const HybridSystem& system, const Vector& p, const PeriodicOrbit& orbit) {
  REQUIRE(orbit.converged());
  const int nodes = static_cast<int>(orbit.nodes.size());
  const auto make = [&system, p, orbit, nodes](const Parameters& free) {
    auto problem = std::make_unique<OrbitProblem>(system, p, orbit.period, nodes, free, FlowOptions{}, orbit.section_phase);
    if (problem->equations().autonomous()) problem->equations().set_phase_reference(orbit.nodes.front());
    return problem;
  };
  const Vector u = make({{0, 1.0}})->pack(orbit.nodes, orbit.duration, p[0]);
  return {name, &system, p, u.head(u.size() - 1), make};
}

OrbitCase by_events(const char* name, const HybridSystem& system, const Vector& p, const PeriodicOrbit& orbit) {
  REQUIRE(orbit.converged());
  const EventNodes nodes = event_nodes(orbit).value();
  const auto make = [&system, p, nodes, period = orbit.period](const Parameters& free) {
    return std::make_unique<SignatureProblem>(system, p, period, nodes.sequence, free);
  };
  const Vector u = make({{0, 1.0}})->pack(nodes, p[0]);
  return {name, &system, p, u.head(u.size() - 1), make};
}

PeriodicOrbit newton_orbit(const OneImpactParameters& q, int nodes) {
  return shoot(newton_oscillator(), parameters_of(q), one_impact_orbits(q, 1).front().states(), 1, {.nodes = nodes});
}

PeriodicOrbit limit_cycle(const HybridSystem& system, const Vector& p) {
  const Trajectory run = simulate(system, p, 0.0, Vector{{0.1, 0.0}}, {.t_end = 40.0});
  const double duration = run.events.back().t - run.events[run.events.size() - 2].t;
  return shoot(system, p, std::vector<Vector>{run.x}, 1, {.nodes = 2}, duration);
}

constexpr OneImpactParameters impacting{.b = 0.05, .xi = 1.0, .eta = 0.97, .r = 2.0, .k_r = 0.9};

std::vector<OrbitCase> cases() {
  static const HybridSystem autonomous = van_der_pol_stop();
  const Vector p = parameters(autonomous, {{"k_r", 0.8}}), hertz = hertz_parameters(), newton = parameters_of(impacting);
  return {in_states("damped Hertz", damped_hertz(), hertz, shoot(damped_hertz(), hertz, Vector{{1.5, 1.5}}, 1, {.nodes = 3})),
          in_states("Newton", newton_oscillator(), newton, newton_orbit(impacting, 2)),
          by_events("Newton, by events", newton_oscillator(), newton, newton_orbit(impacting, 1)),
          in_states("van der Pol", autonomous, p, limit_cycle(autonomous, p))};
}

/// Two parameters of the case, of which one is its forcing frequency if it is forced.
Parameters two_of(const OrbitCase& c) {
  const bool forced = is_forced(*c.system);
  return {c.free(forced ? "eta" : "mu"), c.free(c.system == &damped_hertz() ? "k_H" : "k_r")};
}

struct Evaluated {
  Vector residual;
  Matrix jacobian;
};

Evaluated evaluated(BranchProblem& problem, const Vector& u) {
  Evaluated out;
  REQUIRE(problem.zero_problem().evaluate(u, out.residual, &out.jacobian));
  return out;
}

double residual_at(BranchProblem& problem, const Vector& u) {
  REQUIRE(u.size() == problem.unknowns());
  return evaluated(problem, u).residual.lpNorm<Eigen::Infinity>();
}

}  // namespace

TEST_CASE("the Jacobian in two free parameters agrees with central differences, and with that in one parameter") {
  for (const OrbitCase& c : cases()) {
    const Parameters two = two_of(c);
    const auto problem = c.problem(two);
    const Vector u = c.unknowns(two);
    const Eigen::Index size = c.orbit.size();
    INFO(c.name);
    REQUIRE(problem->unknowns() == size + 2);
    CHECK(problem->orbit_unknowns() == size);
    CHECK(problem->parameter() == two.front().index);
    CHECK(problem->value(u) == u[size]);
    const Evaluated here = evaluated(*problem, u);
    REQUIRE(here.residual.size() == size);
    REQUIRE(here.jacobian.cols() == size + 2);
    CHECK(here.residual.lpNorm<Eigen::Infinity>() < 1e-11);
    const auto f = [&](const Vector& at) { return evaluated(*problem, at).residual; };
    const JacobianCheck result = check_jacobian(f, u, here.jacobian, 1e-4);
    INFO(result.message);
    CHECK(result.agrees(1e-8));
    for (std::size_t i = 0; i < 2; ++i) {
      INFO(c.system->parameters[two[i].index].name);
      const auto single = c.problem({two[i]});
      const Evaluated alone = evaluated(*single, c.unknowns({two[i]}));
      Evaluated same = here;
      same.jacobian.col(size) = here.jacobian.col(size + static_cast<Eigen::Index>(i));
      same.jacobian.conservativeResize(size, size + 1);
      if (i == 0 || is_forced(*c.system)) {
        CHECK(alone.residual == same.residual);
        CHECK(alone.jacobian == same.jacobian);
      } else {
        // The general integrator of the van der Pol case chooses its steps by the derivative in mu too.
        CHECK((alone.residual - same.residual).lpNorm<Eigen::Infinity>() < 1e-13);
        CHECK((alone.jacobian - same.jacobian).lpNorm<Eigen::Infinity>() < 1e-12);
      }
    }
  }
}

TEST_CASE("the derivative of the cyclic matrix in two free parameters agrees with the change of the matrix") {
  for (const OrbitCase& c : cases()) {
    const Parameters two = two_of(c);
    const auto problem = c.problem(two);
    const Vector u = c.unknowns(two);
    INFO(c.name);
    evaluated(*problem, u);
    const Eigen::Index rows = problem->cyclic(u, -1.0).rows();
    const Eigen::VectorXcd left = Vector::LinSpaced(rows, 0.3, 1.0).cast<std::complex<double>>();
    const Eigen::VectorXcd right = Vector::LinSpaced(rows, 1.0, -0.4).cast<std::complex<double>>();
    const Eigen::VectorXcd derivative = problem->cyclic_derivative(u, -1.0, left, right);
    REQUIRE(derivative.size() == u.size());
    const auto form = [&](const Vector& at) {
      evaluated(*problem, at);
      return Vector::Constant(1, left.dot(problem->cyclic(at, -1.0) * right).real());
    };
    const JacobianCheck result = check_jacobian(form, u, derivative.real().transpose(), 1e-4);
    INFO(result.message);
    CHECK(result.agrees(1e-5));  // the derivative itself is by differences
  }
}

TEST_CASE("at the end of a parameter's range the cyclic matrix is differentiated to one side") {
  const auto derivative_at = [](double k_r, bool events) {
    OneImpactParameters q = impacting;
    q.k_r = k_r;
    const Vector p = parameters_of(q);
    const OrbitCase c = events ? by_events("by events", newton_oscillator(), p, newton_orbit(q, 1))
                               : in_states("in states", newton_oscillator(), p, newton_orbit(q, 2));
    const auto problem = c.problem({c.free("k_r")});
    const Vector u = c.unknowns(problem->free());
    evaluated(*problem, u);
    const Eigen::Index rows = problem->cyclic(u, -1.0).rows();
    const Eigen::VectorXcd left = Vector::LinSpaced(rows, 0.3, 1.0).cast<std::complex<double>>();
    const Eigen::VectorXcd right = Vector::LinSpaced(rows, 1.0, -0.4).cast<std::complex<double>>();
    return problem->cyclic_derivative(u, -1.0, left, right)[problem->orbit_unknowns()].real();
  };
  REQUIRE(newton_oscillator().parameters[parameter_index(newton_oscillator().parameters, "k_r")].upper == 1.0);
  for (const bool events : {false, true}) {
    INFO(events);
    const double at_end = derivative_at(1.0, events), inside = derivative_at(1.0 - 1e-5, events);
    REQUIRE(std::abs(inside) > 0.1);
    CHECK(std::abs(at_end - inside) < 1e-3 * std::abs(inside));
  }
}

TEST_CASE("every other form of an orbit equation keeps all free parameters") {
  for (const OrbitCase& c : cases()) {
    const Parameters two = two_of(c);
    const auto problem = c.problem(two);
    Vector u = c.unknowns(two);
    INFO(c.name);
    const auto same_list = [&](const BranchProblem& other) {
      REQUIRE(other.free().size() == 2);
      for (std::size_t i = 0; i < 2; ++i) {
        CHECK(other.free()[i].index == two[i].index);
        CHECK(other.free()[i].scale == two[i].scale);
      }
    };
    const Vector weights = problem->zero_problem().weights;
    CHECK(weights.tail(2) == Vector::Constant(2, 4.0));  // 1 / scale^2
    const BranchProblem::Doubled doubled = problem->doubled(u);
    same_list(*doubled.problem);
    CHECK(doubled.u.tail(2) == u.tail(2));
    CHECK(residual_at(*doubled.problem, doubled.u) < 1e-11);
    const auto finer = problem->with_half_steps();
    same_list(*finer);
    CHECK(residual_at(*finer, u) < 1e-11);
    Vector v;
    OrbitProblem& states = problem->stroboscopic(u, v);
    same_list(states);
    CHECK(v.tail(2) == u.tail(2));
    CHECK(residual_at(states, v) < 1e-10);
    if (is_forced(*c.system)) {
      OrbitProblem moved = states.with_section(0.45);
      same_list(moved);
      const Vector there = states.to_section(moved, v).value();
      CHECK(there.tail(2) == u.tail(2));
      CHECK(residual_at(moved, there) < 1e-10);
    }
    OrbitProblem more = states.with_nodes(2);
    same_list(more);
    more.equations().set_phase_reference(states.equations().node(v, 0));
    CHECK(residual_at(more, states.to_nodes(more, v).value()) < 1e-10);
    // Another forcing period gives the same orbit: its image moves with the forcing period, of which eta is a parameter.
    const Vector tangent = Vector::LinSpaced(u.size(), 0.2, 0.7);
    const double h = 1e-6;
    const auto ahead = problem->images(u + h * tangent, tangent), behind = problem->images(u - h * tangent, tangent);
    const auto images = problem->images(u, tangent);
    CHECK(images.size() == (problem->sequence() ? 3 : 1));
    for (std::size_t i = 0; i < images.size(); ++i) {
      CHECK(residual_at(*problem, images[i].u) < 1e-10);
      CHECK(((ahead[i].u - behind[i].u) / (2.0 * h) - images[i].tangent).lpNorm<Eigen::Infinity>() < 1e-7);
    }
  }
}

TEST_CASE(
    "a list of free parameters that has none, one twice or an unknown one is refused, and so is the wrong number of values") {
  const HybridSystem& system = newton_oscillator();
  const Vector p = parameters_of(impacting);
  const Parameters two{{oscillator_parameter::eta, 1.0}, {oscillator_parameter::r, 1.0}};
  const auto refused = [](const auto& make) { CHECK_THROWS_AS(make(), std::invalid_argument); };
  for (const Parameters& wrong :
       {Parameters{}, Parameters{two[0], two[1], two[0]}, Parameters{{system.parameters.size(), 1.0}}}) {
    refused([&] { return OrbitProblem(system, p, 1, 1, wrong); });
    refused([&] { return SignatureProblem(system, p, 1, {0}, wrong); });
  }
  OrbitProblem problem(system, p, 1, 1, two);
  const Vector x{{1.0, 1.0}};
  refused([&] { return problem.pack({x}, 0.0, 0.97); });
  refused([&] { return SignatureProblem(system, p, 1, {0}, two).pack({{0}, {0.2}, {x}}, 0.97); });
  // A bifurcation is a point in one parameter only.
  const Vector u = problem.pack({x}, 0.0, Vector{{0.97, 2.0}});
  refused([&] { return locate(problem, *multiplier_equations({.theta = std::numbers::pi}), u); });
}

namespace {

/// The largest difference between the Jacobian and central differences of F at w, relative to its rows.
double jacobian_error(BranchProblem& problem, DefiningEquations& equations, const Vector& w) {
  constexpr double h = 1e-6;
  Vector F, ahead, behind;
  Matrix jacobian;
  REQUIRE(equations.evaluate(problem, w, F, &jacobian));
  REQUIRE(F.size() == equations.sizes().size());
  REQUIRE(jacobian.rows() == F.size());
  REQUIRE(jacobian.cols() == w.size());
  Matrix differences = jacobian;
  for (Eigen::Index i = 0; i < w.size(); ++i) {
    REQUIRE(equations.evaluate(problem, w + h * Vector::Unit(w.size(), i), ahead, nullptr));
    REQUIRE(equations.evaluate(problem, w - h * Vector::Unit(w.size(), i), behind, nullptr));
    differences.col(i) = (ahead - behind) / (2.0 * h);
  }
  const Vector rows = jacobian.rowwise().lpNorm<Eigen::Infinity>().cwiseMax(1.0);
  return (rows.cwiseInverse().asDiagonal() * (jacobian - differences)).lpNorm<Eigen::Infinity>();
}

}  // namespace

TEST_CASE("the Jacobians of the equations of bifurcations in two free parameters agree with central differences") {
  for (const OrbitCase& c : cases()) {
    INFO(c.name);
    const Parameters two = two_of(c);
    const auto problem = c.problem(two);
    const Vector u = c.unknowns(two);
    std::vector<std::unique_ptr<DefiningEquations>> all;
    for (const double theta : {0.0, std::numbers::pi}) all.push_back(multiplier_equations({.theta = theta}));
    all.push_back(multiplier_equations({.theta = 1.1, .theta_free = true}));
    all.push_back(branch_point_test().equations({CurvePoint{}, BranchPoint{}}));
    for (const auto& equations : all) {
      INFO("equations " << &equations - all.data());
      CHECK(jacobian_error(*problem, *equations, start_of(*equations, u)) < 1e-6);
    }
  }
}

namespace {

/// The period doubling in eta of orbits with one impact near these parameters.
OneImpactParameters period_doubling_near(OneImpactParameters q) {
  OrbitProblem problem(newton_oscillator(), parameters_of(q), 1, 1, oscillator_parameter::eta, 0.1);
  const Vector start = problem.pack(newton_orbit(q, 1).nodes, 0.0, q.eta);
  const LocatedPoint located = locate(problem, *multiplier_equations({.theta = std::numbers::pi}), start);
  REQUIRE(located.newton.converged());
  q.eta = problem.value(located.u);
  return q;
}

}  // namespace

TEST_CASE("in two free parameters the equations of a period doubling define a curve") {
  const HybridSystem& system = newton_oscillator();
  const std::size_t eta = oscillator_parameter::eta, k_r = parameter_index(system.parameters, "k_r");
  OneImpactParameters q = period_doubling_near({.b = 0.05, .xi = 1.0, .eta = 0.977, .r = 2.0, .k_r = 0.9});
  const PeriodicOrbit orbit = newton_orbit(q, 1);
  const OrbitCase coordinates[] = {in_states("in states", system, parameters_of(q), orbit),
                                   by_events("by events", system, parameters_of(q), orbit)};
  for (const OrbitCase& c : coordinates) {
    INFO(c.name);
    const Parameters two{{eta, 0.1}, {k_r, 0.5}};
    const auto problem = c.problem(two);
    const Vector start = c.unknowns(two);
    const Eigen::Index size = c.orbit.size();
    const Vector to_smaller_k_r = -Vector::Unit(size + 2, size + 1);
    const std::unique_ptr<DefiningEquations> doubling = multiplier_equations({.theta = std::numbers::pi});
    const Curve curve = trace(curve_of(*problem, *doubling), start_of(*doubling, start), to_smaller_k_r,
                              {.initial_step = 0.05, .max_step = 0.1, .max_points = 8});
    INFO(curve.failure);
    REQUIRE(curve.stop == TraceStop::point_limit);
    CHECK(curve.points.back().u[size + 1] < 0.75);
    for (const CurvePoint& point : curve.points) {
      q.eta = problem->value(point.u);
      q.k_r = problem->values(point.u)[1];
      INFO("eta = " << q.eta << ", k_r = " << q.k_r);
      // By the closed form: the orbit there has the multiplier -1.
      const OneImpactOrbit closed = one_impact_orbits(q, 1).front();
      CHECK(closed.admissible());
      CHECK(std::abs(closed.multipliers[0] + 1.0) < 1e-10);
      // Located in eta alone at this k_r, from beside it.
      OneImpactParameters beside = q;
      beside.eta += 1e-3;
      CHECK(std::abs(period_doubling_near(beside).eta - q.eta) < 1e-11);
    }
  }
}

TEST_CASE("in two free parameters the equations of a grazing define a curve") {
  // The orbit without impacts touches the barrier where its amplitude equals r.
  const HybridSystem& system = newton_oscillator();
  OneImpactParameters q{.b = 0.05, .xi = 1.0, .eta = 0.7, .r = 2.0, .k_r = 0.9};
  q.r = impactless_amplitude(q);
  const Parameters two{{oscillator_parameter::eta, 0.1}, {oscillator_parameter::r, 0.5}};
  OrbitProblem problem(system, parameters_of(q), 1, 2, two);
  OneImpactParameters below = q;
  below.r += 1e-3;
  const PeriodicOrbit orbit = shoot(system, parameters_of(below), Vector::Zero(2), 1, {.nodes = 2});
  REQUIRE(orbit.converged());
  const Vector start = problem.pack(orbit.nodes, 0.0, Vector{{below.eta, below.r}});
  const std::optional<GrazingGuess> guess = nearest_miss(problem, start);
  REQUIRE(guess);
  const std::unique_ptr<DefiningEquations> grazing = grazing_equations(*guess);
  const Vector w = start_of(*grazing, start);
  CHECK(jacobian_error(problem, *grazing, w) < 1e-6);
  const Curve curve = trace(curve_of(problem, *grazing), w, Vector::Unit(w.size(), problem.orbit_unknowns()),
                            {.initial_step = 0.05, .max_step = 0.1, .max_points = 8});
  INFO(curve.failure);
  REQUIRE(curve.stop == TraceStop::point_limit);
  CHECK(std::abs(curve.points.back().u[problem.orbit_unknowns()] - q.eta) > 0.01);
  for (const CurvePoint& point : curve.points) {
    const Vector values = point.u.segment(problem.orbit_unknowns(), 2);
    q.eta = values[0];
    INFO("eta = " << values[0]);
    CHECK(std::abs(impactless_amplitude(q) - values[1]) < 1e-11);
  }
}
