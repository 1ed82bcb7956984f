// SPDX-License-Identifier: GPL-3.0-or-later
// Whole Hertz contacts in lanes: from a table, and in steps to make the table.
#pragma once

#include <graze/lib/lanes/contact_sum.hpp>
#include <graze/lib/lanes/passage.hpp>
#include <graze/lib/lanes/wide_registers.hpp>

#include <cmath>
#include <numbers>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

inline constexpr double cells_per_angle = static_cast<double>(time_cells) / std::numbers::pi;

/// The table's values for contacts that begin now.
template <class Real> struct TabulatedContact {
  Mask<Real> ends;                         ///< lanes whose contact ends before the period
  Mask<Real> spans;                        ///< lanes whose contact spans the end of the period, at depth y^2 and speed v
  Real duration, v_out, divergence, c, s;  ///< of the whole contact; the forcing's phase at its end
  Real y, v, begun_divergence;             ///< at the end of the period
  Real Phi[4], begun_Phi[4];
};

/// Evaluates pieces, one for each lane (null: none), at (u, v).
template <class Real, bool Tangent> class PieceSums {
 public:
  static constexpr std::size_t W = width<Real>;
  alignas(64) double values[4][W] = {}, Phi[4][W] = {};

  PieceSums(const Memory<Real>& m, const ContactPiece* const (&piece)[W], const double (&u)[W], const double (&v)[W]) {
    alignas(64) double x[W] = {}, y[W] = {};
    for (std::size_t lane = 0; lane < W; ++lane) {
      if (!piece[lane]) continue;
      x[lane] = (u[lane] - piece[lane]->time) * piece[lane]->per_time;
      y[lane] = (v[lane] - piece[lane]->speed) * piece[lane]->per_speed;
    }
    Real T[polynomials];
    alignas(64) double T_time[polynomials][W], T_speed[polynomials][W];
    chebyshev(take<Real>(x), T);
    for (std::size_t i = 0; i < polynomials; ++i) put(T_time[i], T[i]);
    chebyshev(take<Real>(y), T);
    for (std::size_t i = 0; i < polynomials; ++i) put(T_speed[i], T[i]);
    for (std::size_t lane = 0; lane < W; ++lane) {
      if (!piece[lane]) continue;
      const TermPair* terms = m.table[lane]->terms;
      double four[4];
      add_up<Real>(terms, piece[lane]->values, T_time[0] + lane, T_speed[0] + lane, W, four);
      for (std::size_t i = 0; i < 4; ++i) values[i][lane] = four[i];
      if constexpr (Tangent) {
        add_up<Real>(terms, piece[lane]->tangent, T_time[0] + lane, T_speed[0] + lane, W, four);
        for (std::size_t i = 0; i < 4; ++i) Phi[i][lane] = four[i];
      }
    }
  }
};

/// Looks up the contacts that begin with the landings.
template <class Real, bool Tangent> TabulatedContact<Real> known_contact(const Memory<Real>& m, const Landing<Real>& landing) {
  constexpr std::size_t W = width<Real>;
  alignas(64) double here[W], time[W], speed[W], left[W], ends[W] = {}, spans[W] = {}, angle[W] = {};
  const ContactPiece *piece[W], *begun[W];
  put(here, Real(select(landing.where, Real(1.0), Real(0.0))));
  put(time, Real(m[period] - m[rest]));
  put(speed, landing.v);
  put(left, m[rest]);
  bool any_known = false, any_spans = false;
  for (std::size_t lane = 0; lane < W; ++lane) {
    const ContactPieces* table = m.table[lane];
    piece[lane] = here[lane] > 0.5 && table
                      ? find_piece<Real>(*table, table->whole, time[lane] * table->cells_per_time, speed[lane])
                      : nullptr;
    any_known = any_known || piece[lane];
  }
  const Mask<Real> none = mask_of<Real>(0);
  TabulatedContact<Real> out{};
  out.ends = out.spans = none;
  if (!any_known) return out;
  const PieceSums<Real, Tangent> sums(m, piece, time, speed);
  for (std::size_t lane = 0; lane < W; ++lane) {
    begun[lane] = nullptr;
    if (!piece[lane]) continue;
    const double duration = sums.values[0][lane];
    if (duration < left[lane]) {
      ends[lane] = 1.0;
      continue;
    }
    angle[lane] = 2.0 * std::asin(std::sqrt(left[lane] / duration));
    begun[lane] = find_piece<Real>(*m.table[lane], m.table[lane]->begun, angle[lane] * cells_per_angle, speed[lane]);
    if (begun[lane]) spans[lane] = 1.0;
    any_spans = any_spans || begun[lane];
  }
  out.ends = take<Real>(ends) > Real(0.5);
  out.spans = take<Real>(spans) > Real(0.5);
  out.duration = take<Real>(sums.values[0]);
  out.v_out = take<Real>(sums.values[1]);
  out.divergence = take<Real>(sums.values[2]);
  for (std::size_t i = 0; i < 4; ++i) out.Phi[i] = take<Real>(sums.Phi[i]);
  Real turn_c, turn_s;
  circle(Real(m[frequency] * out.duration), turn_c, turn_s);
  out.c = wedge(landing.c, turn_c, landing.s, turn_s);
  out.s = dot(landing.s, turn_c, landing.c, turn_s);
  if (any_spans) {
    const PieceSums<Real, Tangent> part(m, begun, angle, speed);
    out.y = sqrt(largest(take<Real>(part.values[0]), Real(0.0)));
    out.v = take<Real>(part.values[1]);
    out.begun_divergence = take<Real>(part.values[2]);
    for (std::size_t i = 0; i < 4; ++i) out.begun_Phi[i] = take<Real>(part.Phi[i]);
  }
  return out;
}

