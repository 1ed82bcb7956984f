// SPDX-License-Identifier: GPL-3.0-or-later
// Contacts interpolated from a table against the same contacts integrated in steps, and motions in lanes with and without the
// table.
#include "support/checks.hpp"
#include "support/lane_widths.hpp"

#include <graze/lib/flow/flow.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/lane_carrier.hpp>

#include <catch2/catch.hpp>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <memory>
#include <random>

using namespace graze;
using namespace graze::support;

namespace {

Vector hertz_parameters(double eta, double b_H) {
  const HybridSystem system = make_oscillator("linear", "hertz");
  Vector p = default_parameters(system.parameters);
  p[static_cast<Eigen::Index>(parameter_index(system.parameters, "eta"))] = eta;
  p[static_cast<Eigen::Index>(parameter_index(system.parameters, "b_H"))] = b_H;
  return p;
}

std::vector<MotionStart> random_starts(std::size_t count, double r) {
  std::mt19937_64 generator(11);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<MotionStart> starts;
  for (std::size_t i = 0; i < count; ++i) starts.push_back({0, r - 3.0 * unit(generator), 3.0 * unit(generator) - 1.5});
  return starts;
}

}  // namespace

TEST_CASE("contacts from a table agree with contacts integrated in steps") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const auto [eta, b_H] = GENERATE(table<double, double>({{0.711, 0.1}, {0.93, 0.0}}));
  const Vector p = hertz_parameters(eta, b_H);
  const double r = p[oscillator_parameter::r], T = forcing_period(system, p);
  const ContactTable contacts(system, p, {0.13, 0.9});
  CHECK(contacts.report().covered == 1.0);
  CHECK(contacts.report().covered_begun > 0.95);
  const Event& entry = system.events[0];
  Flow flow = make_flow(system, entry.to, p, {}, {.tolerance = 1e-14});
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Segment exact;
  double value = 0.0, tangent = 0.0, volume = 0.0;
  for (int k = 0; k < 300; ++k) {
    const double t = T * unit(generator), v = 0.125 + 0.875 * unit(generator);
    const auto contact = contacts.at(t, v);
    REQUIRE(contact);
    flow.carry({.t0 = t, .t_end = t + T, .sensitivity = Sensitivity::state}, vector({r, v}), exact);
    REQUIRE(exact.end == FlowEnd::event);
    value = std::max({value, std::abs(contact->duration - (exact.t1 - t)), std::abs(contact->v - exact.x1[1]),
                      std::abs(contact->divergence - exact.divergence)});
    for (std::size_t i = 0; i < 4; ++i)
      tangent = std::max(
          tangent, std::abs(contact->Phi[i] - exact.Phi(static_cast<Eigen::Index>(i) / 2, static_cast<Eigen::Index>(i) % 2)) /
                       (1.0 + exact.Phi.norm()));
    const auto& Phi = contact->Phi;
    volume = std::max(volume, std::abs(std::log(Phi[0] * Phi[3] - Phi[1] * Phi[2]) - contact->divergence));
  }
  // The stated errors of the table, 1e-13 and 1e-11, plus that of the steps.
  CHECK(value < 3e-13);
  CHECK(tangent < 2e-11);
  // The determinant is a difference of products of size |Phi|^2 ~ 100.
  CHECK(volume < 1e-9);
}

