// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/system/symmetry.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace graze {

namespace {

/// Number of points at which functions are compared: enough to exclude agreement by chance.
constexpr int points = 24;
/// Rounding error of a field, relative to the compared values.
constexpr double rounding = 1e-11;
constexpr std::size_t max_free_states = 5, most_coordinates = 4;

/// A signed permutation: state i of the image is sign[i] times state from[i].
struct Permutation {
  std::vector<std::size_t> from;
  std::vector<double> sign;

  Vector operator()(const Vector& x) const {
    Vector out(x.size());
    for (std::size_t i = 0; i < from.size(); ++i)
      out[static_cast<Eigen::Index>(i)] = sign[i] * x[static_cast<Eigen::Index>(from[i])];
    return out;
  }
};

/// If a value is not finite at one of the points, it must not be finite at the other either.
bool agree(const Vector& a, const Vector& b) {
  if (!a.allFinite() || !b.allFinite()) return a.allFinite() == b.allFinite();
  return (a - b).lpNorm<Eigen::Infinity>() <= rounding * (1.0 + a.lpNorm<Eigen::Infinity>());
}

class Search {
 public:
  Search(const HybridSystem& system, const Vector& p)
      : system_(system), p_(p), T_(is_forced(system) ? forcing_period(system, p) : 1.0) {
    std::mt19937 generator(1);
    const auto draw = [&generator] { return 2.0 * (static_cast<double>(generator()) / 4294967296.0) - 1.0; };
    for (int i = 0; i < points; ++i) {
      Vector x(static_cast<Eigen::Index>(system.states));
      const double size = std::pow(10.0, draw());
      for (double& one : x) one = size * draw();
      at_.push_back({T_ * draw(), std::move(x)});
    }
    classes_.resize(system.modes.size());
    std::iota(classes_.begin(), classes_.end(), std::size_t{0});
    for (const Event& event : system.events) {
      markers_.push_back(changes_nothing(event));
      if (markers_.back())
        std::replace(classes_.begin(), classes_.end(), std::size_t{classes_[event.to]}, std::size_t{classes_[event.from]});
    }
  }

  /// The symmetries of the whole system, or (not `whole`) of the field of some mode.
  std::vector<Symmetry> all(bool whole) const {
    const auto holds = [&](const Permutation& S, double shift) { return whole ? of_system(S, shift) : of_flight(S, shift); };
    const std::size_t n = system_.states;
    std::vector<Symmetry> out;
    if (n % 2 == 0 && n / 2 <= most_coordinates && has_velocities()) {
      try_permutations(
          n / 2, [](const Permutation& half) { return doubled(half); }, holds, out);
    } else if (n <= max_free_states) {
      try_permutations(
          n, [](const Permutation& one) { return one; }, holds, out);
    } else {
      Permutation minus{std::vector<std::size_t>(n), std::vector<double>(n, -1.0)};
      std::iota(minus.from.begin(), minus.from.end(), std::size_t{0});
      take(minus, holds, out);
    }
    return out;
  }

 private:
  struct Point {
    double t;
    Vector x;
  };

  Vector field(std::size_t mode, double t, const Vector& x) const {
    Vector f(x.size());
    system_.modes[mode].field(t, x, p_, f);
    return f;
  }
  Vector reset(const Event& event, double t, const Vector& x) const {
    if (!event.reset.map) return x;
    Vector out(x.size());
    event.reset.map(t, x, p_, out);
    return out;
  }

  /// True if the second half of the states are the rates of the first in some mode (in others a mass may be held).
  bool has_velocities() const {
    const auto k = static_cast<Eigen::Index>(system_.states / 2);
    for (std::size_t m = 0; m < system_.modes.size(); ++m)
      if (std::all_of(at_.begin(), at_.end(), [&](const Point& at) { return field(m, at.t, at.x).head(k) == at.x.tail(k); }))
        return true;
    return false;
  }

  static Permutation doubled(const Permutation& half) {
    Permutation out = half;
    const std::size_t k = half.from.size();
    for (std::size_t i = 0; i < k; ++i) {
      out.from.push_back(half.from[i] + k);
      out.sign.push_back(half.sign[i]);
    }
    return out;
  }

  template <class Made, class Holds>
  void try_permutations(std::size_t n, const Made& made, const Holds& holds, std::vector<Symmetry>& out) const {
    Permutation one{std::vector<std::size_t>(n), std::vector<double>(n, 1.0)};
    std::iota(one.from.begin(), one.from.end(), std::size_t{0});
    do {
      for (std::size_t signs = 0; signs < (std::size_t{1} << n); ++signs) {
        for (std::size_t i = 0; i < n; ++i) one.sign[i] = (signs >> i & 1U) != 0 ? -1.0 : 1.0;
        take(made(one), holds, out);
      }
    } while (std::next_permutation(one.from.begin(), one.from.end()));
  }

  template <class Holds> void take(const Permutation& S, const Holds& holds, std::vector<Symmetry>& out) const {
    Matrix matrix = Matrix::Zero(static_cast<Eigen::Index>(system_.states), static_cast<Eigen::Index>(system_.states));
    for (std::size_t i = 0; i < S.from.size(); ++i)
      matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(S.from[i])) = S.sign[i];
    for (const double shift : {0.5, 0.0})
      if ((shift == 0.0 || is_forced(system_)) && !(shift == 0.0 && matrix.isIdentity(0.0)) && holds(S, shift))
        out.push_back({matrix, shift});
  }

