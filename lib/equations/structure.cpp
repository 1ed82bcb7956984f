// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/structure.hpp>

#include <graze/lib/equations/tape.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>

namespace graze::equations {

namespace {

using C = CubicOscillator;
using H = HertzContact;

/// The acceleration's coefficients as functions of the parameters, in the order of CubicOscillator.
struct Oscillator {
  std::array<Expression, C::count> coefficient;
  // Of the contact force -k_H (x - r)^(3/2) (1 + b_H v), if there is one.
  std::optional<Expression> depth = {}, contact = {}, contact_speed = {};
};

/// The terms of v' = f(x, v, t); nullopt: there is a term of another form.
std::optional<Oscillator> read_oscillator(Graph& graph, const std::vector<Expression>& field,
                                          std::optional<std::size_t> forcing_frequency) {
  if (field.size() != 2 || field[0] != graph.state(1)) return std::nullopt;
  Expander expander(graph, Coefficients::parameters);
  const auto polynomial = expander.expand(field[1]);
  if (!polynomial) return std::nullopt;
  const std::uint32_t x = graph.state(0).index, v = graph.state(1).index;
  const Expression zero = graph.constant(0.0);
  Oscillator out;
  out.coefficient.fill(zero);
  out.coefficient[C::frequency] = forcing_frequency ? graph.parameter(*forcing_frequency) : graph.constant(1.0);
  bool forced = false;
  for (const auto& [monomial, coefficient] : *polynomial) {
    if (monomial.empty()) {
      out.coefficient[C::constant] = coefficient;
    } else if (monomial == Monomial{{v, 1.0}}) {
      out.coefficient[C::damping] = graph.divide(graph.negate(coefficient), graph.constant(2.0));
    } else if (monomial == Monomial{{x, 1.0}}) {
      out.coefficient[C::stiffness] = graph.negate(coefficient);
    } else if (monomial == Monomial{{x, 3.0}}) {
      out.coefficient[C::cubic] = graph.negate(coefficient);
    } else {
      // The remaining terms contain cos(w t), or a contact force with or without the speed.
      bool with_speed = false;
      std::optional<Expression> factor;
      for (const auto& [generator, exponent] : monomial) {
        if (exponent != 1.0) return std::nullopt;
        if (generator == v && !with_speed) {
          with_speed = true;
        } else if (!factor) {
          factor = expander.original(generator);
        } else {
          return std::nullopt;
        }
      }
      if (!factor) return std::nullopt;
      const Node n = graph.node(*factor);
      if (n.operation == Operation::cos && !with_speed && !forced) {
        Expander argument(graph, Coefficients::parameters);
        const auto& phase = argument.expand(n.a);
        if (!phase || phase->size() != 1 || phase->begin()->first != Monomial{{graph.time().index, 1.0}}) return std::nullopt;
        out.coefficient[C::frequency] = phase->begin()->second;
        out.coefficient[C::amplitude] = coefficient;
        forced = true;
      } else if (n.operation == Operation::contact_power && n.value == 1.5 && (!out.depth || *out.depth == n.a)) {
        out.depth = n.a;
        auto& part = with_speed ? out.contact_speed : out.contact;
        if (part) return std::nullopt;
        part = coefficient;
      } else {
        return std::nullopt;
      }
    }
  }
  return out;
}

/// Coefficients as functions of the parameters, with their derivatives.
class CoefficientFunctions {
 public:
  CoefficientFunctions(Graph& graph, std::span<const Expression> coefficients) {
    std::vector<Expression> outputs(coefficients.begin(), coefficients.end());
    for (std::size_t i = 0; i < coefficients.size(); ++i)
      for (const std::size_t parameter : dependence(graph, coefficients[i]).parameters) {
        entries_.push_back({i, parameter});
        outputs.push_back(graph.derivative(coefficients[i], graph.parameter(parameter)));
      }
    tape_ = std::make_shared<const Tape>(graph, outputs);
  }

  template <std::size_t count> void evaluate(const Vector& p, std::array<double, count>& value, Matrix& dp) const {
    std::vector<double> workspace(tape_->workspace()), all(tape_->outputs());
    tape_->evaluate<double>(0.0, nullptr, p.data(), workspace.data(), all.data());
    std::copy_n(all.begin(), count, value.begin());
    dp = Matrix::Zero(count, p.size());
    for (std::size_t i = 0; i < entries_.size(); ++i)
      dp(static_cast<Eigen::Index>(entries_[i].coefficient), static_cast<Eigen::Index>(entries_[i].parameter)) = all[count + i];
  }

