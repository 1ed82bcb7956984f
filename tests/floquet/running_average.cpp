// SPDX-License-Identifier: GPL-3.0-or-later
// Exponents averaged over several motions, in lanes or by Propagators, against one motion, with and without a table of contacts,
// and for any number of threads.
#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/exponents/running_average.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include "support/checks.hpp"

#include <catch2/catch.hpp>
#include <oneapi/tbb/task_arena.h>

#include <string>

using namespace graze;
using namespace graze::support;

namespace {

/// In lanes, also for one motion.
LyapunovSpectrum spectrum_in_lanes(const HybridSystem& system, const AverageStart& start, const LyapunovOptions& options) {
  LyapunovSpectrum out;
  run_tasks(system, options.flow, options.all_threads, 1, [&](std::size_t, TaskSlot& slot) -> MotionTask<> {
    slot.set_parameters(start.p);
    CHECK(slot.in_lanes());
    RunningAverage average(slot, start, options);
    co_await average.carry(slot, options.max_periods + 1);
    out = std::move(average).result();
  });
  return out;
}

/// By Propagators.
LyapunovSpectrum spectrum_one_by_one(const HybridSystem& system, const AverageStart& start, LyapunovOptions options) {
  options.flow.kind = FlowKind::alone;
  return lyapunov_spectrum(system, start.p, start.state, options);
}

}  // namespace

TEST_CASE("exponents averaged over several motions side by side agree with one motion") {
  const char* law = GENERATE("newton", "hertz");
  const HybridSystem system = make_oscillator("linear", law);
  Vector p = default_parameters(system.parameters);
  p[oscillator_parameter::eta] = 0.711;
  if (std::string(law) == "hertz") p[static_cast<Eigen::Index>(parameter_index(system.parameters, "b_H"))] = 0.1;
  LyapunovOptions options;
  options.standard_error = 0.0;
  options.aligning = 500;
  options.max_periods = 40000;
  const LyapunovSpectrum one = lyapunov_spectrum(system, p, vector({-0.379, -0.717}), options);
  options.motions = 8;
  const LyapunovSpectrum many = lyapunov_spectrum(system, p, vector({-0.379, -0.717}), options);
  CHECK(many.stop == LyapunovStop::budget);
  CHECK(many.periods == 40000);
  CHECK(many.others.size() == 7);
  // Independent samples of the same chaos: five joint standard errors.
  for (std::size_t i = 0; i < 2; ++i)
    CHECK(std::abs(one.exponents[i] - many.exponents[i]) < 5.0 * std::hypot(one.standard_errors[i], many.standard_errors[i]));
  // The same amount of data: both errors are estimates.
  CHECK(many.standard_errors[0] == Approx(one.standard_errors[0]).epsilon(0.6));
  CHECK(many.liouville_residual >= 0.0);
  CHECK(many.liouville_residual < 1e-10);
  CHECK(static_cast<double>(many.impacts) == Approx(static_cast<double>(one.impacts)).epsilon(0.05));
  CHECK(many.kaplan_yorke == Approx(one.kaplan_yorke).margin(0.05));

  options.standard_error = 1.5e-3;
  options.min_periods = 2000;
  const LyapunovSpectrum bounded = lyapunov_spectrum(system, p, vector({-0.379, -0.717}), options);
  CHECK(bounded.stop == LyapunovStop::standard_error);
  CHECK(bounded.standard_errors[0] < 1.5e-3);
  CHECK(bounded.periods < 40000);
}

TEST_CASE("exponents averaged with and without a table of contacts agree") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"eta", 0.711}, {"b_H", 0.1}});
  LyapunovOptions options;
  options.motions = 16;
  options.standard_error = 0.0;
  options.max_periods = 200000;
  const LyapunovSpectrum with_table = lyapunov_spectrum(system, p, vector({-0.379, -0.717}), options);
  options.flow.tolerance = 1e-14;  // finer than a table
  options.max_periods = 60000;
  const LyapunovSpectrum in_steps = lyapunov_spectrum(system, p, vector({-0.379, -0.717}), options);
  for (std::size_t i = 0; i < 2; ++i) {
    const double joint = std::hypot(with_table.standard_errors[i], in_steps.standard_errors[i]);
    CHECK(std::abs(with_table.exponents[i] - in_steps.exponents[i]) < 3.0 * joint);
    CHECK(joint < 1e-3);
  }
  CHECK(with_table.liouville_residual < 1e-9);
}

