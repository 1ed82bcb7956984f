// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/mechanics.hpp>

#include <graze/lib/equations/functions.hpp>
#include <graze/lib/equations/polynomial.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace graze::equations {

Expression rate_along(Graph& graph, Expression e, const std::function<Expression(std::size_t state)>& field) {
  Expression sum = graph.derivative(e, graph.time());
  for (const std::size_t i : dependence(graph, e).states) {
    const Expression slope = graph.derivative(e, graph.state(i));
    if (!graph.is_constant(slope, 0.0)) sum = graph.add(sum, graph.multiply(slope, field(i)));
  }
  return sum;
}

Expression rate_along(Graph& graph, Expression e, const std::vector<Expression>& field) {
  return rate_along(graph, e, [&](std::size_t i) { return field[i]; });
}

std::optional<Solution> solve_constraint(const Names& names, Expression e, const std::function<bool(std::size_t)>& allowed) {
  Graph& graph = names.graph;
  if (const auto found = solve_guard(graph, e, names.symbols.states.size(), allowed)) return found;
  for (const std::size_t i : dependence(graph, e).states) {
    if (!allowed(i)) continue;
    const Expression slope = normal_form(graph, graph.derivative(e, graph.state(i)));
    const Bounds range = bounds(graph, slope, names.parameters);
    if (dependence(graph, slope).moves() || !(range.lower > 0.0 || range.upper < 0.0)) continue;
    const Expression rest = graph.substitute(e, {{graph.state(i).index, graph.constant(0.0)}});
    return Solution{i, normal_form(graph, graph.negate(graph.divide(rest, slope)))};
  }
  return std::nullopt;
}

namespace {

using Column = std::vector<Expression>;
using Square = std::vector<Column>;  // rows

/// A pivot below this fraction of the diagonal is rounding error: the matrix is singular.
constexpr double smallest_pivot = 1e-12;
/// Number of nodes up to which an expression is expanded.
constexpr std::size_t longest_tidied = 100;
/// Relative tolerance for the entries of a symmetric matrix.
constexpr double symmetry_tolerance = 1e-12;

enum Status : int { open = 0, closed = 1, apart = 2 };        // of a stop
enum Sliding : int { forward = 0, backward = 1, stuck = 2 };  // of friction

struct Contact {
  Text name;
  bool is_stop = true, rigid = false;
  int states = 2;
  std::size_t count = 0;
  Place where, law;                              ///< places of its gap or speed, and of its law
  Expression gap = {};                           ///< of a stop
  Expression rate = {};                          ///< gap' or the sliding speed
  Column direction;                              ///< gradient of the rate in the velocities
  Column response;                               ///< M^-1 direction
  Column share;                                  ///< response / (direction . response)
  Expression compliance = {};                    ///< direction . response: inverse of the effective mass at the stop
  Expression force = {};                         ///< of a stop with a force law
  bool begins_softly = false;                    ///< the force vanishes where the gap opens
  Expression restitution = {};                   ///< of a rigid stop
  std::optional<Expression> slip_force[2] = {};  ///< mu(u) N, forward and backward
  Expression limit = {};                         ///< static coefficient times N
  bool same_limit = false;                       ///< the limit of slow sliding equals the static limit
};

struct Combination {
  std::vector<int> status;
  std::size_t mode = 0;
  std::vector<std::size_t> constraints;  ///< numbers of the constraining contacts
  Column acceleration;                   ///< with multipliers, before any replacement
  Column multiplier;                     ///< of each constraint
  std::vector<Solution> solved;
  Replacement replacement;  ///< the same as a map
};

class Mechanics {
 public:
  explicit Mechanics(Names& names)
      : names_(names), scope_(names.scope(true)), graph_(names.graph), text_(names.text), input_(*text_.mechanics),
        n_(input_.coordinates.size()) {}

  Pieces make() {
    read_matrices();
    for (const StopText& stop : text_.stops) read_stop(stop);
    for (const FrictionText& friction : text_.friction) read_friction(friction);
    combine();
    for (const Combination& at : combinations_) make_mode(at);
    for (const Combination& at : combinations_) {
      for (std::size_t c = 0; c < contacts_.size(); ++c) {
        make_events(at, c);
        make_surfaces(at, c);
      }
    }
    return std::move(out_);
  }

 private:
  Expression q(std::size_t i) const { return graph_.state(i); }
  Expression v(std::size_t i) const { return graph_.state(n_ + i); }
  Expression zero() const { return graph_.constant(0.0); }
  Expression dot(const Column& a, const Column& b) const {
    Expression sum = zero();
    for (std::size_t i = 0; i < a.size(); ++i) sum = graph_.add(sum, graph_.multiply(a[i], b[i]));
    return sum;
  }
  /// (v, a)
  Column field_of(const Column& acceleration) const {
    Column out;
    for (std::size_t i = 0; i < n_; ++i) out.push_back(v(i));
    out.insert(out.end(), acceleration.begin(), acceleration.end());
    return out;
  }
  bool has_velocity(Expression e) const {
    const auto on = dependence(graph_, e).states;
    return !on.empty() && on.back() >= n_;
  }
  const std::string& velocity_in(Expression e) const { return names_.symbols.states[dependence(graph_, e).states.back()]; }

