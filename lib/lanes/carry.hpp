// SPDX-License-Identifier: GPL-3.0-or-later
// What the lanes do, over and over: march or fly where most are in flight, take a step of contact where at least half of them are
// in one, take the next motion where one is through. Lanes do not wait for each other at the end of a period, only at these two.
#pragma once

#include <graze/lib/lanes/flight.hpp>
#include <graze/lib/lanes/passage.hpp>
#include <graze/lib/lanes/whole_contact.hpp>

#include <cmath>

namespace graze::lanes {

template <class Real, bool Tangent> class Carrier {
 public:
  explicit Carrier(const Job& job) : job_(job) {
    if (job.law == Law::hertz) ratio_ = std::pow(job.tolerance, 1.0 / static_cast<double>(detail::hertz_order));
    if constexpr (W > 1) {  // idle lanes compute along
      for (auto& row : memory_.coefficient)
        for (double& one : row) one = 1.0;
      for (auto& row : memory_.field)
        for (double& one : row) one = 0.0;
    }
    for (std::size_t i = 0; i < job.count; ++i) {
      tables_ = tables_ || job.motions[i].table;
      met_ = met_ || job.motions[i].met;
    }
    for (std::size_t lane = 0; lane < W; ++lane) {
      memory_.table[lane] = nullptr;
      memory_.met[lane] = nullptr;
      next_motion(lane);
    }
  }

  void run() {
    // With a table steps of contact are rare: few lanes wait for them to be worth it.
    constexpr int half = static_cast<int>((W + 1) / 2);
    const int most = static_cast<int>(tables_ ? (W + 3) / 4 : (3 * W + 3) / 4);
    for (;;) {
      const int contacts = count(memory_.is(Task::contact)), crossings = count(memory_.is(Task::crossing)),
                flights = count(memory_.is(Task::flight)), marching = count(memory_.is(Task::marching));
      if (contacts >= most || (contacts > 0 && crossings + flights + marching == 0)) {
        const Surfacing<Real> up = press<Real, Tangent>(memory_, job_.tolerance, ratio_);
        if (any(up.at_barrier)) leave_barrier(memory_, up.at_barrier, up.v, up.c, up.s);
        if (any(up.at_end)) end_period(up.at_end, Real(memory_[barrier] + up.y * up.y), up.v, up.y);
      } else if (crossings >= half || (crossings > 0 && flights + marching == 0)) {
        const Landing<Real> landing = land<Real, Tangent>(memory_);
        if (any(landing.at_barrier)) hit(landing);
        if (any(landing.at_end)) end_period(landing.at_end, landing.x, landing.v, Real(-1.0));
      } else if (flights >= half || (flights > 0 && marching == 0)) {
        fly(memory_);
      } else if (marching > 0) {
        march(memory_, marching >= half ? half - 1 : 0);
      } else if (!any(memory_.is(Task::given_up))) {
        return;
      }
      if (any(memory_.is(Task::given_up)))
        for (std::size_t lane = 0; lane < W; ++lane)
          if (memory_.is(lane, Task::given_up)) give_up(lane);
    }
  }

 private:
  static constexpr std::size_t W = width<Real>;

  void hit(const Landing<Real>& landing) {
    alignas(64) double where[W];
    put(where, Real(select(landing.at_barrier, Real(1.0), Real(0.0))));
    for (std::size_t lane = 0; lane < W; ++lane) memory_.impacts[lane] += where[lane] > 0.5 ? 1 : 0;
    if (job_.law == Law::restitution) return rebound<Real, Tangent>(memory_, landing);
    if (met_) note_speeds(where, landing.v);
    Mask<Real> touching = landing.at_barrier;
    if (tables_) touching = touching & !pass_known(landing);
    if (any(touching)) touch(memory_, touching, Real(0.0), landing.v, landing.c, landing.s);
  }

  /// Contacts that the table knows.
  Mask<Real> pass_known(const Landing<Real>& landing) {
    const KnownContact<Real> contact = known_contact<Real, Tangent>(memory_, landing.at_barrier, landing);
    if (any(contact.ends)) leave_known<Real, Tangent>(memory_, contact);
    if (any(contact.spans)) {
      const Real before = memory_[rest];
      begin_spanning<Real, Tangent>(memory_, contact);
      const Mask<Real> goes_on = end_period(contact.spans, Real(memory_[barrier] + contact.y * contact.y), contact.v, contact.y);
      if (any(goes_on)) end_spanning<Real, Tangent>(memory_, goes_on, contact, before);
    }
    return contact.ends | contact.spans;
  }

  void note_speeds(const double (&where)[W], const Real& v) {
    alignas(64) double speed[W];
    put(speed, v);
    for (std::size_t lane = 0; lane < W; ++lane) {
      if (where[lane] < 0.5 || !memory_.met[lane]) continue;
      const std::int64_t band = band_of<Real>(speed[lane]) - SpeedsMet::lowest, last = SpeedsMet::count - 1;
      ++memory_.met[lane]->of_band[static_cast<std::size_t>(band < 0 ? 0 : band > last ? last : band)];
    }
  }

  /// Writes down what the period did, and begins the next; y < 0: not in contact. Says which motions go on.
  Mask<Real> end_period(const Mask<Real>& where, const Real& x, const Real& v, const Real& y) {
    alignas(64) double ends[W], x1[W], v1[W], depth1[W];
    put(ends, Real(select(where, Real(1.0), Real(0.0))));
    put(x1, x);
    put(v1, v);
    put(depth1, y);
    for (std::size_t lane = 0; lane < W; ++lane) {
      if (ends[lane] < 0.5) continue;
      Period& result = job_.results[memory_.motion[lane] * job_.stride + memory_.period[lane]];
      result.x = x1[lane];
      result.v = v1[lane];
      if constexpr (Tangent) {
        for (std::size_t i = 0; i < 4; ++i) result.Phi[i] = memory_.field[phi_00 + i][lane];
        result.det = memory_.field[det][lane];
      }
      result.divergence = memory_.field[divergence][lane];
      result.impacts = memory_.impacts[lane];
      result.carried = true;
      memory_.impacts[lane] = 0;
      if (++memory_.period[lane] == job_.motions[memory_.motion[lane]].periods) {
        ends[lane] = 0.0;
        next_motion(lane);
      }
    }
    const Mask<Real> goes_on = take<Real>(ends) > Real(0.5);
    begin_period(goes_on, x, v, y);
    return goes_on;
  }

  void begin_period(const Mask<Real>& where, const Real& x, const Real& v, const Real& y) {
    memory_.set(rest, where, memory_[period]);
    for (const Field one : {phi_00, phi_11, det}) memory_.set(one, where, Real(1.0));
    for (const Field zero : {phi_01, phi_10, divergence}) memory_.set(zero, where, Real(0.0));
    const Mask<Real> pressed = where & (y >= Real(0.0));
    if (any(pressed)) touch(memory_, pressed, y, v, Real(1.0), Real(0.0));
    depart(memory_, Mask<Real>(where & !pressed), x, v, Real(1.0), Real(0.0), false);
  }

  void next_motion(std::size_t lane) {
    if (taken_ == job_.count) return memory_.assign(lane, Task::idle);
    const Motion& motion = job_.motions[taken_];
    memory_.motion[lane] = taken_++;
    memory_.period[lane] = 0;
    memory_.table[lane] = motion.table;
    memory_.met[lane] = motion.met;
    memory_.impacts[lane] = 0;
    for (std::size_t i = 0; i < coefficients; ++i) memory_.coefficient[i][lane] = (*motion.coefficients)[i];
    const double into = motion.x - memory_.coefficient[barrier][lane];
    if (job_.law == Law::restitution && into > 0.0) return memory_.assign(lane, Task::given_up);
    alignas(64) double here[W] = {};
    here[lane] = 1.0;
    begin_period(take<Real>(here) > Real(0.5), Real(motion.x), Real(motion.v), Real(into > 0.0 ? std::sqrt(into) : -1.0));
  }

  void give_up(std::size_t lane) {
    job_.results[memory_.motion[lane] * job_.stride + memory_.period[lane]].carried = false;
    next_motion(lane);
  }

  const Job& job_;
  double ratio_ = 1.0;
  std::size_t taken_ = 0;
  bool tables_ = false, met_ = false;
  Memory<Real> memory_;
};

template <class Real> void carry(const Job& job) {
  if (job.tangent)
    Carrier<Real, true>(job).run();
  else
    Carrier<Real, false>(job).run();
}

}  // namespace graze::lanes