TEST_CASE("several motions by Propagators average over the same attractor as one, and as lanes, on any number of threads") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"eta", 0.711}}), state = vector({-0.379, -0.717});
  LyapunovOptions options;
  options.standard_error = 0.0;
  options.interval = 2;
  options.aligning = 100;
  options.max_periods = 24000;
  const LyapunovSpectrum one = spectrum_one_by_one(system, {p, state}, options);
  options.motions = 4;
  const LyapunovSpectrum four = spectrum_one_by_one(system, {p, state}, options);
  const LyapunovSpectrum lanes = spectrum_in_lanes(system, {p, state}, options);
  CHECK(one.others.empty());
  CHECK(four.others.size() == 3);
  CHECK(one.periods == 24000);
  CHECK(four.periods == 24000);
  CHECK(four.stop == LyapunovStop::budget);
  for (const Vector& other : four.others) CHECK((other - four.state).norm() > 1e-3);  // they have parted
  for (const LyapunovSpectrum* other : {&one, &lanes})
    for (std::size_t i = 0; i < 2; ++i)
      CHECK(std::abs(four.exponents[i] - other->exponents[i]) <
            5.0 * std::hypot(four.standard_errors[i], other->standard_errors[i]));
  CHECK(four.standard_errors[0] == Approx(one.standard_errors[0]).epsilon(0.6));
  CHECK(four.log_growth == Approx(lanes.log_growth).epsilon(0.1));
  CHECK(four.liouville_residual < 1e-10);
  options.all_threads = true;
  LyapunovSpectrum several;
  oneapi::tbb::task_arena(2).execute([&] { several = spectrum_one_by_one(system, {p, state}, options); });
  CHECK(several.exponents == four.exponents);
  CHECK(several.standard_errors == four.standard_errors);
  CHECK(several.others == four.others);
}

TEST_CASE("exponents averaged on all threads have identical bits") {
  const char* law = GENERATE("newton", "hertz", "linear");
  const HybridSystem system = make_oscillator("linear", law);
  Vector p = default_parameters(system.parameters);
  p[oscillator_parameter::eta] = 0.711;
  LyapunovOptions options;
  options.motions = 16;
  options.standard_error = 0.0;
  options.max_periods = 30000;
  const LyapunovSpectrum one = lyapunov_spectrum(system, p, vector({-0.379, -0.717}), options);
  options.all_threads = true;
  LyapunovSpectrum several;
  oneapi::tbb::task_arena(2).execute([&] { several = lyapunov_spectrum(system, p, vector({-0.379, -0.717}), options); });
  CHECK(several.exponents == one.exponents);
  CHECK(several.standard_errors == one.standard_errors);
  CHECK(several.state == one.state);
  CHECK(several.others == one.others);
}

TEST_CASE("chaos is averaged over more motions if each will run for long") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"eta", 0.711}});
  const auto motions = [&](std::int64_t periods, double standard_error) {
    AttractorOptions options;
    options.transient = 200;
    options.lyapunov.max_periods = periods;
    options.lyapunov.standard_error = standard_error;
    const Attractor attractor = find_attractor(system, p, vector({-0.379, -0.717}), options);
    CHECK(attractor.type == AttractorType::chaotic);
    return 1 + attractor.time_average.others.size();
  };
  CHECK(motions(19000, 0.0) == 1);
  CHECK(motions(20000, 0.0) == 16);
  CHECK(motions(100000, 0.0) == 32);
  CHECK(motions(1000000, 0.0) == 128);
  CHECK(motions(1000000, 1e-3) == 16);  // a bound that some 20000 periods meet
}

TEST_CASE("an average by Propagators has four motions more for each 12000 periods, up to 32") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"eta", 0.711}});
  LyapunovOptions options;
  options.flow.kind = FlowKind::alone;
  options.standard_error = 0.0;
  const auto motions = [&](std::int64_t periods) {
    options.max_periods = periods;
    return enough_motions(system, p, options);
  };
  CHECK(motions(11999) == 1);
  CHECK(motions(12000) == 4);
  CHECK(motions(50000) == 16);
  CHECK(motions(1000000) == 32);
  options.change = 1e-3;  // a rule for a single motion
  CHECK(motions(1000000) == 1);
}

