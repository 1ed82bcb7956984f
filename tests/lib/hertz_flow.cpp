// SPDX-License-Identifier: GPL-3.0-or-later
// The regularised Hertz contact: reference contacts in quadruple precision, order of convergence in state and event time, and
// the order lost without regularisation.
#include "support/checks.hpp"
#include "support/extrapolation.hpp"
#include "support/runge_kutta8.hpp"

#include <graze/lib/flow/flow.hpp>
#include <graze/lib/flow/hertz_series.hpp>
#include <graze/lib/models/oscillator.hpp>

#include <toml++/toml.h>

using namespace graze;
using namespace graze::support;

namespace {

enum : Eigen::Index { b, beta, xi, eta, r, k_H, b_H };

/// One contact from x = r at t0 with the given speed, to its end.
Segment one_contact(const HybridSystem& system, const Vector& p, double t0, double speed, const FlowOptions& options = {}) {
  Flow flow = make_flow(system, 1, p, {}, options);
  Segment segment;
  flow.carry({t0, t0 + 50.0, Sensitivity::none}, vector({p[r], speed}), segment);
  return segment;
}

/// (y, v, t) as functions of s: an independent copy of the regularised equations (DESIGN).
template <class Number> auto regularised(const Vector& p) {
  return [=](const std::array<Number, 3>& z, std::array<Number, 3>& dz) {
    const Number y = z[0], v = z[1], x = Number(p[r]) + y * y;
    const Number f = Number(p[xi]) * std::cos(Number(p[eta]) * z[2]) - 2 * Number(p[b]) * v - x - Number(p[beta]) * x * x * x;
    dz[0] = v / 2;
    dz[1] = y * (f - Number(p[k_H]) * y * y * y * (1 + Number(p[b_H]) * v));
    dz[2] = y;
  };
}

struct Exit {
  double t, v, s;
};

/// A contact with fixed steps h of rk8_step. Newton's method on the length of the last step makes it end at y = 0.
Exit fixed_step_contact(const Vector& p, double speed, double h) {
  const auto field = regularised<double>(p);
  detail::Stage<3> z{0.0, speed, 0.0}, k1, next, error;
  for (double s = 0.0;; s += h, z = next) {
    field(z, k1);
    detail::rk8_step<3>(field, z, k1, h, next, error);
    if (next[0] > 0.0) continue;
    double part = h;
    for (int i = 0; i < 20; ++i) {
      detail::rk8_step<3>(field, z, k1, part, next, error);
      part -= next[0] / (0.5 * next[1]);
    }
    detail::rk8_step<3>(field, z, k1, part, next, error);
    return {next[2], next[1], s + part};
  }
}

Vector damped_hertz(double barrier = 2.0) {
  return parameters(make_oscillator("linear", "hertz"), {{"b_H", 0.1}, {"eta", 0.925}, {"r", barrier}});
}

double order(double coarse, double fine, double ratio = 2.0) { return std::log(coarse / fine) / std::log(ratio); }

}  // namespace

TEST_CASE("single Hertz contacts reproduce the reference exit speed and exit time within 1e-12") {
  const toml::table file = toml::parse_file(GRAZE_DATA_DIR "/reference.toml");
  const toml::array* list = file["contact"].as_array();
  REQUIRE(list != nullptr);
  int compared = 0;
  for (const toml::node& node : *list) {
    const toml::table& entry = *node.as_table();
    if (*entry["contact_force_only"].value<bool>()) continue;  // not a system of this library
    const HybridSystem system = make_oscillator("linear", *entry["contact"].value<std::string>());
    Vector p = default_parameters(system.parameters);
    for (const auto& [name, value] : *entry["parameters"].as_table())
      p[static_cast<Eigen::Index>(parameter_index(system.parameters, name.str()))] = *value.value<double>();
    const double t0 = *entry["entry_time"].value<double>();
    for (const FlowKind kind : {FlowKind::automatic, FlowKind::general}) {
      const Segment contact = one_contact(system, p, t0, *entry["entry_speed"].value<double>(), {.kind = kind});
      INFO(*entry["name"].value<std::string>() << (kind == FlowKind::general ? ", general flow" : ""));
      REQUIRE(contact.end == FlowEnd::event);
      REQUIRE(std::abs(contact.x1[1] - *entry["exit_speed"].value<double>()) < 1e-12);
      REQUIRE(std::abs(contact.t1 - t0 - *entry["duration"].value<double>()) < 1e-12);
      ++compared;
    }
  }
  REQUIRE(compared >= 8);
}