/// Counts the speeds of entry of motions whose table is still to be made.
template <class Real> void note_speeds(const Memory<Real>& m, const Landing<Real>& landing) {
  alignas(64) double speed[width<Real>];
  put(speed, landing.v);
  for_each(landing.where, [&](std::size_t lane) {
    if (!m.met[lane]) return;
    const std::int64_t band = band_of<Real>(speed[lane]) - SpeedHistogram::lowest, last = SpeedHistogram::count - 1;
    const auto place = static_cast<std::size_t>(band < 0 ? 0 : band > last ? last : band);
    __atomic_fetch_add(&m.met[lane]->of_band[place], 1, __ATOMIC_RELAXED);  // other threads count there, too
  });
}

/// Ends a tabulated contact within the period.
template <class Real, bool Tangent> void end_tabulated(Memory<Real>& m, const TabulatedContact<Real>& contact) {
  if constexpr (Tangent) compose(m, contact.ends, contact.Phi[0], contact.Phi[1], contact.Phi[2], contact.Phi[3]);
  m.set(divergence, contact.ends, Real(m[divergence] + contact.divergence));
  m.set(rest, contact.ends, Real(m[rest] - contact.duration));
  leave_barrier<Real, Tangent>(m, contact.ends, contact.v_out, contact.c, contact.s);
}

/// Carries the part of a contact before the end of the period.
template <class Real, bool Tangent> void begin_spanning(Memory<Real>& m, const TabulatedContact<Real>& contact) {
  const auto& Phi = contact.begun_Phi;
  if constexpr (Tangent) compose(m, contact.spans, Phi[0], Phi[1], Phi[2], Phi[3]);
  m.set(divergence, contact.spans, Real(m[divergence] + contact.begun_divergence));
}

/// Carries the part after it: the whole contact without its first part. `before` is the time that was left of the period at
/// entry.
template <class Real, bool Tangent>
void end_spanning(Memory<Real>& m, const Mask<Real>& where, const TabulatedContact<Real>& contact, const Real& before) {
  if constexpr (Tangent) {
    const auto &A = contact.Phi, &B = contact.begun_Phi;
    const Real inverse = 1.0 / select(where, Real(B[0] * B[3] - B[1] * B[2]), Real(1.0));
    compose(m, where, Real(inverse * (A[0] * B[3] - A[1] * B[2])), Real(inverse * (A[1] * B[0] - A[0] * B[1])),
            Real(inverse * (A[2] * B[3] - A[3] * B[2])), Real(inverse * (A[3] * B[0] - A[2] * B[1])));
  }
  m.set(divergence, where, Real(contact.divergence - contact.begun_divergence));
  m.set(rest, where, Real(m[period] - (contact.duration - before)));
  leave_barrier<Real, Tangent>(m, where, contact.v_out, contact.c, contact.s);
}

/// Carries each contact of the job in series steps, as in a period.
template <class Real> void pass_contacts(const ContactJob& job) {
  const WideRegisters until_the_end;
  constexpr std::size_t W = width<Real>;
  Memory<Real> m;
  std::size_t taken = 0;
  for (std::size_t i = 0; i < coefficients; ++i) std::fill_n(m.coefficient[i], W, (*job.coefficients)[i]);
  const double ratio = std::pow(job.tolerance, 1.0 / static_cast<double>(high_order));
  for (;;) {
    for (std::size_t lane = 0; lane < W; ++lane) {
      if (!m.is(lane, Task::idle) || taken == job.count) continue;
      m.motion[lane] = taken;
      const ContactEntry& entry = job.entries[taken++];
      const Mask<Real> here = mask_of<Real>(1U << lane);
      m.set(rest, here, Real(entry.longest));
      m.begin_tangent(here);
      touch(m, here, Real(0.0), Real(entry.v), Real(entry.c), Real(entry.s));
    }
    if (!any(m.is(Task::contact))) return;
    const ContactEnd<Real> up = press<LinearFlight<Real, true, high_order>>(m, job, ratio);
    const unsigned ended = bits(up.at_barrier);
    for_each(up.at_barrier | up.at_end | m.is(Task::given_up), [&](std::size_t lane) {
      ContactExit& exit = job.exits[m.motion[lane]];
      exit.ended = (ended >> lane & 1U) != 0;
      exit.duration = m.field[contact_time][lane];
      exit.y = m.field[depth][lane];
      exit.v = m.field[speed][lane];
      exit.divergence = m.field[divergence][lane];
      for (std::size_t i = 0; i < 4; ++i) exit.Phi[i] = m.field[phi_00 + i][lane];
      m.assign(lane, Task::idle);
    });
  }
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
