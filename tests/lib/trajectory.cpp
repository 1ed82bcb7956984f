// SPDX-License-Identifier: GPL-3.0-or-later
// Trajectories: the sequence of segments and events, sampling, contacts, and the termination of a run.
#include "support/checks.hpp"

#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/transition.hpp>

#include <memory>
#include <set>
#include <utility>

using namespace graze;
using namespace graze::support;

namespace {

/// A run with several contacts for every law.
Trajectory run_with_contacts(const HybridSystem& system, const Vector& p, double t_end = 40.0) {
  return simulate(system, p, 0.3, vector({0.1, 0.9}), {.t_end = t_end});
}

Vector parameters_with_contacts(const HybridSystem& system) { return parameters(system, {{"r", 0.4}, {"eta", 0.8}}); }

template <class Test> void for_each_system(const Test& test) {
  for (const OscillatorKind& kind : oscillator_kinds()) {
    for (const ContactLaw& law : contact_laws()) {
      const HybridSystem system = make_oscillator(kind, law);
      INFO(system.name);
      test(system, law);
    }
  }
}

}  // namespace

TEST_CASE("the segments of a run join in time, state and mode with one event between each two") {
  for_each_system([](const HybridSystem& system, const ContactLaw& law) {
    const Vector p = parameters_with_contacts(system);
    const Trajectory run = run_with_contacts(system, p);
    REQUIRE(run.termination == Termination::time);
    REQUIRE(run.events.size() > 6);
    REQUIRE(run.segments.size() == run.events.size() + 1);
    REQUIRE(run.segments.front().t0 == 0.3);
    REQUIRE(run.segments.back().t1 == 40.0);
    REQUIRE(run.t == 40.0);
    REQUIRE(run.x == run.segments.back().x1);
    for (std::size_t i = 0; i < run.events.size(); ++i) {
      const EventRecord& event = run.events[i];
      const Segment &before = run.segments[i], &after = run.segments[i + 1];
      REQUIRE(before.end == FlowEnd::event);
      REQUIRE(before.event == event.event);
      REQUIRE(before.t1 == event.t);
      REQUIRE(after.t0 == event.t);
      REQUIRE(before.x1 == event.x_minus);
      REQUIRE(after.x0 == event.x_plus);
      REQUIRE(before.mode == system.events[event.event].from);
      REQUIRE(after.mode == event.mode_plus);
      REQUIRE(event.x_minus[0] == p[oscillator_parameter::r]);  // exactly on the barrier
      REQUIRE(event.normal_speed > 0.0);
      REQUIRE(before.t1 >= before.t0);
    }
    REQUIRE(run.segments.back().end == FlowEnd::time);
    for (const Segment& segment : run.segments) REQUIRE(segment.x1[0] * (law.hard ? 1.0 : 0.0) <= 0.4);
  });
}

TEST_CASE("objects that compute with a system hold it") {
  for_each_system([](const HybridSystem& system, const ContactLaw&) {
    const Vector p = parameters_with_contacts(system);
    const Vector start = vector({0.1, 0.9});
    const auto carried = [&](Propagator propagator) {
      Transition period;
      carry_period(propagator, start, {.sensitivity = Sensitivity::state}, period);
      return std::pair(period.x1, period.Phi);
    };
    const auto by_itself = carried(Propagator(system, p));
    // A copy that ends before the motion is carried, and a system shared by two.
    auto copy = std::make_unique<HybridSystem>(system);
    Propagator of_copy(*copy, p), of_temporary(HybridSystem{system}, p);
    Flow flow = make_flow(*copy, 0, p, {}, {.kind = FlowKind::general});
    copy.reset();
    CHECK(carried(std::move(of_copy)) == by_itself);
    CHECK(carried(std::move(of_temporary)) == by_itself);
    const SharedSystem shared(system);
    CHECK(&Propagator(shared, p).system() == &*shared);
    Vector field(start.size()), expected(start.size());
    flow.field(0.0, start, field);
    system.modes[0].field(0.0, start, p, expected);
    CHECK(field == expected);
  });
}

TEST_CASE("a run in two pieces equals the run in one") {
  for_each_system([](const HybridSystem& system, const ContactLaw&) {
    const Vector p = parameters_with_contacts(system);
    const Trajectory whole = run_with_contacts(system, p);
    for (const double cut : {1.0, 5.55, 12.3, 20.0}) {
      const Trajectory first = run_with_contacts(system, p, cut);
      const Trajectory second = simulate(system, p, cut, first.x, {.t_end = 40.0});
      REQUIRE(first.events.size() + second.events.size() == whole.events.size());
      REQUIRE((second.x - whole.x).norm() < 1e-9);  // rounding at the cut, amplified by the motion over 40 units of time
    }
  });
}