TEST_CASE("the regularised contact has order 8 in the exit speed and in the exit time") {
  for (const double speed : {1.5, 0.4}) {
    for (const double barrier : {2.0, 0.5}) {
      const Vector p = damped_hertz(barrier);
      const Exit exact = fixed_step_contact(p, speed, 0.01);
      // Steps that divide the contact into 8, 16, 32. With more steps the errors reach rounding.
      const double S = exact.s;
      const Exit coarse = fixed_step_contact(p, speed, S / 8), middle = fixed_step_contact(p, speed, S / 16),
                 fine = fixed_step_contact(p, speed, S / 32);
      INFO("speed " << speed << ", r " << barrier);
      INFO("speed errors " << coarse.v - exact.v << " " << middle.v - exact.v << " " << fine.v - exact.v);
      INFO("time errors " << coarse.t - exact.t << " " << middle.t - exact.t << " " << fine.t - exact.t);
      CHECK(order(std::abs(coarse.v - exact.v), std::abs(fine.v - exact.v), 4.0) > 7.5);
      CHECK(order(std::abs(coarse.t - exact.t), std::abs(fine.t - exact.t), 4.0) > 7.5);
      CHECK(std::abs(middle.v - exact.v) < 1e-8);  // and the errors are in the range of convergence
    }
  }
}

TEST_CASE("the series of a contact has order 16 in motion and tangent with cubic stiffness and damping") {
  // Reference: the equations of DESIGN in (y, v, t), and dPhi/ds = y A Phi in (x, v). They share no formula with the series.
  HertzContact contact;
  contact.value = {0.07, 36.0 / 35.0, 1.1, 0.8, 0.6, 90.0, 0.15};
  const Vector p = vector({contact.value[0], contact.value[1], contact.value[2], contact.value[3], contact.value[4],
                           contact.value[5], contact.value[6]});
  using Number = long double;
  const auto motion = regularised<Number>(p);
  const auto field = [&](Number, const LongState<7>& z, LongState<7>& dz) {
    std::array<Number, 3> dyvt;
    motion({z[0], z[1], z[2]}, dyvt);
    std::copy(dyvt.begin(), dyvt.end(), dz.begin());
    const Number y = z[0], x = p[r] + y * y, give = 1 + p[b_H] * z[1];
    const Number f_x = -1 - 3 * p[beta] * x * x - Number(1.5) * p[k_H] * y * give, f_v = -2 * p[b] - p[k_H] * y * y * y * p[b_H];
    for (std::size_t column = 3; column < 7; column += 2) {
      dz[column] = y * z[column + 1];
      dz[column + 1] = y * (f_x * z[column] + f_v * z[column + 1]);
    }
  };
  const double y0 = 0.25, v0 = 0.4, t0 = 0.3;
  const auto speed_coefficient = [&](double y) { return 2.0 * p[b] + p[k_H] * p[b_H] * y * y * y; };
  const std::vector<std::size_t> none;
  for (const detail::SeriesKernels* kernels : {&detail::series_generic, &detail::series_kernels()}) {
    detail::HertzSeries<1> series(contact, none, t0, *kernels);
    detail::HertzState<1> z;
    z.y = y0;
    z.v = v0;
    z.cosine = std::cos(p[eta] * t0);
    z.sine = std::sin(p[eta] * t0);
    z.dx[0] = z.q[1] = 1.0;
    z.q[0] = speed_coefficient(y0);
    series.expand(z);
    std::array<std::array<double, 7>, 2> error{};
    for (std::size_t i = 0; i < 2; ++i) {
      const double h = i == 0 ? 0.4 : 0.2;
      const LongState<7> exact = extrapolate<7>(field, 0, h, {y0, v0, t0, 1, 0, 0, 1});
      const detail::HertzState<1> end = series.at(h);
      const auto dv = [&](std::size_t k) { return end.q[k] - speed_coefficient(end.y) * end.dx[k]; };
      const std::array<double, 7> found{end.y, end.v, t0 + end.time, end.dx[0], dv(0), end.dx[1], dv(1)};
      for (std::size_t k = 0; k < 7; ++k) error[i][k] = static_cast<double>(std::abs(found[k] - exact[k]));
      CHECK(series.depth(h) == Approx(end.y).epsilon(1e-14));
      CHECK(series.speed(h) == Approx(end.v).epsilon(1e-14));
      CHECK(series.time(h) == Approx(end.time).epsilon(1e-14));
    }
    for (std::size_t k = 0; k < 7; ++k) {
      INFO("quantity " << k << ": errors " << error[0][k] << " " << error[1][k]);
      CHECK(error[0][k] > 1e-13);                      // above rounding, so that the order shows
      CHECK(error[1][k] < error[0][k] / 3e4 + 1e-14);  // at least 2^15
    }
  }
}