  Vector probe() const {
    if (names_.start) return *names_.start;
    Vector x(static_cast<Eigen::Index>(2 * n_));
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = 0.1 * static_cast<double>(i + 1);
    return x;
  }
  void not_negative(Expression e, const Text& text, const std::string& what) const {
    const Node& node = graph_.node(e);
    if (node.operation == Operation::constant && node.value < 0.0)
      names_.refuse(text.place, fmt::format("the {} is {}; allowed is >= 0", what, text.text));
  }

  /// The normal form, unless the expression is long.
  Expression tidy(Expression e) const { return reachable(graph_, e).size() > longest_tidied ? e : normal_form(graph_, e); }
  /// True if the expression vanishes identically; a nonzero value is the faster proof that it does not.
  bool vanishes(Expression e) const {
    constexpr double rounding = 1e-9;
    return !(std::abs(value(e)) > rounding) && is_zero(graph_, e);
  }
  double value(Expression e) const { return values(graph_, {&e, 1}, 0.0, probe(), names_.defaults)[0]; }

  // Reading ------------------------------------------------------------------------------------------------------------------

  /// Replaces the rates of coordinates, of expressions in them, and of names in `known`; an acceleration is refused.
  Expression without_rates(Expression e, const Place& place, const std::string& where, Replacement known = {}) const {
    if (!dependence(graph_, e).rate) return e;
    const Column field = field_of(Column(n_, zero()));
    for (const Expression part : reachable(graph_, e)) {
      const Node node = graph_.node(part);
      if (node.operation != Operation::rate || known.contains(part.index)) continue;
      const Expression of = graph_.substitute(node.a, known);
      if (has_velocity(of))
        names_.refuse(known_place(graph_, names_.hazards, part).value_or(place),
                      fmt::format("an acceleration, the rate of {}, stands {}", velocity_in(of), where));
      known.emplace(part.index, rate_along(graph_, of, field));
    }
    return graph_.substitute(e, known);
  }

  Expression read(const Text& text, const std::string& where, const Scope& names) const {
    const Expression raw = parse_expression(graph_, text_.source, text, names, where, &names_.hazards);
    return without_rates(raw, text.place, where);
  }
  Expression read(const Text& text, const std::string& where) const { return read(text, where, scope_); }

  /// The known names and one more. If the file already defines that name, it cannot be used.
  Scope with(const std::string& name, Expression meaning) const {
    Scope out = scope_;
    const bool is_taken = out.find(name).has_value();
    out.find = [find = scope_.find, name, meaning, is_taken](std::string_view one) {
      return one != name ? find(one) : is_taken ? std::nullopt : std::optional(meaning);
    };
    if (is_taken)
      out.refusal = [refusal = scope_.refusal, name](std::string_view one) {
        if (one == name)
          return fmt::format("the name '{}' has a meaning of its own, and another one in the file, which must be renamed,", name);
        return refusal ? refusal(one) : std::string();
      };
    out.names.push_back(name);
    return out;
  }

  Square read_matrix(const std::vector<std::vector<Text>>& rows, const char* kind) const {
    const Place first = rows.empty() || rows[0].empty() ? input_.place : rows[0][0].place;
    if (rows.size() != n_)
      names_.refuse(first, fmt::format("the {} matrix has {} rows; there are {} coordinates", kind, rows.size(), n_));
    Square out;
    for (std::size_t i = 0; i < n_; ++i) {
      if (rows[i].size() != n_)
        names_.refuse(
            rows[i].empty() ? first : rows[i][0].place,
            fmt::format("row {} of the {} matrix has {} entries; there are {} coordinates", i + 1, kind, rows[i].size(), n_));
      out.emplace_back();
      for (std::size_t j = 0; j < n_; ++j)
        out.back().push_back(read(rows[i][j], fmt::format("in the {} matrix, row {}, column {}", kind, i + 1, j + 1)));
    }
    return out;
  }