TEST_CASE("exponents averaged with an existing table of contacts") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"eta", 0.711}});
  const auto contacts = std::make_shared<const ContactTable>(system, p, SpeedRange{0.125, 1.9});
  LyapunovOptions options;
  options.standard_error = 0.0;
  options.max_periods = 12;  // too few periods for chaos to amplify the error of the table much
  const LyapunovSpectrum in_steps = spectrum_in_lanes(system, {p, vector({-0.379, -0.717})}, options);
  options.table = contacts;
  const LyapunovSpectrum with_table = spectrum_in_lanes(system, {p, vector({-0.379, -0.717})}, options);
  CHECK(in_steps.impacts > 0);
  CHECK(with_table.impacts == in_steps.impacts);
  for (std::size_t i = 0; i < 2; ++i) CHECK(with_table.exponents[i] == Approx(in_steps.exponents[i]).margin(1e-8));
  CHECK(with_table.exponents != in_steps.exponents);  // it was used

  Vector elsewhere = p;
  elsewhere[oscillator_parameter::eta] = 0.72;
  CHECK_THROWS_WITH(spectrum_in_lanes(system, {elsewhere, vector({-0.379, -0.717})}, options),
                    Catch::Contains("table of contacts is not one of parameter set"));
}

TEST_CASE("one motion in lanes has the exponents of the scalar computation") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  LyapunovOptions options;
  options.standard_error = 0.0;
  options.interval = 3;
  options.max_periods = 90;
  std::vector<AverageStart> starts;
  for (const double eta : {0.80, 0.85, 0.93}) {
    Vector p = default_parameters(system.parameters);
    p[oscillator_parameter::eta] = eta;
    starts.push_back({p, vector({1.2, 0.4})});
  }
  std::vector<LyapunovSpectrum> in_pool(starts.size());
  LaneCarrier many(system);
  const auto average = [&](std::size_t k, TaskSlot& lane) -> MotionTask<> {
    lane.set_parameters(starts[k].p);
    RunningAverage one(lane, starts[k], options);
    const bool open = co_await one.carry(lane, 40);
    CHECK(open);
    co_await one.carry(lane, 1000);
    in_pool[k] = std::move(one).result();
  };
  TaskPool(many).run(starts.size(), average);
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const LyapunovSpectrum alone = lyapunov_spectrum(system, starts[k].p, starts[k].state, options);
    const LyapunovSpectrum in_lanes = spectrum_in_lanes(system, starts[k], options);
    CHECK(in_lanes.periods == alone.periods);
    CHECK(in_lanes.impacts == alone.impacts);
    CHECK(in_lanes.correlation_times[0] == Approx(alone.correlation_times[0]));
    for (std::size_t i = 0; i < 2; ++i) CHECK(in_lanes.exponents[i] == Approx(alone.exponents[i]).margin(1e-9));
    CHECK((in_lanes.state - alone.state).norm() < 1e-6);  // rounding, amplified over 90 periods
    CHECK(in_pool[k].exponents == in_lanes.exponents);
    CHECK(in_pool[k].periods == in_lanes.periods);
    CHECK(in_pool[k].state == in_lanes.state);
  }
}

TEST_CASE("the number of motions is validated") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  LyapunovOptions options;
  options.motions = 0;
  CHECK_THROWS_WITH(lyapunov_spectrum(system, default_parameters(system.parameters), vector({0.0, 0.0}), options),
                    "motions is 0; allowed is a whole number >= 1");
}

TEST_CASE("an average ends if a motion fails or is cancelled before the motions separate") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"b", 0.05}, {"eta", 0.711}, {"r", 2.0}, {"k_H", 100.0}, {"b_H", 0.1}});
  LyapunovOptions options;
  options.motions = 16;
  int cancel_checks = 0;
  options.cancelled = [&cancel_checks] { return ++cancel_checks > 3; };
  const LyapunovSpectrum cancelled = lyapunov_spectrum(system, p, vector({-0.379, -0.717}), options);
  CHECK(cancelled.stop == LyapunovStop::interrupted);
  CHECK(cancelled.periods == 0);
  CHECK(cancelled.state != vector({-0.379, -0.717}));
  options.cancelled = {};
  options.flow.max_steps = 2;  // of a contact
  const LyapunovSpectrum failed = lyapunov_spectrum(system, p, vector({-0.379, -0.717}), options);
  CHECK(failed.stop == LyapunovStop::failed);
  CHECK(failed.termination != Termination::time);
  CHECK(failed.periods == 0);
}