TEST_CASE("motions in lanes agree with and without a table") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const auto [eta, b_H] = GENERATE(table<double, double>({{0.711, 0.1}, {0.7114, 0.0}, {0.93, 0.1}}));
  const Vector p = hertz_parameters(eta, b_H);
  const ContactTable contacts(system, p, {0.04, 1.9});
  constexpr std::size_t periods = 40;
  LaneCarrier with(system), without(system);
  with.use(with.add_parameters(p), std::make_shared<const ContactTable>(contacts));
  without.add_parameters(p);
  const auto starts = random_starts(60, p[oscillator_parameter::r]);
  std::vector<PeriodResult> results, single;
  with.carry(starts, periods, true, results);
  double state = 0.0, tangent = 0.0, volume = 0.0;
  int impacts = 0, compared = 0;
  for (std::size_t k = 0; k < periods; ++k) {
    // The same period from the same states.
    std::vector<MotionStart> again = starts;
    for (std::size_t m = 0; k > 0 && m < starts.size(); ++m)
      again[m] = {0, results[m * periods + k - 1].x, results[m * periods + k - 1].v};
    without.carry(again, 1, true, single);
    for (std::size_t m = 0; m < starts.size(); ++m) {
      const PeriodResult &a = results[m * periods + k], &b = single[m];
      REQUIRE(a.termination == b.termination);
      double size = 1.0;
      for (const double one : b.Phi) size = std::max(size, 1.0 + std::abs(one));
      state = std::max(state, std::hypot(a.x - b.x, a.v - b.v) / size);
      for (std::size_t i = 0; i < 4; ++i) tangent = std::max(tangent, std::abs(a.Phi[i] - b.Phi[i]) / (size * size));
      volume = std::max(volume, std::abs(a.liouville - b.liouville));
      // If a contact begins exactly at the end of a period, its impact may count in either period.
      impacts += a.impacts != b.impacts ? 1 : 0;
      compared += b.impacts;
    }
  }
  CHECK(state < 1e-12);
  CHECK(tangent < 1e-11);
  CHECK(volume < 1e-12);
  CHECK(impacts == 0);
  CHECK(compared > 500);
}

TEST_CASE("near grazing the table leaves weak contacts to the lanes") {
  // Periods with a contact slower than the slowest of the table are compared with the Propagator.
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = hertz_parameters(0.711, 0.1);
  constexpr double slowest = 0.25;
  const ContactTable contacts(system, p, {slowest, 1.9});
  LaneCarrier many(system);
  many.use(many.add_parameters(p), std::make_shared<const ContactTable>(contacts));
  const auto starts = random_starts(40000, p[oscillator_parameter::r]);
  std::vector<PeriodResult> results;
  many.carry(starts, 1, true, results);
  Propagator propagator(system, p);
  Transition one;
  double state = 0.0, tangent = 0.0, weakest = 1.0;
  int weak = 0;
  for (std::size_t m = 0; m < starts.size(); ++m) {
    carry(propagator, 0.0, forcing_period(system, p), vector({starts[m].x, starts[m].v}),
          {.sensitivity = Sensitivity::state, .keep_events = true}, one);
    const auto slow = std::find_if(one.events.begin(), one.events.end(), [](const EventRecord& event) {
      return begins_contact(event.kind) && event.normal_speed < slowest;
    });
    if (slow == one.events.end()) continue;
    ++weak;
    weakest = std::min(weakest, slow->normal_speed);
    int entries = 0;
    for (const EventRecord& event : one.events) entries += begins_contact(event.kind) ? 1 : 0;
    REQUIRE(results[m].termination == Termination::time);
    CHECK(results[m].impacts == entries);
    const double size = 1.0 + one.Phi.norm();
    state = std::max(state, std::hypot(results[m].x - one.x1[0], results[m].v - one.x1[1]) / size);
    for (Eigen::Index i = 0; i < 4; ++i)
      tangent = std::max(tangent, std::abs(results[m].Phi[static_cast<std::size_t>(i)] - one.Phi(i / 2, i % 2)) / (size * size));
  }
  CHECK(weak > 300);
  CHECK(weakest < 1e-2);
  CHECK(state < 1e-12);
  CHECK(tangent < 1e-11);
}

TEST_CASE("with a table lanes of any width give identical bits") {
  const auto widths = GENERATE(widths_of_processor, plain_widths);
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = hertz_parameters(0.711, 0.1);
  std::vector<PeriodResult> reference, results;
  for (const LaneWidth width : widths) {
    if (!available(width)) continue;
    const ContactTable contacts(system, p, {0.25, 1.9}, width);
    LaneCarrier many(system, {}, width);
    many.use(many.add_parameters(p), std::make_shared<const ContactTable>(contacts));
    many.carry(random_starts(61, 2.0), 20, true, results);
    if (reference.empty()) reference = results;
    CHECK(same_bits(results, reference));
  }
}