  void read_matrices() {
    const Square mass = read_matrix(input_.mass, "mass");
    for (std::size_t i = 0; i < n_; ++i) {
      for (std::size_t j = 0; j < n_; ++j) {
        const Dependence on = dependence(graph_, mass[i][j]);
        const Place& place = input_.mass[i][j].place;
        if (has_velocity(mass[i][j]))
          names_.refuse(place, fmt::format("the mass matrix depends on the velocity {}", velocity_in(mass[i][j])));
        if (on.time) names_.refuse(place, "the mass matrix depends on the time");
        if (j < i && !is_zero(graph_, graph_.subtract(mass[i][j], mass[j][i]))) {
          const double a = value(mass[i][j]), b = value(mass[j][i]);
          if (!(std::abs(a - b) <= symmetry_tolerance * (std::abs(a) + std::abs(b))))
            names_.refuse(
                place, fmt::format("the mass matrix is not symmetric: row {}, column {} is {:.6g}, row {}, column {} is {:.6g}",
                                   i + 1, j + 1, a, j + 1, i + 1, b));
        }
      }
    }
    Square identity(n_, Column(n_, zero()));
    for (std::size_t i = 0; i < n_; ++i) identity[i][i] = graph_.constant(1.0);
    std::size_t row = 0;
    const auto inverse = solve(mass, identity, &row);
    if (!inverse)
      names_.refuse(input_.mass[row][row].place,
                    fmt::format("the mass matrix is singular or not positive definite {} (row {})",
                                names_.start ? "at the start" : "at the default parameters", row + 1));
    inverse_ = *inverse;

    if (!input_.force.empty() && input_.force.size() != n_)
      names_.refuse(input_.force[0].place, fmt::format("there are {} forces and {} coordinates", input_.force.size(), n_));
    const Square damping = input_.damping.empty() ? Square() : read_matrix(input_.damping, "damping");
    const Square stiffness = input_.stiffness.empty() ? Square() : read_matrix(input_.stiffness, "stiffness");
    for (std::size_t i = 0; i < n_; ++i) {
      Expression sum =
          input_.force.empty() ? zero() : read(input_.force[i], fmt::format("in the force on {}", input_.coordinates[i].text));
      for (std::size_t j = 0; j < n_ && !damping.empty(); ++j) sum = graph_.subtract(sum, graph_.multiply(damping[i][j], v(j)));
      for (std::size_t j = 0; j < n_ && !stiffness.empty(); ++j)
        sum = graph_.subtract(sum, graph_.multiply(stiffness[i][j], q(j)));
      force_.push_back(sum);
    }
  }

  /// X with A X = B for a positive definite A; nullopt: A is not positive definite, in row `row`.
  std::optional<Square> solve(Square A, Square B, std::size_t* row = nullptr) const {
    const std::size_t size = A.size();
    std::vector<double> diagonal;
    for (std::size_t i = 0; i < size; ++i) diagonal.push_back(value(A[i][i]));
    const auto eliminate = [&](std::size_t i, std::size_t k) {
      if (graph_.is_constant(A[i][k], 0.0)) return;
      const Expression factor = graph_.divide(A[i][k], A[k][k]);
      for (std::size_t j = k; j < size; ++j) A[i][j] = graph_.subtract(A[i][j], graph_.multiply(factor, A[k][j]));
      for (Expression& one : B[i]) {
        const auto column = static_cast<std::size_t>(&one - B[i].data());
        one = graph_.subtract(one, graph_.multiply(factor, B[k][column]));
      }
    };
    for (std::size_t k = 0; k < size; ++k) {
      if (row) *row = k;
      const double pivot = value(A[k][k]);
      if (!(pivot > smallest_pivot * std::abs(diagonal[k]))) return std::nullopt;
      for (std::size_t i = k + 1; i < size; ++i) eliminate(i, k);
    }
    for (std::size_t k = size; k-- > 0;) {
      for (std::size_t i = 0; i < k; ++i) eliminate(i, k);
      for (Expression& one : B[k]) one = graph_.divide(one, A[k][k]);
    }
    return B;
  }

  /// Computes direction, response and the quantities that follow from them.
  void finish(Contact& contact) const {
    for (std::size_t i = 0; i < n_; ++i) contact.direction.push_back(graph_.derivative(contact.rate, v(i)));
    for (std::size_t i = 0; i < n_; ++i) contact.response.push_back(tidy(dot(inverse_[i], contact.direction)));
    contact.compliance = tidy(dot(contact.direction, contact.response));
    for (const Expression one : contact.response) contact.share.push_back(tidy(graph_.divide(one, contact.compliance)));
  }

  void check_name(const Text& name, const char* kind) {
    if (name.text.empty()) names_.refuse(name.place, fmt::format("a {} without a name", kind));
    for (const Contact& other : contacts_)
      if (other.name.text == name.text)
        names_.refuse(name.place, fmt::format("a stop or friction called '{}' exists already", name.text));
  }

  void read_stop(const StopText& text) {
    check_name(text.name, "stop");
    const std::string& name = text.name.text;
    Contact stop;
    stop.name = text.name;
    stop.count = text.count;
    stop.where = text.gap.place;
    stop.law = text.law.place;
    stop.gap = read(text.gap, fmt::format("in the gap of {}", name));
    if (has_velocity(stop.gap))
      names_.refuse(text.gap.place, fmt::format("the gap of {} depends on the velocity {}", name, velocity_in(stop.gap)));
    if (dependence(graph_, stop.gap).states.empty() || is_zero(graph_, stop.gap))
      names_.refuse(text.gap.place, fmt::format("the gap of {} depends on no coordinate", name));
    stop.rate = rate_along(graph_, stop.gap, field_of(Column(n_, zero())));
    finish(stop);
    if (is_zero(graph_, stop.compliance))
      names_.refuse(text.gap.place, fmt::format("the gap of {} depends on no coordinate", name));
    read_law(text, stop);
    contacts_.push_back(std::move(stop));
  }