TEST_CASE("the series of a contact agree to rounding on any processor and with more columns") {
  HertzContact contact;
  contact.value = {0.07, 36.0 / 35.0, 1.1, 0.8, 0.6, 90.0, 0.15};
  const std::vector<std::size_t> none, all{0, 1, 2, 3, 4, 5, 6, HertzContact::count};
  detail::HertzSeries<0> bare(contact, none, 0.3);
  detail::HertzSeries<1> generic(contact, none, 0.3, detail::series_generic), best(contact, none, 0.3);
  detail::HertzSeries<3> generic_all(contact, all, 0.3, detail::series_generic), best_all(contact, all, 0.3);
  Random random(7);
  for (int i = 0; i < 100; ++i) {
    std::array<double, 7> start;
    for (double& one : start) one = random(-1.0, 1.0);
    start[0] = std::abs(start[0]);
    const double h = random(0.0, 0.2);
    const auto end = [&](auto& series) {
      typename std::remove_reference_t<decltype(series)>::State z;
      z.y = start[0];
      z.v = start[1];
      z.cosine = std::cos(start[2]);
      z.sine = std::sin(start[2]);
      for (std::size_t k = 0; k < 2; ++k) {
        z.dx[k] = start[3 + k];
        z.q[k] = start[5 + k];
      }
      series.expand(z);
      const auto out = series.at(h);
      std::vector<double> numbers{out.y,    out.v,     out.time,  out.divergence, out.cosine,
                                  out.sine, out.dx[0], out.dx[1], out.q[0],       out.q[1]};
      numbers.insert(numbers.end(), out.dx + 2, std::end(out.dx));
      numbers.insert(numbers.end(), out.q + 2, std::end(out.q));
      return numbers;
    };
    // Sums of 17 terms, with sums of products that have coefficients of some hundreds.
    const auto agree = [](const std::vector<double>& a, const std::vector<double>& b, std::size_t count) {
      double most = 0.0;
      for (std::size_t k = 0; k < count; ++k) most = std::max(most, std::abs(a[k] - b[k]) / (1.0 + std::abs(a[k])));
      return most < 5e-14;
    };
    const std::vector<double> found = end(best), more = end(best_all);
    REQUIRE(agree(found, end(generic), 10));
    REQUIRE(agree(more, end(generic_all), more.size()));
    REQUIRE(agree(found, more, 10));
    REQUIRE(agree(found, end(bare), 6));
    REQUIRE(more[17] == 0.0);  // in a parameter that does not enter the contact
  }
}

TEST_CASE("the regularised contact keeps its accuracy through exit: an error in the root enters squared") {
  // dt/ds = y and dv/ds ~ y vanish at y = 0: an error d of the root moves time and speed only by d^2.
  const Vector p = damped_hertz();
  const auto field = regularised<double>(p);
  const Exit exact = fixed_step_contact(p, 1.0, 0.05);
  detail::Stage<3> z{0.0, 1.0, 0.0}, k1, next, error;
  const int steps = 40;
  for (int i = 0; i < steps; ++i) {
    field(z, k1);
    detail::rk8_step<3>(field, z, k1, exact.s / steps, next, error);
    z = next;
  }
  field(z, k1);
  for (const double d : {1e-3, 1e-5}) {
    detail::rk8_step<3>(field, z, k1, d, next, error);
    CHECK(std::abs(next[2] - exact.t) < d * d);
    CHECK(std::abs(next[1] - exact.v) < 5.0 * d * d);
  }
}

