// SPDX-License-Identifier: GPL-3.0-or-later
// All solvers by name, each tuned once per problem, and their reported counters. A benchmark is named question/problem/solver;
// table.py compares the solvers of one question and problem.
#pragma once

#include "baselines/boost_dopri5.hpp"
#include "baselines/cvode.hpp"
#include "baselines/gsl_rk8pd.hpp"
#include "problems.hpp"

#include <benchmark/benchmark.h>

#include <map>

namespace benchmarks {

/// The accuracy of a solver on the attractor at its tolerance. Computed at first use, because Google Benchmark calls a
/// benchmark more than once.
template <class Make> const Accuracy& tuning(const Problem& p, const std::string& name, const Make& make) {
  static std::map<std::string, Accuracy> known;
  const auto [entry, is_new] = known.try_emplace(p.name + "/" + name);
  if (is_new) entry->second = tuned([&](double tolerance) { return accuracy(make(tolerance), tolerance, p, attractor(p)); });
  return entry->second;
}

/// Number of the runs near grazing with a wrong number of impacts at that tolerance.
template <class Make> int miscounted(const Problem& p, const std::string& name, const Make& make) {
  static std::map<std::string, int> known;
  const auto [entry, is_new] = known.try_emplace(p.name + "/" + name);
  if (is_new) {
    const double tolerance = tuning(p, name, make).tolerance;
    entry->second = accuracy(make(tolerance), tolerance, p, near_grazing(p)).miscounted;
  }
  return entry->second;
}

template <Law law, class Visit> void with_baselines(const Problem& p, const Visit& visit) {
  const auto baseline = [&]<template <Law, std::size_t> class Baseline>(const char* name, Watch watch, Baseline<law, 6>*) {
    visit(std::string(name), [p, watch](double tolerance) { return Solver<Baseline, law>(p, tolerance, watch); });
  };
  baseline("gsl-rk8pd", Watch::located, static_cast<baselines::GslRk8pd<law, 6>*>(nullptr));
  baseline("gsl-rk8pd-signs", Watch::sign_only, static_cast<baselines::GslRk8pd<law, 6>*>(nullptr));
  baseline("boost-dopri5", Watch::located, static_cast<baselines::BoostDopri5<law, 6>*>(nullptr));
  baseline("boost-dopri5-signs", Watch::sign_only, static_cast<baselines::BoostDopri5<law, 6>*>(nullptr));
  baseline("cvode", Watch::located, static_cast<baselines::Cvode<law, 6>*>(nullptr));
  baseline("cvode-signs", Watch::sign_only, static_cast<baselines::Cvode<law, 6>*>(nullptr));
}

/// visit(name, make) for every baseline; make(tolerance) is a solver.
template <class Visit> void with_baselines(const Problem& p, const Visit& visit) {
  p.law == Law::hertz ? with_baselines<Law::hertz>(p, visit) : with_baselines<Law::newton>(p, visit);
}

/// The same for graze, its general flow (used for user-defined systems), and every baseline.
template <class Visit> void with_solvers(const Problem& p, const Visit& visit) {
  visit(std::string("graze"), [p](double tolerance) { return Graze(p, tolerance); });
  visit(std::string("graze-general"), [p](double tolerance) { return Graze(p, tolerance, graze::FlowKind::general); });
  with_baselines(p, visit);
}

/// Time per item: per period, flight, ...
inline void per_item(benchmark::State& state, std::size_t items) {
  using benchmark::Counter;
  state.counters["seconds"] = Counter(static_cast<double>(items), Counter::kIsIterationInvariantRate | Counter::kInvert);
}
inline void report(benchmark::State& state, const Accuracy& known) {
  state.counters["tolerance"] = known.tolerance;
  state.counters["error"] = known.ninetieth;
  state.counters["worst"] = known.worst;
}

}  // namespace benchmarks