  void read_law(const StopText& text, Contact& stop) const {
    struct Law {
      std::string name;
      std::size_t least, most;
      const char* values;
    };
    static const std::vector<Law> laws = {{"newton", 1, 1, "k_r"},
                                          {"hertz", 1, 2, "k_H and b_H, or k_H"},
                                          {"linear", 1, 2, "k and c, or k"},
                                          {"force", 1, 1, "the force as an expression of d and d'"}};
    const std::string& name = text.name.text;
    const auto law = std::find_if(laws.begin(), laws.end(), [&](const Law& one) { return one.name == text.law.text; });
    if (law == laws.end()) {
      std::vector<std::string> known;
      for (const Law& one : laws) known.push_back(one.name);
      names_.refuse(text.law.place, fmt::format("the stop {} has an unknown law '{}'{}", name, text.law.text,
                                                suggestion_or_list(text.law.text, known)));
    }
    if (text.values.size() < law->least || text.values.size() > law->most)
      names_.refuse(text.law.place, fmt::format("the law {} of the stop {} has {} values; it takes {}", law->name, name,
                                                text.values.size(), law->values));
    const std::string where = fmt::format("in the law of {}", name);
    // Depth and its rate are symbols of their own until the law is known.
    const Expression d = graph_.state(2 * n_), d_rate = graph_.state(2 * n_ + 1);
    const Expression depth = graph_.negate(stop.gap), depth_rate = graph_.negate(stop.rate);
    if (law->name == "newton") {
      stop.rigid = true;
      stop.restitution = read(text.values[0], where);
      const Node node = graph_.node(stop.restitution);
      if (node.operation == Operation::constant && !(node.value >= 0.0 && node.value <= 1.0))
        names_.refuse(text.values[0].place,
                      fmt::format("the restitution of the stop {} is {}; allowed is 0 to 1", name, text.values[0].text));
      return;
    }
    Expression force;
    if (law->name == "force") {
      const Scope names = with("d", d);
      const Expression raw = parse_expression(graph_, text_.source, text.values[0], names, where, &names_.hazards);
      force = without_rates(raw, text.values[0].place, where, {{graph_.rate(d).index, d_rate}});
      Replacement powers;
      for (const Expression part : reachable(graph_, force)) {
        const Node node = graph_.node(part);
        if (node.operation != Operation::power || node.a != d) continue;
        const Node exponent = graph_.node(node.b);
        if (exponent.operation == Operation::constant && exponent.value >= 1.0)
          powers.emplace(part.index, graph_.contact_power(d, exponent.value));
      }
      force = graph_.substitute(force, powers);
    } else {
      Column coefficients;
      for (const Text& one : text.values) coefficients.push_back(read(one, where));
      const bool hertz = law->name == "hertz";
      not_negative(coefficients[0], text.values[0], fmt::format("stiffness {} of the stop {}", hertz ? "k_H" : "k", name));
      const Expression elastic = graph_.multiply(coefficients[0], hertz ? graph_.contact_power(d, 1.5) : d);
      force = elastic;
      if (coefficients.size() > 1) {
        not_negative(coefficients[1], text.values[1], fmt::format("damping {} of the stop {}", hertz ? "b_H" : "c", name));
        const Expression damping = graph_.multiply(coefficients[1], d_rate);
        force = hertz ? graph_.multiply(elastic, graph_.add(graph_.constant(1.0), damping)) : graph_.add(elastic, damping);
      }
    }
    const Expression at_opening = graph_.substitute(force, {{d.index, zero()}});
    stop.begins_softly = is_zero(graph_, at_opening);
    if (!text.adhesion && !stop.begins_softly) stop.states = 3;
    const Replacement motion{{d.index, depth}, {d_rate.index, depth_rate}};
    stop.force = graph_.substitute(force, motion);
  }

  /// Whether the speed of one friction is a constant multiple of that of the other.
  bool slides_with(const Contact& friction, const Contact& other) const {
    std::size_t k = 0;
    while (k < n_ && vanishes(other.direction[k])) ++k;
    if (k == n_) return false;
    const auto proportional = [&](Expression a, Expression b) {
      return vanishes(graph_.subtract(graph_.multiply(a, other.direction[k]), graph_.multiply(b, friction.direction[k])));
    };
    for (std::size_t i = 0; i < n_; ++i)
      if (!proportional(friction.direction[i], other.direction[i])) return false;
    return proportional(friction.rate, other.rate);
  }

