// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/transition.hpp>

#include <cmath>

namespace graze {

namespace {

double log_abs_det(const Matrix& matrix) {
  const double det = matrix.rows() == 2 ? matrix(0, 0) * matrix(1, 1) - matrix(0, 1) * matrix(1, 0) : matrix.determinant();
  return std::log(std::abs(det));
}

}  // namespace

void carry(Propagator& propagator, double t0, double t1, const Vector& x0, const TransitionOptions& options, Transition& out) {
  const HybridSystem& system = propagator.system();
  const auto n = static_cast<Eigen::Index>(system.states);
  const bool tangent = options.sensitivity != Sensitivity::none;
  const Eigen::Index m =
      options.sensitivity == Sensitivity::state_and_parameters ? static_cast<Eigen::Index>(propagator.active().size()) : 0;
  out.termination = Termination::failed;
  out.factors.clear();
  out.events.clear();
  out.event_sequence.clear();
  out.log_det = out.liouville = 0.0;
  if (tangent) {
    out.Phi.setIdentity(n, n);
    out.Psi.setZero(n, m);
  }
  HybridState state{t0, x0, 0};
  if (!x0.allFinite()) {
    out.termination = Termination::inadmissible_start;
    return;
  }
  if (system.initial_mode) {
    const std::optional<std::size_t> mode = system.initial_mode(t0, x0, propagator.parameters());
    if (!mode) {
      out.termination = Termination::inadmissible_start;
      return;
    }
    state.mode = *mode;
  }
  out.mode0 = state.mode;
  for (;;) {
    const StepEnd end = propagator.step(state, t1, options.sensitivity);
    if (end == StepEnd::failed) {
      out.termination = Termination::integration_failed;
      return;
    }
    const Segment& segment = propagator.segment();
    if (tangent) {
      out.Phi = segment.Phi * out.Phi;
      if (m > 0) out.Psi = segment.Phi * out.Psi + segment.Psi;
      out.log_det += log_abs_det(segment.Phi);
      out.liouville += segment.divergence;
      if (options.keep_factors) out.factors.push_back(segment.Phi);
    }
    if (end == StepEnd::time) break;
    const EventRecord& record = propagator.record();
    out.event_sequence.push_back(record.event);
    if (options.keep_events) out.events.push_back(record);
    if (tangent) {
      const SaltationMatrix& saltation = record.saltation;
      if (!saltation.regular) {
        out.termination = Termination::grazing;
        return;
      }
      out.Phi = saltation.S * out.Phi;
      if (m > 0) out.Psi = saltation.S * out.Psi + saltation.Sp;
      if (!system.events[record.event].continuous) {
        const double volume = log_abs_det(saltation.S);
        out.log_det += volume;
        const auto& known = system.events[record.event].log_volume_change;
        out.liouville += known && record.kind != EventKind::stick ? known(propagator.parameters()) : volume;
        if (options.keep_factors) out.factors.push_back(saltation.S);
      }
    }
    if (out.event_sequence.size() >= options.max_events) {
      out.termination = Termination::event_limit;
      return;
    }
  }
  out.x1 = state.x;
  out.mode1 = state.mode;
  out.termination = Termination::time;
}

}  // namespace graze