  bool of_flight(const Permutation& S, double shift) const {
    for (std::size_t m = 0; m < system_.modes.size(); ++m)
      for (std::size_t other = 0; other < system_.modes.size(); ++other)
        if (!at_rest(m) && takes_field(S, shift, m, other)) return true;
    return false;
  }

  bool of_system(const Permutation& S, double shift) const {
    std::vector<std::size_t> image;  // of each mode
    for (std::size_t m = 0; m < system_.modes.size(); ++m) {
      std::size_t found = 0;
      while (found < system_.modes.size() && !takes_mode(S, shift, m, found)) ++found;
      if (found == system_.modes.size()) return false;
      image.push_back(found);
    }
    for (const Event& event : system_.events)
      if (!is_marker(event) && std::none_of(system_.events.begin(), system_.events.end(), [&](const Event& other) {
            return other.kind == event.kind && takes_event(S, shift, event, other, image);
          }))
        return false;
    return true;
  }

  /// True if the field of the mode is zero: it has every symmetry.
  bool at_rest(std::size_t m) const {
    return std::all_of(at_.begin(), at_.end(), [&](const Point& at) { return field(m, at.t, at.x).isZero(0.0); });
  }

  bool takes_field(const Permutation& S, double shift, std::size_t m, std::size_t other) const {
    return std::all_of(at_.begin(), at_.end(),
                       [&](const Point& at) { return agree(S(field(m, at.t, at.x)), field(other, at.t + shift * T_, S(at.x))); });
  }

  /// Among modes with the same field (a mass held at one stop or the other), the guards must match as well.
  bool takes_mode(const Permutation& S, double shift, std::size_t m, std::size_t other) const {
    return takes_field(S, shift, m, other) && events_of(m) == events_of(other) && guards_match(S, shift, m, other);
  }

  /// A section that is only counted.
  bool is_marker(const Event& event) const { return markers_[static_cast<std::size_t>(&event - system_.events.data())]; }

  bool changes_nothing(const Event& event) const {
    return !event.reset.map && std::all_of(at_.begin(), at_.end(), [&](const Point& at) {
      return agree(field(event.from, at.t, at.x), field(event.to, at.t, at.x));
    });
  }

  std::size_t events_of(std::size_t mode) const {
    return static_cast<std::size_t>(std::count_if(system_.events.begin(), system_.events.end(),
                                                  [&](const Event& one) { return one.from == mode && !is_marker(one); }));
  }

  bool guards_match(const Permutation& S, double shift, std::size_t m, std::size_t other) const {
    return std::all_of(system_.events.begin(), system_.events.end(), [&](const Event& event) {
      return event.from != m || is_marker(event) ||
             std::any_of(system_.events.begin(), system_.events.end(), [&](const Event& one) {
               return one.from == other && one.kind == event.kind && takes_guard(S, shift, event, one);
             });
    });
  }

  bool takes_guard(const Permutation& S, double shift, const Event& event, const Event& other) const {
    return std::all_of(at_.begin(), at_.end(), [&](const Point& at) {
      const double a = event.guard.value(at.t, at.x, p_), b = other.guard.value(at.t + shift * T_, S(at.x), p_);
      return agree(Vector{{a}}, Vector{{b}});
    });
  }

  bool takes_event(const Permutation& S, double shift, const Event& event, const Event& other,
                   const std::vector<std::size_t>& image) const {
    if (classes_[other.from] != classes_[image[event.from]] || classes_[other.to] != classes_[image[event.to]]) return false;
    return takes_guard(S, shift, event, other) && std::all_of(at_.begin(), at_.end(), [&](const Point& at) {
             // A reset is valid on the guard only and may set a state there. Its effect on the other states is compared.
             const Vector a = S(reset(event, at.t, at.x)), b = reset(other, at.t + shift * T_, S(at.x));
             return agree(a, b);
           });
  }

  const HybridSystem& system_;
  const Vector& p_;
  double T_;
  std::vector<Point> at_;
  std::vector<bool> markers_;         ///< for each event
  std::vector<std::size_t> classes_;  ///< equal for modes between which there are markers
};

}  // namespace

std::vector<Symmetry> symmetries(const HybridSystem& system, const Vector& p) { return Search(system, p).all(true); }

std::vector<Symmetry> flight_symmetries(const HybridSystem& system, const Vector& p) { return Search(system, p).all(false); }

std::string symmetry_text(const HybridSystem& system, const Symmetry& symmetry) {
  const std::vector<std::string> names = state_names(system);
  std::vector<std::string> image;
  for (Eigen::Index i = 0; i < symmetry.matrix.rows(); ++i)
    for (Eigen::Index j = 0; j < symmetry.matrix.cols(); ++j)
      if (const double s = symmetry.matrix(i, j); s != 0.0)
        image.push_back((s < 0.0 ? "-" : "") + names[static_cast<std::size_t>(j)]);
  return fmt::format("({})(t) -> ({})({})", fmt::join(names, ", "), fmt::join(image, ", "),
                     symmetry.shift == 0.0 ? "t" : "t + T/2");
}

}  // namespace graze