TEST_CASE("sampled states lie on the motion, exact at the ends of segments and absent outside the run") {
  for_each_system([](const HybridSystem& system, const ContactLaw&) {
    const Vector p = parameters_with_contacts(system);
    const Trajectory run = run_with_contacts(system, p, 10.0);
    std::vector<double> times = {0.0, 0.3};  // the first is before the run
    for (int i = 1; i < 97; ++i) times.push_back(0.3 + 0.1 * i);
    for (const EventRecord& event : run.events) times.push_back(event.t);
    times.push_back(10.0);
    times.push_back(11.0);
    std::sort(times.begin(), times.end());
    const Matrix rows = sample(system, p, run, times);
    REQUIRE(rows.rows() == static_cast<Eigen::Index>(times.size()));
    REQUIRE(rows.cols() == 3);
    REQUIRE(rows.row(rows.rows() - 1).hasNaN());
    REQUIRE(rows.row(0).hasNaN());
    for (Eigen::Index i = 1; i + 1 < rows.rows(); ++i) {
      const double t = times[static_cast<std::size_t>(i)];
      REQUIRE(rows(i, 0) == t);
      const Trajectory there = simulate(system, p, 0.3, vector({0.1, 0.9}), {.t_end = t});
      const bool at_event = std::any_of(run.events.begin(), run.events.end(), [&](const EventRecord& e) { return e.t == t; });
      if (!at_event) REQUIRE((rows.row(i).tail(2).transpose() - there.x).norm() < 1e-11);
      if (at_event) REQUIRE(rows(i, 1) == p[oscillator_parameter::r]);
    }
    REQUIRE(rows.row(1).tail(2).transpose() == vector({0.1, 0.9}));
    REQUIRE(rows.row(rows.rows() - 2).tail(2).transpose() == run.x);
  });
}

TEST_CASE("every contact is listed with its times, speeds, restitution and energy") {
  for_each_system([](const HybridSystem& system, const ContactLaw& law) {
    Vector p = parameters_with_contacts(system);
    if (law.hard) p[oscillator_parameter::law] = 0.75;
    const Trajectory run = run_with_contacts(system, p);
    const std::vector<Contact> list = contacts(run.events);
    REQUIRE(list.size() > 3);
    for (const Contact& contact : list) {
      if (!contact.complete) continue;
      REQUIRE(contact.entry_speed > 0.0);
      REQUIRE(contact.exit_speed >= 0.0);
      REQUIRE(contact.restitution == contact.exit_speed / contact.entry_speed);
      REQUIRE(contact.energy_lost ==
              Approx(0.5 * (std::pow(contact.entry_speed, 2) - std::pow(contact.exit_speed, 2))).margin(1e-15));
      if (law.hard) {
        REQUIRE(contact.t_entry == contact.t_exit);
        if (contact.exit_speed > 0.0) REQUIRE(contact.restitution == Approx(0.75).epsilon(1e-14));
      } else {
        REQUIRE(contact.t_exit > contact.t_entry);
      }
    }
  });
}

TEST_CASE("a contact cut off by the start or the end of the run is listed as incomplete") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters_with_contacts(system);
  const Trajectory run = run_with_contacts(system, p);
  REQUIRE(run.events[0].kind == EventKind::enter);
  REQUIRE(run.events[1].kind == EventKind::leave);
  const double inside = 0.5 * (run.events[0].t + run.events[1].t);
  const std::vector<Contact> ended = contacts(run_with_contacts(system, p, inside).events);
  REQUIRE(ended.size() == 1);
  REQUIRE_FALSE(ended[0].complete);
  REQUIRE(ended[0].t_entry == run.events[0].t);
  REQUIRE(ended[0].entry_speed == run.events[0].normal_speed);
  REQUIRE(std::isnan(ended[0].restitution));
  const Trajectory half = run_with_contacts(system, p, inside);
  const std::vector<Contact> begun = contacts(simulate(system, p, inside, half.x, {.t_end = run.events[1].t + 0.1}).events);
  REQUIRE(begun.size() == 1);
  REQUIRE_FALSE(begun[0].complete);
  REQUIRE(std::isnan(begun[0].t_entry));
  REQUIRE(std::isnan(begun[0].energy_lost));
  REQUIRE(begun[0].t_exit == Approx(run.events[1].t).epsilon(1e-14));
}