  void read_friction(const FrictionText& text) {
    check_name(text.name, "friction");
    const std::string& name = text.name.text;
    Contact friction;
    friction.name = text.name;
    friction.count = text.count;
    friction.is_stop = false;
    friction.states = 3;
    friction.where = text.speed.place;
    friction.law = text.law.place;
    friction.rate = read(text.speed, fmt::format("in the speed of {}", name));
    if (!has_velocity(friction.rate))
      names_.refuse(text.speed.place, fmt::format("the speed of {} depends on no velocity", name));
    finish(friction);
    for (const Expression one : friction.direction)
      if (has_velocity(one))
        names_.refuse(text.speed.place, fmt::format("the speed of {} is not linear in {}", name, velocity_in(one)));
    for (const Contact& other : contacts_)
      if (!other.is_stop && slides_with(friction, other))
        names_.refuse(text.speed.place,
                      fmt::format("{} slides whenever {} does, at the same speed or a multiple of it: which of them holds is "
                                  "not determined; write one friction with the sum of their forces",
                                  name, other.name.text));
    const Expression normal = read(text.normal, fmt::format("in the normal force of {}", name));
    not_negative(normal, text.normal, fmt::format("normal force of the friction {}", name));
    const std::string where = fmt::format("in the law of {}", name);
    const auto coefficient = [&](Expression u) { return read(text.law, where, with("u", u)); };
    friction.slip_force[forward] = graph_.multiply(coefficient(friction.rate), normal);
    friction.slip_force[backward] = graph_.multiply(coefficient(graph_.negate(friction.rate)), normal);
    const Expression slow = coefficient(zero());
    not_negative(slow, text.law, fmt::format("coefficient of the friction {}", name));
    Expression sticking = slow;
    if (text.sticking) {
      sticking = read(*text.sticking, fmt::format("in the static coefficient of {}", name));
      const double at_rest = value(sticking), sliding = value(slow);
      if (at_rest < sliding)
        names_.refuse(text.sticking->place,
                      fmt::format("the static coefficient of {} is {:.6g}, less than that of slow sliding, {:.6g}", name, at_rest,
                                  sliding));
    }
    friction.same_limit = is_zero(graph_, graph_.subtract(sticking, slow));
    friction.limit = graph_.multiply(sticking, normal);
    contacts_.push_back(std::move(friction));
  }

  // Modes --------------------------------------------------------------------------------------------------------------------

  bool constrains(std::size_t c, const std::vector<int>& status) const {
    const Contact& contact = contacts_[c];
    return contact.is_stop ? contact.rigid && status[c] == closed : status[c] == stuck;
  }

  void combine() {
    std::size_t count = 1;
    for (const Contact& contact : contacts_) {
      count *= static_cast<std::size_t>(contact.states);
      if (count > max_contact_modes)
        names_.refuse(contact.name.place, fmt::format("stops and friction up to {} make {} modes; at most {} are made",
                                                      contact.name.text, count, max_contact_modes));
    }
    std::vector<int> status(contacts_.size(), 0);
    for (std::size_t number = 0; number < count; ++number) {
      Combination at;
      at.status = status;
      if (constrain(at)) {
        at.mode = combinations_.size();
        index_.emplace(status, at.mode);
        combinations_.push_back(std::move(at));
      }
      for (std::size_t c = 0; c < status.size(); ++c) {
        if (++status[c] < contacts_[c].states) break;
        status[c] = 0;
      }
    }
  }

  /// Computes accelerations, multipliers and the states that constraints determine; false: the constraints are dependent.
  bool constrain(Combination& at) const {
    Column force = force_;
    for (std::size_t c = 0; c < contacts_.size(); ++c) {
      const Contact& contact = contacts_[c];
      std::optional<Expression> size;
      if (contact.is_stop) {
        if (!contact.rigid && at.status[c] == closed) size = contact.force;
      } else if (at.status[c] != stuck) {
        const Expression friction = *contact.slip_force[at.status[c]];
        size = at.status[c] == forward ? graph_.negate(friction) : friction;
      }
      for (std::size_t i = 0; i < n_ && size; ++i) force[i] = graph_.add(force[i], graph_.multiply(contact.direction[i], *size));
      if (constrains(c, at.status)) at.constraints.push_back(c);
    }
    for (std::size_t i = 0; i < n_; ++i) at.acceleration.push_back(dot(inverse_[i], force));
    if (at.constraints.empty()) return true;
    const Column free = field_of(at.acceleration);
    if (at.constraints.size() == 1) {
      const Contact& contact = contacts_[at.constraints[0]];
      const Expression acceleration = rate_along(graph_, contact.rate, free);
      at.multiplier.push_back(graph_.negate(graph_.divide(acceleration, contact.compliance)));
      for (std::size_t i = 0; i < n_; ++i)
        at.acceleration[i] = graph_.subtract(at.acceleration[i], graph_.multiply(contact.share[i], acceleration));
    } else {
      Square A, B;
      for (const std::size_t c : at.constraints) {
        A.emplace_back();
        for (const std::size_t other : at.constraints) A.back().push_back(dot(contacts_[c].direction, contacts_[other].response));
        B.push_back({graph_.negate(rate_along(graph_, contacts_[c].rate, free))});
      }
      const auto solution = solve(A, B);
      if (!solution) return false;
      for (std::size_t k = 0; k < at.constraints.size(); ++k) {
        at.multiplier.push_back((*solution)[k][0]);
        for (std::size_t i = 0; i < n_; ++i)
          at.acceleration[i] =
              graph_.add(at.acceleration[i], graph_.multiply(contacts_[at.constraints[k]].response[i], at.multiplier[k]));
      }
    }
    for (const std::size_t c : at.constraints) {
      std::optional<std::size_t> coordinate;
      if (contacts_[c].is_stop) coordinate = replace(at, contacts_[c].gap, [&](std::size_t i) { return i < n_; });
      // For a determined coordinate, its velocity.
      const auto own = [&](std::size_t i) { return coordinate && i == n_ + *coordinate; };
      if (!coordinate || !replace(at, contacts_[c].rate, own))
        replace(at, contacts_[c].rate, [&](std::size_t i) { return i >= n_; });
    }
    for (const Solution& one : at.solved) at.replacement.emplace(graph_.state(one.state).index, one.value);
    return true;
  }

