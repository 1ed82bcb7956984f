// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/tasks/newton_loop.hpp>

#include <cmath>

namespace graze {

namespace newton_detail {

using Residual = std::function<std::optional<double>(const Vector& trial)>;
using Solve = std::function<NewtonStep(const Vector& u, Vector& step)>;

/// (In no unnamed namespace: g++ 12 warns of tasks that hold one's types.)
class FromFunctions : public EquationsAtOnce {
 public:
  FromFunctions(const Residual& residual, const Solve& solve) : residual_(residual), solve_(solve) {}

  std::optional<double> residual(const Vector& trial) const { return residual_(trial); }
  NewtonStep solve(const Vector& u) {
    NewtonStep step = solve_(u, step_);
    if (!step_.allFinite()) step.length = std::nan("");
    return step;
  }

 private:
  const Residual& residual_;
  const Solve& solve_;
};

}  // namespace newton_detail

NewtonReport newton(Vector& u, const newton_detail::Residual& residual, const newton_detail::Solve& solve,
                    const NewtonRule& rule) {
  newton_detail::FromFunctions equations(residual, solve);
  return result_at_once(newton_loop(equations, rule, u));
}

}  // namespace graze
