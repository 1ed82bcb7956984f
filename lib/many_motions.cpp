// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/many_motions.hpp>

#include <graze/lib/detail/level_barriers.hpp>
#include <graze/lib/linear_flow.hpp>

#include <xsimd/config/xsimd_cpuid.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace graze {

namespace {

/// The oscillator of which the lanes know the equations.
struct LaneOscillator {
  LinearOscillator free;
  lanes::Law law = lanes::Law::restitution;
  double barrier = 0.0, restitution = 1.0;
  HertzContact hertz;
};

const Event* only_event(const HybridSystem& system, std::size_t mode) {
  const Event* found = nullptr;
  for (const Event& event : system.events) {
    if (event.from != mode) continue;
    if (found) return nullptr;
    found = &event;
  }
  return found;
}

ModeStructure structure(const HybridSystem& system, std::size_t mode, const Vector& p) {
  return system.modes[mode].structure ? system.modes[mode].structure(p) : ModeStructure{};
}

/// Contact by Hertz's law with the equations of the flight, left through the barrier.
bool is_contact_of(const LinearOscillator& free, const HertzContact& contact, const Event& leaving, const Event& entering) {
  using C = HertzContact;
  const auto& q = contact.value;
  return leaving.to == entering.from && leaving.continuous && entering.continuous && q[C::damping] == free.damping &&
         q[C::amplitude] == free.amplitude && q[C::frequency] == free.frequency && q[C::beta] == 0.0 && free.stiffness == 1.0 &&
         free.constant == 0.0 && leaving.guard.level && leaving.guard.level->level == entering.guard.level->level &&
         contact.parameter[C::barrier] == entering.guard.level->level;
}

std::optional<LaneOscillator> lane_oscillator(const HybridSystem& system, const Vector& p) {
  if (system.states != 2 || !system.forcing_frequency || system.modes.empty()) return std::nullopt;
  constexpr std::size_t free_mode = 0;
  const ModeStructure flight = structure(system, free_mode, p);
  const auto* linear = std::get_if<LinearOscillator>(&flight);
  const Event* hit = only_event(system, free_mode);
  if (!linear || !hit || !hit->guard.level || hit->guard.level->coordinate != 0 || hit->guard.level->sign < 0.0)
    return std::nullopt;
  if (!LinearFlow::applies(system, free_mode, {}, *linear) || linear->stiffness <= linear->damping * linear->damping ||
      linear->frequency != p[static_cast<Eigen::Index>(*system.forcing_frequency)])
    return std::nullopt;
  LaneOscillator out;
  out.free = *linear;
  out.barrier = p[static_cast<Eigen::Index>(hit->guard.level->level)];
  if (hit->reset.rebound && hit->to == free_mode && hit->reset.rebound->level == hit->guard.level->level) {
    out.restitution = p[static_cast<Eigen::Index>(hit->reset.rebound->coefficient)];
    return out;
  }
  const ModeStructure pressed = structure(system, hit->to, p);
  const auto* contact = std::get_if<HertzContact>(&pressed);
  const Event* leaving = contact ? only_event(system, hit->to) : nullptr;
  if (!leaving || hit->reset.map || leaving->reset.map || !is_contact_of(*linear, *contact, *leaving, *hit)) return std::nullopt;
  out.law = lanes::Law::hertz;
  out.hertz = *contact;
  return out;
}

lanes::Coefficients lane_coefficients(const LaneOscillator& oscillator) {
  using namespace lanes;
  const LinearOscillator& free = oscillator.free;
  const double w = free.frequency, k = free.stiffness, b = free.damping;
  const double detuning = k - w * w, drag = 2.0 * b * w, D = detuning * detuning + drag * drag;
  Coefficients q{};
  q[damping] = b;
  q[rate] = std::sqrt(k - b * b);
  q[stiffness] = k;
  q[frequency] = w;
  q[amplitude] = free.amplitude;
  q[constant] = free.constant;
  q[cosine] = free.amplitude == 0.0 ? 0.0 : free.amplitude * detuning / D;
  q[sine] = free.amplitude == 0.0 ? 0.0 : free.amplitude * drag / D;
  q[offset] = free.constant / k;
  q[forced2] = std::hypot(q[cosine], q[sine]) * w * w;
  q[forced6] = std::hypot(q[cosine], q[sine]) * std::pow(w, 6);
  q[barrier] = oscillator.barrier;
  q[period] = 2.0 * std::numbers::pi / w;
  q[longest] = 2.5 / std::max(w, std::sqrt(k));
  q[march_step] = std::ldexp(q[longest], -static_cast<int>(marching_level));
  q[restitution] = oscillator.restitution;
  q[contact_stiffness] = oscillator.hertz.value[HertzContact::stiffness];
  q[contact_damping] = oscillator.hertz.value[HertzContact::contact_damping];
  double h = q[longest];
  for (std::size_t level = 0; level < levels; ++level, h *= 0.5) {
    double* turn = &q[turns + 4 * level];
    turn[0] = std::exp(-b * h) * std::cos(q[rate] * h);
    turn[1] = std::exp(-b * h) * std::sin(q[rate] * h);
    turn[2] = std::cos(w * h);
    turn[3] = std::sin(w * h);
  }
  return q;
}

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
  lanes::Law law;
  lanes::Coefficients coefficients;
  double period, log_volume_change;
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
  return options.kind == FlowKind::automatic && lane_oscillator(system, p).has_value();
}

ManyMotions::ManyMotions(const HybridSystem& system, const FlowOptions& options, LaneWidth width)
    : system_(&system), options_(options), kernel_(kernel(width)) {
  if (!available(width)) throw std::invalid_argument("this processor does not have the lanes asked for");
  validate(options);
}

ManyMotions::~ManyMotions() = default;

std::size_t ManyMotions::add_parameters(const Vector& p) {
  check_parameters(system_->parameters, p);
  const auto oscillator = options_.kind == FlowKind::automatic ? lane_oscillator(*system_, p) : std::nullopt;
  if (!oscillator || (!sets_.empty() && sets_.front()->law != oscillator->law))
    throw std::invalid_argument(
        fmt::format("{} at these parameters is not an oscillator that the lanes know (linear, underdamped, one barrier with "
                    "restitution or of Hertz's law); carry its motions one by one",
                    system_->name));
  const bool hard = oscillator->law == lanes::Law::restitution;
  sets_.push_back(std::make_unique<Set>(Set{p, oscillator->law, lane_coefficients(*oscillator), forcing_period(*system_, p),
                                            hard ? 2.0 * std::log(oscillator->restitution) : 0.0, nullptr}));
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
    for (const Going& one : going) motions.push_back({one.x, one.v, &sets_[starts[one.motion].parameters]->coefficients});
    carried.assign(going.size() * stretch, {});
    kernel_({sets_.front()->law, options_.tolerance, tangent, motions.data(), motions.size(), stretch, carried.data()});
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
          out = {Termination::time,
                 period.x,
                 period.v,
                 period.Phi,
                 std::log(std::abs(period.det)),
                 period.divergence + (set.law == lanes::Law::restitution ? period.impacts * set.log_volume_change : 0.0),
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