 private:
  struct Entry {
    std::size_t coefficient, parameter;
  };
  std::vector<Entry> entries_;
  std::shared_ptr<const Tape> tape_;
};

/// The quotient a / b of two coefficients; the parameter itself if the quotient equals one.
Expression quotient(Graph& graph, Expression a, Expression b, std::size_t parameters) {
  for (std::size_t i = 0; i < parameters; ++i)
    if (is_zero(graph, graph.subtract(a, graph.multiply(b, graph.parameter(i))))) return graph.parameter(i);
  return graph.divide(a, b);
}

/// Hertz's contact with an oscillator of natural frequency 1, at a barrier that is a parameter.
StructureAt hertz_structure(Graph& graph, const Oscillator& oscillator, std::size_t parameters) {
  const auto level = recognise_level(graph, *oscillator.depth);
  const auto& q = oscillator.coefficient;
  if (!level || level->coordinate != 0 || level->sign < 0.0 || !oscillator.contact) return {};
  if (!is_zero(graph, graph.subtract(q[C::stiffness], graph.constant(1.0))) || !is_zero(graph, q[C::constant])) return {};
  const Expression stiffness = graph.negate(*oscillator.contact);
  const Expression contact_damping = oscillator.contact_speed
                                         ? quotient(graph, *oscillator.contact_speed, *oscillator.contact, parameters)
                                         : graph.constant(0.0);
  std::array<Expression, H::count> coefficient;
  coefficient[H::damping] = q[C::damping];
  coefficient[H::beta] = q[C::cubic];
  coefficient[H::amplitude] = q[C::amplitude];
  coefficient[H::frequency] = q[C::frequency];
  coefficient[H::barrier] = graph.parameter(level->level);
  coefficient[H::stiffness] = stiffness;
  coefficient[H::contact_damping] = contact_damping;
  return [functions = CoefficientFunctions(graph, coefficient)](const Vector& p) -> ModeStructure {
    H hertz;
    functions.evaluate(p, hertz.value, hertz.dp);
    if (!std::isfinite(hertz.value[H::contact_damping])) return GeneralField{};  // a quotient 0/0
    return hertz;
  };
}

}  // namespace

StructureAt recognise_structure(Graph& graph, const std::vector<Expression>& field, std::optional<std::size_t> forcing_frequency,
                                std::size_t parameters) {
  const auto oscillator = read_oscillator(graph, field, forcing_frequency);
  if (!oscillator) return {};
  if (oscillator->depth) return hertz_structure(graph, *oscillator, parameters);
  const auto& q = oscillator->coefficient;
  const bool has_cubic = !is_zero(graph, q[C::cubic]);
  return [functions = CoefficientFunctions(graph, q), has_cubic](const Vector& p) -> ModeStructure {
    C cubic;
    functions.evaluate(p, cubic.value, cubic.dp);
    if (has_cubic && cubic.value[C::cubic] != 0.0) return cubic;
    LinearOscillator linear;
    linear.damping = cubic.value[C::damping];
    linear.stiffness = cubic.value[C::stiffness];
    linear.amplitude = cubic.value[C::amplitude];
    linear.frequency = cubic.value[C::frequency];
    linear.constant = cubic.value[C::constant];
    linear.dp.resize(5, p.size());
    linear.dp << cubic.dp.topRows(2), cubic.dp.bottomRows(3);
    for (Eigen::Index i = 0; i < p.size(); ++i)
      if (cubic.dp(C::cubic, i) != 0.0) linear.not_differentiable_in.push_back(static_cast<std::size_t>(i));
    return linear;
  };
}

std::optional<LevelGuard> recognise_level(Graph& graph, Expression guard) {
  Expander expander(graph, Coefficients::numbers);
  const auto& polynomial = expander.expand(guard);
  if (!polynomial || polynomial->size() != 2) return std::nullopt;
  LevelGuard out;
  double of_state = 0.0, of_parameter = 0.0;
  for (const auto& [monomial, coefficient] : *polynomial) {
    if (monomial.size() != 1 || monomial[0].second != 1.0) return std::nullopt;
    const Node &generator = graph.node({monomial[0].first}), &number = graph.node(coefficient);
    if (number.operation != Operation::constant) return std::nullopt;
    if (generator.operation == Operation::state) {
      out.coordinate = generator.index;
      of_state = number.value;
    } else if (generator.operation == Operation::parameter) {
      out.level = generator.index;
      of_parameter = number.value;
    }
  }
  if (std::abs(of_state) != 1.0 || of_parameter != -of_state) return std::nullopt;
  out.sign = of_state;
  return out;
}

std::optional<Solution> solve_guard(Graph& graph, Expression guard, std::size_t states,
                                    const std::function<bool(std::size_t)>& allowed) {
  Expander expander(graph, Coefficients::numbers);
  const auto polynomial = expander.expand(guard);
  if (!polynomial) return std::nullopt;
  for (std::size_t i = 0; i < states; ++i) {
    if (!allowed(i)) continue;
    const auto linear = polynomial->find(Monomial{{graph.state(i).index, 1.0}});
    if (linear == polynomial->end() || graph.node(linear->second).operation != Operation::constant) continue;
    Polynomial rest = *polynomial;
    rest.erase(linear->first);
    const Expression others = assemble(graph, rest);
    const auto in = dependence(graph, others).states;
    if (std::find(in.begin(), in.end(), i) != in.end()) continue;
    return Solution{i, normal_form(graph, graph.negate(graph.divide(others, linear->second)))};
  }
  return std::nullopt;
}

namespace {

/// The polynomial with g^unit replaced by `value`, in terms in which the exponent of g is a multiple of `unit`.
Expression with_power_replaced(Graph& graph, const Polynomial& polynomial, std::uint32_t g, double unit, Expression value) {
  Expression sum = graph.constant(0.0);
  for (const auto& [monomial, coefficient] : polynomial) {
    Expression term = coefficient;
    for (const auto& [generator, exponent] : monomial) {
      const double times = exponent / unit;
      const bool replaced = generator == g && times == std::round(times) && (times > 0.0 || !graph.is_constant(value, 0.0));
      term = graph.multiply(term,
                            graph.power(replaced ? value : Expression{generator}, graph.constant(replaced ? times : exponent)));
    }
    sum = graph.add(sum, term);
  }
  return sum;
}

/// True if e vanishes where h = c g^q + rest does, with c g^q replaced by -rest; g is a state or the argument of a root.
bool vanishes_with_term_replaced(Graph& graph, Expression e, Expression guard) {
  Expander numbers(graph, Coefficients::numbers);
  const std::optional<Polynomial> terms = numbers.expand(guard), of_e = numbers.expand(e);
  if (!terms) return false;
  return std::any_of(terms->begin(), terms->end(), [&](const auto& term) {
    const auto& [monomial, factor] = term;
    if (monomial.size() != 1 || graph.node(factor).operation != Operation::constant) return false;
    const auto [generator, exponent] = monomial.front();
    Polynomial rest = *terms;
    rest.erase(monomial);
    const Expression value = normal_form(graph, graph.negate(graph.divide(assemble(graph, rest), factor)));
    if (exponent == 1.0) return is_zero(graph, graph.substitute(e, {{numbers.original(generator).index, value}}));
    return of_e && is_zero(graph, with_power_replaced(graph, *of_e, generator, exponent, value));
  });
}

}  // namespace

bool vanishes_on(Graph& graph, Expression e, Expression guard, const std::vector<ParameterInfo>& parameters) {
  if (is_zero(graph, e) || vanishes_with_term_replaced(graph, e, guard)) return true;
  // Tests e c = h d, where c and d are the coefficients of one term of the guard h and of e, and c vanishes nowhere.
  for (const Coefficients coefficients : {Coefficients::numbers, Coefficients::parameters}) {
    Expander expander(graph, coefficients);
    const auto of_guard = expander.expand(guard), of_e = expander.expand(e);
    if (!of_guard || !of_e || of_guard->empty()) continue;
    for (const auto& [monomial, factor] : *of_guard) {
      const auto same = of_e->find(monomial);
      const Bounds range = bounds(graph, factor, parameters);
      if (same == of_e->end() || !(range.lower > 0.0 || range.upper < 0.0)) continue;
      if (is_zero(graph, graph.subtract(graph.multiply(e, factor), graph.multiply(guard, same->second)))) return true;
    }
  }
  return false;
}

std::optional<Rebound> recognise_rebound(Graph& graph, const std::vector<Expression>& map,
                                         const std::optional<LevelGuard>& level) {
  if (!level) return std::nullopt;
  // On the guard x equals the level: a reset that leaves x unchanged sets it to the level.
  const std::size_t x = level->coordinate;
  if (map[x] != graph.state(x) && as_parameter(graph, map[x]) != level->level) return std::nullopt;
  std::optional<std::size_t> velocity;
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (i == x || map[i] == graph.state(i)) continue;
    if (velocity) return std::nullopt;
    velocity = i;
  }
  if (!velocity) return std::nullopt;
  Expander expander(graph, Coefficients::parameters);
  const auto& polynomial = expander.expand(map[*velocity]);
  if (!polynomial || polynomial->size() != 1 || polynomial->begin()->first != Monomial{{graph.state(*velocity).index, 1.0}})
    return std::nullopt;
  const auto coefficient = as_parameter(graph, graph.negate(polynomial->begin()->second));
  if (!coefficient) return std::nullopt;
  return Rebound{.coordinate = x, .velocity = *velocity, .level = level->level, .coefficient = *coefficient};
}

}  // namespace graze::equations