TEST_CASE("a table of contacts has identical bits for any number of threads") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = hertz_parameters(0.711, 0.1);
  std::vector<std::shared_ptr<const ContactTable>> tables;
  for (const int threads : {1, 4})
    oneapi::tbb::task_arena(threads).execute([&] {
      tables.push_back(std::make_shared<const ContactTable>(system, p, SpeedRange{0.25, 1.9}));
    });
  CHECK(tables[0]->report().pieces == tables[1]->report().pieces);
  CHECK(tables[0]->report().contacts == tables[1]->report().contacts);
  std::vector<PeriodResult> one, several;
  for (std::size_t i = 0; i < 2; ++i) {
    LaneCarrier many(system);
    many.use(many.add_parameters(p), tables[i]);
    many.carry(random_starts(61, 2.0), 20, true, i == 0 ? one : several);
  }
  CHECK(same_bits(one, several));
}

TEST_CASE("a table of contacts covers the speeds of motions on all threads") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const auto starts = random_starts(64, 2.0);
  std::vector<PeriodResult> results, one;
  for (const int threads : {1, 4})
    oneapi::tbb::task_arena(threads).execute([&] {
      LaneCarrier many(system);
      many.use_all_threads();
      many.add_parameters(hertz_parameters(0.711, 0.1));
      CHECK_FALSE(many.awaits_table(0));
      many.expect(0, LaneCarrier::periods_for_table);
      CHECK(many.awaits_table(0));
      many.carry(starts, LaneCarrier::periods_between_looks, false, results);
      CHECK_FALSE(many.awaits_table(0));
      REQUIRE(many.table(0) != nullptr);
      many.carry(starts, 20, true, results);  // with the table
      if (one.empty()) one = results;
      CHECK(same_bits(results, one));
    });
}

TEST_CASE("a table of contacts is made for many periods only") {
  const HybridSystem system = make_oscillator("linear", "hertz"), hard = make_oscillator("linear", "newton");
  const Vector p = hertz_parameters(0.711, 0.1);
  const auto starts = random_starts(64, 2.0);
  std::vector<PeriodResult> results;
  const auto table_after = [&](std::int64_t periods, double tolerance) {
    LaneCarrier many(system, {.tolerance = tolerance});
    many.add_parameters(p);
    many.expect(0, periods);
    many.carry(starts, 200, false, results);
    return many.table(0) != nullptr;
  };
  CHECK(table_after(LaneCarrier::periods_for_table, 1e-13));
  CHECK_FALSE(table_after(LaneCarrier::periods_for_table - 1, 1e-13));
  CHECK_FALSE(table_after(LaneCarrier::periods_for_table, 1e-14));
  LaneCarrier many(hard);
  many.add_parameters(default_parameters(hard.parameters));
  many.expect(0, 10 * LaneCarrier::periods_for_table);
  many.carry({{0, 0.0, 0.5}}, 10, false, results);
  CHECK(many.table(0) == nullptr);
}

TEST_CASE("the cases without a table of contacts are reported") {
  const HybridSystem system = make_oscillator("linear", "hertz"), hard = make_oscillator("linear", "newton");
  const Vector p = hertz_parameters(0.711, 0.1);
  CHECK(ContactTable::applies(system, p));
  CHECK_FALSE(ContactTable::applies(hard, default_parameters(hard.parameters)));
  CHECK_THROWS_WITH(ContactTable(hard, default_parameters(hard.parameters), {0.5, 1.0}),
                    Catch::Contains("linear oscillator with a Hertz stop"));
  for (const SpeedRange wrong : {SpeedRange{0.0, 1.0}, SpeedRange{1.0, 0.5}, SpeedRange{1.0, 1e9}, SpeedRange{NAN, 1.0}})
    CHECK_THROWS_WITH(ContactTable(system, p, wrong), Catch::Contains("are allowed"));
  const ContactTable contacts(system, p, {0.6, 0.7});
  CHECK(contacts.at(0.0, 0.5));
  CHECK_FALSE(contacts.at(0.0, 0.499));
  CHECK_FALSE(contacts.at(0.0, 1.0));
  CHECK_FALSE(contacts.at(-1e-9, 0.6));
  CHECK_FALSE(contacts.at(forcing_period(system, p), 0.6));
  CHECK_FALSE(contacts.at(0.0, NAN));
  CHECK_FALSE(contacts.at(0.0, -0.6));
  LaneCarrier many(system);
  many.add_parameters(hertz_parameters(0.72, 0.1));
  CHECK_THROWS_WITH(many.use(0, std::make_shared<const ContactTable>(contacts)), Catch::Contains("not one of parameter set 0"));
  CHECK_THROWS_WITH(many.expect(1, 10), Catch::Contains("1 were added"));
}
