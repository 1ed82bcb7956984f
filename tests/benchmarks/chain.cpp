// SPDX-License-Identifier: GPL-3.0-or-later
// Cost of a forcing period with its sensitivity as a function of the number of states. A chain of masses in front of a rigid
// stop (baselines/chain.hpp) is a user-defined system for graze, which uses its general flow.
#include "baselines/chain.hpp"
#include "solvers.hpp"
#include "support/rigid_stop.hpp"

namespace benchmarks {
namespace {

using namespace graze;
using baselines::ChainField;

HybridSystem chain_system(Eigen::Index masses) {
  enum : Eigen::Index { b, kappa, xi, eta, r, k_r };
  using support::detail::parameter;
  HybridSystem system;
  system.name = "chain";
  system.states = static_cast<std::size_t>(2 * masses);
  system.parameters = {parameter("b", 0.05, 0.0),          parameter("kappa", 0.5, 0.0), parameter("xi", 1.0),
                       parameter("eta", 0.711, 0.0, true), parameter("r", 1.0),          parameter("k_r", 0.8, 0.0, false, 1.0)};
  system.forcing_frequency = eta;
  Mode mode;
  mode.name = "free";
  mode.field = [masses](double t, const Vector& x, const Vector& p, Vector& f) {
    for (Eigen::Index i = 0; i < masses; ++i) {
      const double here = x[2 * i];
      double a = -2.0 * p[b] * x[2 * i + 1] - here;
      if (i > 0) a -= p[kappa] * (here - x[2 * i - 2]);
      if (i + 1 < masses) a -= p[kappa] * (here - x[2 * i + 2]);
      f[2 * i] = x[2 * i + 1];
      f[2 * i + 1] = a;
    }
    f[1] += p[xi] * std::cos(p[eta] * t);
  };
  mode.field_dx = [masses](double, const Vector&, const Vector& p, Matrix& J) {
    J.setZero();
    for (Eigen::Index i = 0; i < masses; ++i) {
      J(2 * i, 2 * i + 1) = 1.0;
      J(2 * i + 1, 2 * i + 1) = -2.0 * p[b];
      J(2 * i + 1, 2 * i) = -1.0;
      for (const Eigen::Index j : {i - 1, i + 1})
        if (j >= 0 && j < masses) {
          J(2 * i + 1, 2 * i) -= p[kappa];
          J(2 * i + 1, 2 * j) = p[kappa];
        }
    }
  };
  mode.field_dp = [](double, const Vector&, const Vector&, Matrix& J) { J.setZero(); };  // not used here
  mode.field_dt = [](double t, const Vector&, const Vector& p, Vector& f) {
    f.setZero();
    f[1] = -p[xi] * p[eta] * std::sin(p[eta] * t);
  };
  system.modes = {mode};
  system.events = {support::detail::rigid_stop("impact", 0, r, k_r, 1.0)};
  return system;
}

struct Result {
  Vector x;
  Matrix Phi;
  int impacts = 0;
  bool failed = true;
};

class GrazeChain {
 public:
  GrazeChain(Eigen::Index masses, double tolerance)
      : system_(chain_system(masses)), p_(default_parameters(system_.parameters)), T_(forcing_period(system_, p_)),
        propagator_(system_, p_, {}, {.tolerance = tolerance}) {}
  void period(const Vector& x, Result& out) {
    carry(propagator_, 0.0, T_, x, {.sensitivity = Sensitivity::state}, transition_);
    out.x = transition_.x1;
    out.Phi = transition_.Phi;
    out.impacts = static_cast<int>(transition_.event_sequence.size());
    out.failed = transition_.termination != Termination::time;
  }