  /// Solves constraint = 0 for one more state, and returns it.
  std::optional<std::size_t> replace(Combination& at, Expression constraint,
                                     const std::function<bool(std::size_t)>& allowed) const {
    Replacement known;
    for (const Solution& one : at.solved) known.emplace(graph_.state(one.state).index, one.value);
    const auto solution = solve_constraint(names_, graph_.substitute(constraint, known), allowed);
    if (!solution) return std::nullopt;
    for (Solution& one : at.solved)
      one.value = graph_.substitute(one.value, {{graph_.state(solution->state).index, solution->value}});
    at.solved.push_back(*solution);
    return solution->state;
  }

  std::string name_of(const std::vector<int>& status) const {
    std::string out;
    for (std::size_t c = 0; c < status.size(); ++c) {
      const Contact& contact = contacts_[c];
      if (contact.is_stop && status[c] == open) continue;
      out += (out.empty() ? "" : "+") + contact.name.text;
      if (contact.is_stop && status[c] == apart) out += " apart";
      if (!contact.is_stop) out += status[c] == forward ? " forward" : status[c] == backward ? " backward" : " stick";
    }
    return out.empty() ? "free" : out;
  }

  void make_mode(const Combination& at) {
    ModePiece mode;
    mode.name = name_of(at.status);
    mode.place = input_.place;
    mode.field.assign(2 * n_, zero());
    const Column raw = field_of(at.acceleration);
    std::vector<char> given(2 * n_, 0);
    for (const Solution& one : at.solved) given[one.state] = 1;
    for (std::size_t i = 0; i < raw.size(); ++i) {
      if (!given[i]) mode.field[i] = graph_.substitute(raw[i], at.replacement);
      mode.equation.push_back(i < n_ || input_.force.empty() ? input_.coordinates[i % n_].place : input_.force[i - n_].place);
    }
    for (const Solution& one : at.solved) mode.field[one.state] = rate_along(graph_, one.value, mode.field);
    for (const std::size_t c : at.constraints) {
      const Column &response = contacts_[c].response, none(n_, zero());
      const auto along = [](Column first, const Column& second) {
        first.insert(first.end(), second.begin(), second.end());
        return first;
      };
      if (contacts_[c].is_stop) mode.constraints.push_back({contacts_[c].gap, along(response, none)});
      mode.constraints.push_back({contacts_[c].rate, along(none, response)});
    }
    out_.modes.push_back(std::move(mode));
  }

  // Events -------------------------------------------------------------------------------------------------------------------

  const Combination* find(const std::vector<int>& status) const {
    const auto found = index_.find(status);
    return found == index_.end() ? nullptr : &combinations_[found->second];
  }
  static std::vector<int> changed(std::vector<int> status, std::size_t c, int to) {
    status[c] = to;
    return status;
  }

  /// Adds an event from `at`, with the guard in terms of that mode; nullptr: the guard is constant along the motion, or there
  /// is no target mode.
  EventPiece* add(const Combination& at, const Contact& contact, const std::string& suffix, EventKind kind, Expression guard,
                  const std::vector<int>& to, bool may_rest = false) {
    const Expression here = graph_.substitute(guard, at.replacement);
    const Combination* target = find(to);
    if (!target || (!may_rest && !dependence(graph_, here).moves())) return nullptr;
    EventPiece event;
    event.name = contact.name.text + suffix;
    event.text = made_event;
    event.kind = kind;
    if (begins_contact(kind) || kind == EventKind::stick) event.count = contact.count;
    event.from = at.mode;
    event.to = target->mode;
    event.guard = here;
    event.decided = true;
    for (std::size_t i = 0; i < 2 * n_; ++i) event.map.push_back(graph_.state(i));
    event.when = contact.where;
    event.reset = contact.law;
    out_.events.push_back(std::move(event));
    return &out_.events.back();
  }

  /// Adds the constraints and surfaces that a reset of the text may leave or cross.
  void make_surfaces(const Combination& at, std::size_t c) {
    const Contact& contact = contacts_[c];
    if (contact.is_stop) {
      if (!contact.rigid || at.status[c] != closed) return;
      const Combination* free = find(changed(at.status, c, open));
      for (const Expression h : {contact.gap, contact.rate})
        out_.surfaces.push_back({h, free->mode, free->mode, at.mode, at.replacement});
    } else if (at.status[c] == forward) {
      SurfacePiece surface{contact.rate, find(changed(at.status, c, backward))->mode, at.mode, {}, {}};
      if (const Combination* held = find(changed(at.status, c, stuck))) {
        surface.sliding = held->mode;
        surface.state_on_surface = held->replacement;
      }
      out_.surfaces.push_back(std::move(surface));
    }
  }