TEST_CASE("undamped Hertz becomes an elastic impact as its duration goes to zero") {
  // Increasing stiffness: the equivalent restitution tends to 1, and the departure to that of Newton's law with k_r = 1.
  const HybridSystem hertz = make_oscillator("linear", "hertz"), newton = make_oscillator("linear", "newton");
  double before = 1.0;
  for (const double k_H : {1e4, 1e6, 1e8, 1e10}) {
    const Trajectory soft = run_with_contacts(hertz, parameters(hertz, {{"r", 0.4}, {"eta", 0.8}, {"k_H", k_H}}), 3.0);
    const Contact contact = contacts(soft.events).front();
    const double away = std::abs(contact.restitution - 1.0);
    REQUIRE(away < before / 3.0);
    before = away;
  }
  REQUIRE(before < 1e-3);
  const Trajectory hard = run_with_contacts(newton, parameters(newton, {{"r", 0.4}, {"eta", 0.8}}), 3.0);
  const Trajectory stiff = run_with_contacts(hertz, parameters(hertz, {{"r", 0.4}, {"eta", 0.8}, {"k_H", 1e10}}), 3.0);
  REQUIRE((hard.x - stiff.x).norm() < 1e-3);
}

TEST_CASE("a run that was not carried out counts as failed and every termination has its sentence") {
  REQUIRE(Trajectory{}.termination == Termination::failed);
  REQUIRE(Transition{}.termination == Termination::failed);
  REQUIRE(Segment{}.end == FlowEnd::failed);
  REQUIRE_FALSE(SaltationMatrix{}.regular);
  std::set<std::string_view> sentences;
  for (const Termination reason :
       {Termination::failed, Termination::time, Termination::event_limit, Termination::inadmissible_start,
        Termination::integration_failed, Termination::grazing, Termination::interrupted}) {
    REQUIRE_FALSE(termination_text(reason).empty());
    REQUIRE(sentences.insert(termination_text(reason)).second);
  }
}

TEST_CASE("the free motion passes through a barrier on request and a contact cannot be left out from inside") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"b", 0.0}, {"xi", 0.0}, {"r", 0.5}});
  Propagator propagator(system, p);
  HybridState state = propagator.start(0.0, vector({0.0, 1.0}));
  REQUIRE(propagator.coast(state, 1.0));
  REQUIRE(state.x[0] == Approx(std::sin(1.0)).epsilon(1e-15));
  REQUIRE(state.x[0] > 0.5);
  REQUIRE(state.t == 1.0);
  for (const FlowKind kind : {FlowKind::automatic, FlowKind::general}) {
    Propagator other(system, p, {}, {.kind = kind});
    Transition transition;
    TransitionOptions options;
    options.left_out = LeftOutContact{.events_before = 0, .t_touch = 1.5, .t_resume = 3.0};
    carry(other, 0.0, 4.0, vector({0.0, 1.0}), options, transition);
    REQUIRE(transition.termination == Termination::time);
    REQUIRE(transition.event_sequence.empty());
    REQUIRE(transition.x1[0] == Approx(std::sin(4.0)).epsilon(1e-12));
    REQUIRE(transition.touch.t == 1.5);
    REQUIRE(transition.touch.x[0] == Approx(std::sin(1.5)).epsilon(1e-12));
    REQUIRE(transition.touch.Phi(0, 1) == Approx(std::sin(1.5)).epsilon(1e-12));
  }
}

TEST_CASE("a cancelled run ends as interrupted between two segments") {
  static int cancel_checks;
  cancel_checks = 0;
  const FlowOptions options{.cancelled = [] { return ++cancel_checks > 3; }};
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters_with_contacts(system);
  const Trajectory run = simulate(system, p, 0.3, vector({0.1, 0.9}), {.t_end = 40.0}, options);
  CHECK(run.termination == Termination::interrupted);
  CHECK(run.segments.size() == 3);
  CHECK(run.t == run.segments.back().t1);
  Propagator propagator(system, p, {}, options);
  Transition transition;
  carry(propagator, 0.3, 40.0, vector({0.1, 0.9}), {}, transition);
  CHECK(transition.termination == Termination::interrupted);
}