 private:
  HybridSystem system_;
  Vector p_;
  double T_;
  Propagator propagator_;
  Transition transition_;
};

template <std::size_t masses, class Baseline> class BaselineChain {
  using Field = ChainField<masses, true>;

 public:
  explicit BaselineChain(double tolerance) : baseline_(p_, tolerance, Watch::located) {}
  void period(const Vector& x, Result& out) {
    std::copy_n(x.data(), Field::states, u_.begin());
    std::fill(u_.begin() + Field::states, u_.end(), 0.0);
    for (std::size_t i = 0; i < Field::states; ++i) u_[Field::states * (i + 1) + i] = 1.0;
    const baselines::Run run = baselines::run<Law::newton, Field::size>(baseline_, p_, 0.0, 2.0 * M_PI / p_.eta, u_);
    constexpr auto n = static_cast<Eigen::Index>(Field::states);
    out.x = Eigen::Map<const Vector>(u_.data(), n);
    out.Phi = Eigen::Map<const Eigen::Matrix<double, n, n>>(u_.data() + n);
    out.impacts = run.impacts;
    out.failed = run.failed;
  }

 private:
  typename Field::Parameters p_;
  Baseline baseline_;
  baselines::State<Field::size> u_{};
};

/// 50 forcing periods on the attractor, with the exact final states from the general flow at 1e-14. The baselines agree with
/// it within 1e-10.
struct Known {
  std::vector<Vector> starts;
  std::vector<Result> exact;
};
const Known& known(Eigen::Index masses) {
  static std::map<Eigen::Index, Known> all;
  Known& out = all[masses];
  if (!out.starts.empty()) return out;
  GrazeChain solver(masses, 1e-14);
  Vector x = Vector::Zero(2 * masses);
  Result result;
  for (int k = 0; k < 150; ++k, x = result.x) {
    solver.period(x, result);
    if (k < 100) continue;
    out.starts.push_back(x);
    out.exact.push_back(result);
  }
  return out;
}

/// The larger of the errors of the state, relative to 1 + |x|, and of the sensitivity, relative to its norm.
double error(const Result& a, const Result& b) {
  const double state = (a.x - b.x).cwiseAbs().maxCoeff() / (1.0 + b.x.cwiseAbs().maxCoeff());
  return std::max(state, (a.Phi - b.Phi).cwiseAbs().maxCoeff() / std::max(1.0, b.Phi.cwiseAbs().maxCoeff()));
}

template <class Make> Accuracy accuracy_at(Eigen::Index masses, const Make& make, double tolerance) {
  auto solver = make(tolerance);
  std::vector<double> errors;
  int miscounted = 0;
  Result out;
  for (std::size_t i = 0; i < known(masses).starts.size(); ++i) {
    solver.period(known(masses).starts[i], out);
    const Result& exact = known(masses).exact[i];
    if (out.failed || out.impacts != exact.impacts)
      ++miscounted;
    else
      errors.push_back(error(out, exact));
  }
  return summarise(tolerance, std::move(errors), miscounted);
}

template <class Make> void states(benchmark::State& state, Eigen::Index masses, const Make& make) {
  static const Accuracy accuracy = tuned(  // once: Make is a separate type for each solver and number of masses
      [&](double tolerance) { return accuracy_at(masses, make, tolerance); });
  auto solver = make(accuracy.tolerance);
  Result out;
  int struck = 0;
  for (const Vector& start : known(masses).starts) {
    solver.period(start, out);
    if (out.failed) return state.SkipWithError("failed");
    struck += out.impacts;
  }
  for (auto _ : state)
    for (const Vector& start : known(masses).starts) {
      solver.period(start, out);
      benchmark::DoNotOptimize(out.x.data());
    }
  per_item(state, known(masses).starts.size());
  report(state, accuracy);
  state.counters["wrong"] = accuracy.miscounted;
  state.counters["impacts"] = static_cast<double>(struck) / static_cast<double>(known(masses).starts.size());
}

template <Eigen::Index masses> void register_chain() {
  constexpr auto m = static_cast<std::size_t>(masses);
  const auto add = [](const std::string& name, const auto& make) {
    benchmark::RegisterBenchmark(("states/n=" + std::to_string(2 * masses) + "/" + name).c_str(),
                                 [make](benchmark::State& state) { states(state, masses, make); });
  };
  using Whole = ChainField<m, true>;
  using Motion = ChainField<m, false>;
  add("graze", [](double tolerance) { return GrazeChain(masses, tolerance); });
  add("gsl-rk8pd", [](double tolerance) { return BaselineChain<m, baselines::GslRk8pdOf<Whole, Motion>>(tolerance); });
  add("boost-dopri5", [](double tolerance) { return BaselineChain<m, baselines::BoostDopri5Of<Whole>>(tolerance); });
}

const bool registered = [] {
  register_chain<1>();
  register_chain<2>();
  register_chain<4>();
  register_chain<8>();
  return true;
}();

}  // namespace
}  // namespace benchmarks
