// SPDX-License-Identifier: GPL-3.0-or-later
// UZ: a scalar of the orbit, given by the user, is zero. Located by Newton's method on H(u) = 0, g(u) = 0. The gradient of g is
// formed by central differences, because g is known as a function of the orbit only.
#include <graze/continuation/conditions/test_function.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

namespace graze {

namespace {

using Scalar = std::function<double(const BranchPoint& point)>;

class ZeroOfScalar : public DefiningEquations {
 public:
  explicit ZeroOfScalar(Scalar scalar) : scalar_(std::move(scalar)) {}

  bool evaluate(BranchProblem& problem, const Vector& u, Vector& F, Matrix* jacobian) override {
    constexpr double difference_step = 1e-6;
    const Eigen::Index unknowns = problem.unknowns(), equations = problem.orbit_unknowns();
    Vector H;
    Matrix H_u;
    if (!problem.zero_problem().evaluate(u, H, jacobian ? &H_u : nullptr)) return false;
    const auto g = [&](const Vector& at) { return scalar_(problem.branch_point(at, 0.0)); };
    F.resize(equations + 1);
    F << H, g(u);
    if (!jacobian) return true;
    if (!(scale_ > 0.0)) scale_ = problem.state_scale(u);
    jacobian->resize(equations + 1, unknowns);
    jacobian->topRows(equations) = H_u;
    double g_size = 1.0;
    for (Eigen::Index i = 0; i < unknowns; ++i) {
      const double h = difference_step * problem.size_of_unknown(u, i);
      const double slope = (g(u + h * Vector::Unit(unknowns, i)) - g(u - h * Vector::Unit(unknowns, i))) / (2.0 * h);
      (*jacobian)(equations, i) = slope;
      g_size = std::max(g_size, std::abs(slope) * (i < equations ? scale_ : problem.unit() * scale_));
    }
    sizes_ = Vector::Constant(equations + 1, scale_);
    sizes_[equations] = g_size;
    return true;
  }

  Vector sizes() const override { return sizes_; }
  NewtonRule rule() const override { return newton_to_rounding(1e-10, 1e-13); }

 private:
  Scalar scalar_;
  double scale_ = 0.0;
  Vector sizes_;
};

}  // namespace

TestFunction zero_test(std::string name, const Scalar& scalar) {
  TestFunction test;
  test.type = PointType::UZ;
  test.summary = "a scalar given by the user is zero: " + name;
  test.value = [scalar](const TestPoint& point) { return scalar(point.branch); };
  test.confirm = [](const TestPoint&, const TestPoint&) { return true; };
  test.distance = [](const BranchPoint&) { return std::numeric_limits<double>::infinity(); };
  test.equations = [scalar](const TestPoint&) { return std::make_unique<ZeroOfScalar>(scalar); };
  test.condition = std::move(name);
  return test;
}

}  // namespace graze
