// SPDX-License-Identifier: GPL-3.0-or-later
// Flow: carries a state through one mode until a time or the mode's first event, with the transition matrix.
//
// Four kinds stand behind one interface: closed form (LinearFlow), regularised Hertz contact (HertzFlow), Taylor series of the
// oscillator with a cubic spring (CubicFlow) and the general integrator (GeneralFlow, GSL). make_flow looks at the mode's
// structure and at FlowOptions::kind once; dispatch is per segment. Over one segment, with t0 and t1 held fixed,
//     dx1 = Phi dx0 + Psi dp,        Phi: n x n, Psi: n x (number of active parameters),
// and `divergence` is the integral of trace(f_x), so that ln det Phi = divergence (Liouville), computed independently.
#pragma once

#include <graze/lib/system/shared_system.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <span>

namespace graze {

/// Method that carries a motion. automatic: the fastest that a mode's structure allows, many motions side by side in SIMD
/// lanes. alone: the same flows, each motion by itself (a check on the lanes). general: the GSL integrator for every mode (an
/// oracle for the others).
enum class FlowKind { automatic, alone, general };
enum class Sensitivity { none, state, state_and_parameters };

struct FlowOptions {
  FlowKind kind = FlowKind::automatic;
  double tolerance = 1e-13;        ///< local error per step, relative to 1 + |x| (numerical flows)
  double max_step = 0.0;           ///< of the general integrator; 0: a sixteenth of the forcing period, or unlimited
  std::size_t max_steps = 100000;  ///< of one segment; more is FlowEnd::failed
  /// Remaining time of an impact series below which it counts as complete (the error of its sum is of the order of the square). A
  /// forcing period T < 1 is the unit.
  double accumulation_window = 1e-6;
  /// Called before every segment; may be empty. If it returns true, the run (simulate, carry) ends as Termination::interrupted.
  std::function<bool()> cancelled = {};
};

/// @throws std::invalid_argument naming the option, its value and its range.
void validate(const FlowOptions& options);

enum class FlowEnd { failed, time, event };

/// One stretch of motion in one mode.
struct Segment {
  std::size_t mode = 0;
  double t0 = 0.0, t1 = 0.0;
  Vector x0, x1;
  Matrix Phi;               ///< n x n, if asked for
  Matrix Psi;               ///< n x active parameters, if asked for
  double divergence = 0.0;  ///< integral of trace(f_x) over the segment, if Phi was asked for
  FlowEnd end = FlowEnd::failed;
  std::size_t event = 0;        ///< index in HybridSystem::events, where end is event
  std::size_t evaluations = 0;  ///< of the field (or of the closed form)
};

/// Input of Flow::carry.
struct FlowTask {
  double t0 = 0.0;
  double t_end = 0.0;
  Sensitivity sensitivity = Sensitivity::none;
  bool watch_events = true;  ///< false: the mode's guards are ignored
};

class LinearFlow;
class HertzFlow;
class CubicFlow;
class GeneralFlow;

class Flow {
 public:
  Flow(Flow&&) noexcept;
  Flow& operator=(Flow&&) noexcept;
  ~Flow();

  /// Carries x0 from task.t0 to task.t_end or to the first event after t0, and writes `out` (its storage is reused).
  void carry(const FlowTask& task, const Vector& x0, Segment& out);
  /// f(t, x) of the mode.
  void field(double t, const Vector& x, Vector& out) const;
  /// "closed form", "regularised Hertz contact", "Taylor series" or "general".
  const char* kind() const;

 private:
  struct Kind;
  explicit Flow(std::unique_ptr<Kind> kind);
  friend Flow make_flow(const SharedSystem&, std::size_t, const Vector&, std::span<const std::size_t>, const FlowOptions&);
  std::unique_ptr<Kind> kind_;
};

/// The flow of one mode at parameters p; `active` are the parameters for which Psi is wanted. It holds the system.
Flow make_flow(const SharedSystem& system, std::size_t mode, const Vector& p, std::span<const std::size_t> active,
               const FlowOptions& options = {});

}  // namespace graze