  std::optional<Expression> mass_of(const Contact& contact) const {
    const Expression mass = tidy(graph_.divide(graph_.constant(1.0), contact.compliance));
    return graph_.is_constant(mass, 1.0) ? std::nullopt : std::optional(mass);
  }

  void make_events(const Combination& at, std::size_t c) {
    const Contact& contact = contacts_[c];
    const int status = at.status[c];
    if (!contact.is_stop) {
      status == stuck ? leave_sticking(at, c) : lose_speed(at, c);
    } else if (contact.rigid) {
      status == open ? strike(at, c) : release(at, c);
    } else if (status == open) {
      EventPiece* event = add(at, contact, " enter", EventKind::enter, graph_.negate(contact.gap), changed(at.status, c, closed));
      if (!event) return;
      event->effective_mass = mass_of(contact);
      event->continuous = contact.begins_softly;
    } else if (status == closed && contact.states == 3) {
      if (EventPiece* event =
              add(at, contact, " leave", EventKind::leave, graph_.negate(contact.force), changed(at.status, c, apart))) {
        event->continuous = true;
        event->effective_mass = mass_of(contact);
        event->opening_rate = contact.rate;
      }
      add(at, contact, " open", EventKind::leave, contact.gap, changed(at.status, c, open));
    } else if (status == closed) {
      if (EventPiece* event = add(at, contact, " leave", EventKind::leave, contact.gap, changed(at.status, c, open))) {
        event->continuous = contact.begins_softly;
        event->effective_mass = mass_of(contact);
      }
    } else {
      if (EventPiece* event = add(at, contact, " open", EventKind::other, contact.gap, changed(at.status, c, open)))
        event->continuous = true;
      EventPiece* event = add(at, contact, " press", EventKind::enter, contact.force, changed(at.status, c, closed));
      if (!event) return;
      event->effective_mass = mass_of(contact);
      event->continuous = true;
    }
  }

  void strike(const Combination& at, std::size_t c) {
    const Contact& stop = contacts_[c];
    Column map;
    for (std::size_t i = 0; i < n_; ++i) map.push_back(q(i));
    const Expression jump = graph_.multiply(graph_.add(graph_.constant(1.0), stop.restitution), stop.rate);
    for (std::size_t i = 0; i < n_; ++i) map.push_back(graph_.subtract(v(i), graph_.multiply(stop.share[i], jump)));
    for (std::size_t i = 0; i < 2 * n_; ++i) {
      // A state that a constraint determines and the impulse does not change stays unchanged.
      if (map[i] != graph_.state(i)) map[i] = graph_.substitute(map[i], at.replacement);
    }
    // Contacts that the impulse reaches through M: closed rigid stops open; friction continues with the sign of its speed.
    std::vector<int> to = at.status;
    std::vector<std::size_t> slipping;
    for (std::size_t other = 0; other < contacts_.size(); ++other) {
      const Contact& reached = contacts_[other];
      if (other == c || vanishes(dot(reached.direction, stop.response))) continue;
      if (reached.is_stop && reached.rigid) to[other] = open;
      if (!reached.is_stop) slipping.push_back(other);
    }
    Replacement after;
    for (std::size_t i = 0; i < map.size(); ++i) after.emplace(graph_.state(i).index, map[i]);
    const std::size_t choices = std::size_t{1} << slipping.size();
    for (std::size_t choice = 0; choice < choices; ++choice) {
      // The first choice fires in which all bodies that slip forward have a positive speed. Those that slip backward then have
      // none.
      std::vector<Expression> conditions;
      for (std::size_t k = 0; k < slipping.size(); ++k) {
        const bool goes_backward = (choice >> k & 1U) != 0;
        to[slipping[k]] = goes_backward ? backward : forward;
        if (!goes_backward) conditions.push_back(graph_.substitute(contacts_[slipping[k]].rate, after));
      }
      EventPiece* event = add(at, stop, "", EventKind::impact, graph_.negate(stop.gap), to);
      if (!event) return;
      event->map = map;
      event->effective_mass = mass_of(stop);
      // The guard is written in the states that the mode leaves free. Behind the impact they may move apart from the gap.
      if (!at.solved.empty()) event->opening_rate = stop.rate;
      if (!dependence(graph_, stop.restitution).moves()) event->restitution = stop.restitution;
      if (choice + 1 < choices) event->otherwise = AlternativePiece{conditions, out_.events.size()};
      accumulate(*event, at, *find(to), c);
    }
  }

