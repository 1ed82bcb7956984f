// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/many_motions.hpp>

#include <graze/lib/lanes/oscillator.hpp>

#include <xsimd/config/xsimd_cpuid.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graze {

namespace {

void (*kernel(LaneWidth width))(const lanes::Job&) {
  switch (width) {
  case LaneWidth::one:
    return lanes::carry_one;
  case LaneWidth::generic:
    return lanes::carry_generic;
#ifdef GRAZE_X86_LANES
  case LaneWidth::avx2:
    return lanes::carry_avx2;
  case LaneWidth::avx512:
    return lanes::carry_avx512;
#endif
  default:
    break;
  }
  for (const LaneWidth wide : {LaneWidth::avx512, LaneWidth::avx2})
    if (available(wide)) return kernel(wide);
  return lanes::carry_generic;
}

}  // namespace

struct ManyMotions::Set {
  Vector p;
  lanes::Oscillator oscillator;
  double period;
  std::unique_ptr<Propagator> propagator;  ///< for what the lanes leave over; made when it is wanted
};

bool available(LaneWidth width) {
#ifdef GRAZE_X86_LANES
  const auto has = xsimd::available_architectures();
  if (width == LaneWidth::avx2) return has.avx2;
  if (width == LaneWidth::avx512) return has.avx512f;
#endif
  return width != LaneWidth::avx2 && width != LaneWidth::avx512;
}

bool ManyMotions::applies(const HybridSystem& system, const Vector& p, const FlowOptions& options) {
  return options.kind == FlowKind::automatic && lanes::lane_oscillator(system, p).has_value();
}

ManyMotions::ManyMotions(const HybridSystem& system, const FlowOptions& options, LaneWidth width)
    : system_(&system), options_(options), kernel_(kernel(width)) {
  if (!available(width)) throw std::invalid_argument("this processor does not have the lanes asked for");
  validate(options);
}

ManyMotions::~ManyMotions() = default;

std::size_t ManyMotions::add_parameters(const Vector& p) {
  check_parameters(system_->parameters, p);
  const auto oscillator = options_.kind == FlowKind::automatic ? lanes::lane_oscillator(*system_, p) : std::nullopt;
  if (!oscillator || (!sets_.empty() && sets_.front()->oscillator.law != oscillator->law))
    throw std::invalid_argument(
        fmt::format("{} at these parameters is not an oscillator that the lanes know (linear, underdamped, one barrier with "
                    "restitution or of Hertz's law); carry its motions one by one",
                    system_->name));
  sets_.push_back(std::make_unique<Set>(Set{p, *oscillator, forcing_period(*system_, p), nullptr}));
  return sets_.size() - 1;
}

void ManyMotions::carry_one_period(Set& set, double x, double v, bool tangent, PeriodResult& out) {
  if (!set.propagator) set.propagator = std::make_unique<Propagator>(*system_, set.p, std::vector<std::size_t>{}, options_);
  graze::carry(*set.propagator, 0.0, set.period, Vector{{x, v}},
               {.sensitivity = tangent ? Sensitivity::state : Sensitivity::none}, transition_);
  out.termination = transition_.termination;
  if (out.termination != Termination::time) return;
  out.x = transition_.x1[0];
  out.v = transition_.x1[1];
  if (tangent) out.Phi = {transition_.Phi(0, 0), transition_.Phi(0, 1), transition_.Phi(1, 0), transition_.Phi(1, 1)};
  out.log_det = transition_.log_det;
  out.liouville = transition_.liouville;
  out.impacts = static_cast<int>(std::count_if(transition_.event_sequence.begin(), transition_.event_sequence.end(),
                                               [&](std::size_t e) { return begins_contact(system_->events[e].kind); }));
}

void ManyMotions::carry(const std::vector<MotionStart>& starts, std::size_t periods, bool tangent,
                        std::vector<PeriodResult>& results) {
  for (const MotionStart& start : starts)
    if (start.parameters >= sets_.size())
      throw std::invalid_argument(
          fmt::format("a motion has parameter set {}; {} were added (counted from 0)", start.parameters, sets_.size()));
  results.assign(starts.size() * periods, {});
  if (results.empty()) return;
  // Motions that go on: by index, with the periods that are behind them. Each round of the lanes takes them through one stretch;
  // where one was given up, the Propagator carries that period, and the lanes take over again.
  struct Going {
    std::size_t motion, done;
    double x, v;
  };
  std::vector<Going> going, next;
  for (std::size_t m = 0; m < starts.size(); ++m) going.push_back({m, 0, starts[m].x, starts[m].v});
  std::vector<lanes::Motion> motions;
  std::vector<lanes::Period> carried;
  while (!going.empty()) {
    // All motions of one call go equally far: to the end of the one that is furthest behind... the rest is cut off below.
    std::size_t stretch = 0;
    for (const Going& one : going) stretch = std::max(stretch, periods - one.done);
    motions.clear();
    for (const Going& one : going)
      motions.push_back({one.x, one.v, &sets_[starts[one.motion].parameters]->oscillator.coefficients});
    carried.assign(going.size() * stretch, {});
    kernel_(
        {sets_.front()->oscillator.law, options_.tolerance, tangent, motions.data(), motions.size(), stretch, carried.data()});
    next.clear();
    for (std::size_t i = 0; i < going.size(); ++i) {
      Going one = going[i];
      Set& set = *sets_[starts[one.motion].parameters];
      const std::size_t last = std::min(periods - one.done, stretch);
      bool stopped = false;
      for (std::size_t k = 0; k < last; ++k) {
        const lanes::Period& period = carried[i * stretch + k];
        PeriodResult& out = results[one.motion * periods + one.done];
        if (!period.carried) {
          carry_one_period(set, one.x, one.v, tangent, out);
          ++left_over_;
          stopped = true;
        } else {
          out = {
              Termination::time, period.x, period.v, period.Phi, std::log(std::abs(period.det)), set.oscillator.liouville(period),
              period.impacts};
        }
        ++carried_;
        ++one.done;
        one.x = out.x;
        one.v = out.v;
        if (out.termination != Termination::time) {
          for (; one.done < periods; ++one.done) results[one.motion * periods + one.done].termination = out.termination;
        }
        if (stopped) break;
      }
      if (one.done < periods) next.push_back(one);
    }
    going.swap(next);
  }
}

}  // namespace graze