TEST_CASE("without regularisation a method of order 4 or 8 loses its order at the entry into contact") {
  // x'' = -k_H max(0, x)^(3/2), entered at speed 1 in the middle of a step: the error falls as h^(5/2) for any method.
  constexpr double k = 100.0, D = 0.2;
  const auto field = [](const detail::Stage<2>& z, detail::Stage<2>& dz) {
    const double y = std::sqrt(std::max(0.0, z[0]));
    dz = {z[1], -k * y * y * y};
  };
  // Exact solution: from (0, 1) by extrapolation in s, up to the s where t = D.
  const auto in_s = [](long double, const LongState<3>& z, LongState<3>& dz) {
    dz = {z[1] / 2, -static_cast<long double>(k) * z[0] * z[0] * z[0] * z[0], z[0]};
  };
  LongState<3> exact{0.0L, 1.0L, 0.0L};
  exact = extrapolate<3>(in_s, 0.0L, 0.8L, exact);
  for (int i = 0; i < 8; ++i) exact = extrapolate<3>(in_s, 0.0L, (static_cast<long double>(D) - exact[2]) / exact[0], exact);
  const auto rk4 = [&](const detail::Stage<2>& z, double h) {
    detail::Stage<2> k1, k2, k3, k4, w;
    const auto at = [&](const detail::Stage<2>& slope, double c) {
      return detail::Stage<2>{z[0] + c * h * slope[0], z[1] + c * h * slope[1]};
    };
    field(z, k1);
    field(at(k1, 0.5), k2);
    field(at(k2, 0.5), k3);
    field(at(k3, 1.0), k4);
    for (std::size_t i = 0; i < 2; ++i) w[i] = z[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
    return w;
  };
  const auto rk8 = [&](const detail::Stage<2>& z, double h) {
    detail::Stage<2> k1, next, error;
    field(z, k1);
    detail::rk8_step<2>(field, z, k1, h, next, error);
    return next;
  };
  const auto error_with = [&](const auto& method, int n) {
    detail::Stage<2> z{-D, 1.0};
    const double h = 2.0 * D / (2 * n + 1);  // contact begins in the middle of step n, counted from 0
    for (int i = 0; i < 2 * n + 1; ++i) z = method(z, h);
    return std::abs(z[1] - static_cast<double>(exact[1]));
  };
  const double lost4 = order(error_with(rk4, 100), error_with(rk4, 1600), 3201.0 / 201.0);
  const double lost8 = order(error_with(rk8, 100), error_with(rk8, 1600), 3201.0 / 201.0);
  CHECK(lost4 > 2.2);
  CHECK(lost4 < 2.8);
  CHECK(lost8 > 2.2);
  CHECK(lost8 < 2.8);
}

TEST_CASE("the errors of state and exit time of the contact flow fall in proportion to the tolerance") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  for (const double speed : {1.5, 0.2, 1e-3}) {
    const Vector p = damped_hertz();
    const Segment exact = one_contact(system, p, 0.3, speed, {.tolerance = 1e-15});
    for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
      const Segment contact = one_contact(system, p, 0.3, speed, {.tolerance = tolerance});
      INFO("speed " << speed << ", tolerance " << tolerance);
      // A few steps, each within the tolerance. One contact amplifies their errors little.
      CHECK(std::abs(contact.t1 - exact.t1) < 5.0 * tolerance + 1e-15);
      CHECK(std::abs(contact.x1[1] - exact.x1[1]) < 20.0 * tolerance + 2e-15);
    }
    const Segment loose = one_contact(system, p, 0.3, speed, {.tolerance = 1e-4});
    if (speed > 0.1) CHECK(loose.evaluations < exact.evaluations / 2);  // a weak contact has few steps at any tolerance
  }
}

TEST_CASE("a contact of any weakness is detected") {
  // A mass that leaves rest on the barrier with a small speed v stays in contact for 2 v/|a|, to first order in v.
  const HybridSystem system = make_oscillator("linear", "hertz");
  for (double speed = 1e-1; speed > 1e-13; speed /= 10.0) {
    const Vector p = damped_hertz();
    const Segment contact = one_contact(system, p, 0.0, speed);
    INFO("speed " << speed);
    REQUIRE(contact.end == FlowEnd::event);
    REQUIRE(contact.t1 > 0.0);
    if (speed < 1e-2) REQUIRE(contact.t1 == Approx(2.0 * speed / 1.0).epsilon(0.02 + 30.0 * std::sqrt(speed)));
    REQUIRE(-contact.x1[1] == Approx(speed).epsilon(0.1));
  }
}

TEST_CASE("contacts of extreme stiffness and speed are integrated") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  for (const double stiffness : {1e-2, 1.0, 1e4, 1e6, 1e9}) {
    for (const double speed : {1e-6, 1e-2, 1.0, 10.0}) {
      const Vector p = parameters(system, {{"k_H", stiffness}, {"eta", 0.925}});
      const Segment fast = one_contact(system, p, 0.0, speed),
                    general = one_contact(system, p, 0.0, speed, {.kind = FlowKind::general});
      INFO("k_H " << stiffness << ", speed " << speed);
      REQUIRE(fast.end == FlowEnd::event);
      REQUIRE(general.end == FlowEnd::event);
      REQUIRE(std::abs(fast.t1 - general.t1) < 1e-11);
      REQUIRE(std::abs(fast.x1[1] - general.x1[1]) < 1e-11 * (1.0 + speed));
    }
  }
}

TEST_CASE("from rest on the barrier the derivatives of the contact agree with differences") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"r", 0.5}, {"xi", 1.2}, {"eta", 0.8}, {"b_H", 0.1}});
  const std::vector<std::size_t> active = all_parameters(system);
  Flow fast = make_flow(system, 1, p, active), general = make_flow(system, 1, p, active, {.kind = FlowKind::general});
  Segment one, other;
  const FlowTask task{0.0, 0.3, Sensitivity::state_and_parameters};
  fast.carry(task, vector({0.5, 0.0}), one);
  general.carry(task, vector({0.5, 0.0}), other);
  REQUIRE(one.end == FlowEnd::time);
  REQUIRE(other.end == FlowEnd::time);
  REQUIRE((one.x1 - other.x1).norm() < 1e-12);
  REQUIRE((one.Phi - other.Phi).norm() < 1e-11);
  REQUIRE((one.Psi - other.Psi).norm() < 1e-11);
  REQUIRE(std::abs(one.divergence - other.divergence) < 1e-12);
}