  /// Adds the accumulation of an impact. Between the impacts of a series, the stops that were closed before are closed again
  /// and carry the load.
  void accumulate(EventPiece& event, const Combination& before, const Combination& behind, std::size_t c) {
    const Contact& stop = contacts_[c];
    const Combination* between = &behind;
    std::vector<int> status = behind.status;
    for (std::size_t other = 0; other < contacts_.size(); ++other)
      if (contacts_[other].is_stop) status[other] = before.status[other];
    if (find(status) && find(changed(status, c, closed))) between = find(status);
    const Combination* held = find(changed(between->status, c, closed));
    if (!held) return;
    AccumulationPiece out;
    out.sticking_mode = held->mode;
    for (std::size_t i = 0; i < n_; ++i) out.map.push_back(graph_.subtract(q(i), graph_.multiply(stop.share[i], stop.gap)));
    for (std::size_t i = 0; i < n_; ++i) out.map.push_back(graph_.subtract(v(i), graph_.multiply(stop.share[i], stop.rate)));
    Replacement projected;
    for (std::size_t i = 0; i < 2 * n_; ++i) projected.emplace(graph_.state(i).index, out.map[i]);
    for (const Solution& one : held->solved) out.map[one.state] = graph_.substitute(one.value, projected);
    out.pressing =
        graph_.negate(graph_.substitute(rate_along(graph_, stop.rate, field_of(between->acceleration)), between->replacement));
    event.accumulation = std::move(out);
  }

  void release(const Combination& at, std::size_t c) {
    const Contact& stop = contacts_[c];
    const auto to = changed(at.status, c, open);
    const Combination* free = find(to);
    if (!free) return;
    const Expression opening = rate_along(graph_, stop.rate, field_of(free->acceleration));
    // Rounding moves a body off a moving stop: without this reset it would hit the stop at once.
    const auto stay_at_stop = [&](EventPiece& event) {
      for (const Solution& one : at.solved)
        if (dependence(graph_, one.value).time) event.map[one.state] = one.value;
    };
    // Friction of a body that its stop holds at rest keeps the direction in which it came. At the release it holds the body if it
    // can.
    for (std::size_t other = 0; other < contacts_.size(); ++other) {
      const Contact& friction = contacts_[other];
      if (friction.is_stop || at.status[other] == stuck || !vanishes(graph_.substitute(friction.rate, at.replacement))) continue;
      const Combination* held = find(changed(to, other, stuck));
      EventPiece* event = held ? add(at, stop, " release", EventKind::release, opening, held->status, true) : nullptr;
      if (!event) continue;
      stay_at_stop(*event);
      const Expression needed = graph_.substitute(multiplier_of(*held, other), held->replacement);
      event->otherwise =
          AlternativePiece{{graph_.subtract(friction.limit, needed), graph_.add(friction.limit, needed)}, out_.events.size()};
    }
    // At release the contact force is zero: state and field are continuous.
    EventPiece* event = add(at, stop, " release", EventKind::release, opening, to, true);
    if (!event) return;
    event->continuous = true;
    stay_at_stop(*event);
  }

  void lose_speed(const Combination& at, std::size_t c) {
    const Contact& friction = contacts_[c];
    const bool goes_forward = at.status[c] == forward;
    const Expression guard = goes_forward ? graph_.negate(friction.rate) : friction.rate;
    const auto sticks = changed(at.status, c, stuck);
    if (const Combination* held = find(sticks)) {
      if (EventPiece* event = add(at, friction, " stick", EventKind::stick, guard, sticks)) {
        for (const Solution& one : held->solved) event->map[one.state] = one.value;
        const Expression needed = multiplier_of(*held, c);
        event->otherwise =
            AlternativePiece{{goes_forward ? graph_.subtract(friction.limit, graph_.substitute(needed, held->replacement))
                                           : graph_.add(friction.limit, graph_.substitute(needed, held->replacement))},
                             out_.events.size()};
      }
    }
    add(at, friction, " reversal", EventKind::other, guard, changed(at.status, c, goes_forward ? backward : forward));
  }

  static Expression multiplier_of(const Combination& held, std::size_t c) {
    const auto found = std::find(held.constraints.begin(), held.constraints.end(), c);
    return held.multiplier[static_cast<std::size_t>(found - held.constraints.begin())];
  }

  void leave_sticking(const Combination& at, std::size_t c) {
    const Contact& friction = contacts_[c];
    const Expression needed = multiplier_of(at, c);
    for (const int to : {backward, forward}) {
      const Expression guard = graph_.subtract(to == backward ? needed : graph_.negate(needed), friction.limit);
      const std::string suffix = to == backward ? " slip backward" : " slip forward";
      if (EventPiece* event = add(at, friction, suffix, EventKind::release, guard, changed(at.status, c, to), true))
        event->continuous = friction.same_limit;
    }
  }

  Names& names_;
  Scope scope_;  // all names and the time
  Graph& graph_;
  const SystemText& text_;
  const MechanicsText& input_;
  std::size_t n_;
  Square inverse_;
  Column force_;
  std::vector<Contact> contacts_;
  std::vector<Combination> combinations_;
  std::map<std::vector<int>, std::size_t> index_;
  Pieces out_;
};

}  // namespace

Pieces make_mechanics(Names& names) { return Mechanics(names).make(); }

}  // namespace graze::equations
