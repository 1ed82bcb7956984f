// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/nonsmooth.hpp>

#include <graze/lib/equations/poles.hpp>
#include <graze/lib/equations/structure.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace graze::equations {

namespace {

using Signs = std::vector<int>;

/// Largest number of sign combinations before equivalent ones are merged.
constexpr std::size_t most_combinations = 512;
/// Longest text of an argument in the name of a mode.
constexpr std::size_t longest_argument = 40;

bool is_jump(Operation operation) { return operation == Operation::sign || operation == Operation::step; }

/// Smallest absolute value of a divisor inside of tanh, which is its limit there.
constexpr double least_divisor = 1e-150;

/// An argument whose sign decides the branch of some functions.
struct Switch {
  Expression argument;
  bool jumps = false;
  bool breaks = false;    ///< the divisor of a quotient in a bounded function, or the cut of atan2: other arguments jump there
  bool vanishes = false;  ///< of sign or step, and identically zero for some signs of the others, as in a dead zone
};
/// The divisor of a quotient in atan, atan2 or tanh: `side` times the argument of a switch.
struct InnerDivisor {
  Expression divisor;
  std::size_t number = 0;
  int side = 1;
};
/// A nonsmooth function; side -1: its argument is the negative of the switch's argument.
struct Bend {
  Expression node;
  std::size_t number = 0;
  int side = 1;
  std::vector<InnerDivisor> divisors = {};  ///< of atan, tanh and atan2, operands first; `number` is the last of theirs
  std::optional<std::size_t> cut = {};      ///< of atan2: the switch of its first operand
};

/// The nonsmooth functions of one mode.
struct Splitter {
  Graph& graph;
  std::vector<Switch> switches;
  std::vector<Bend> bends;  ///< operands first
  const std::vector<ParameterInfo>& parameters;
  std::map<Expression, std::size_t> numbers;  ///< of the switches, by the normal forms of their arguments

  /// An operand of atan, atan2 or tanh without the quotients whose divisors are switches.
  RegularFraction regular(Expression operand, const Bend& bend, const Signs& signs, const Replacement& replacement) const {
    std::vector<SignedDivisor> divisors;
    for (const InnerDivisor& one : bend.divisors)
      divisors.push_back({graph.substitute(one.divisor, replacement), signs[one.number] * one.side});
    return without_quotients(graph, graph.substitute(operand, replacement), divisors, parameters);
  }

  /// atan2(y, x) where y has this sign: for y > 0 it is pi/2 - atan2(x, y), which continues smoothly beyond y = 0; it is odd in
  /// y.
  Expression angle(Expression y, Expression x, int sign) const {
    const Expression size = sign > 0 ? y : graph.negate(y);
    const Expression out =
        graph.subtract(graph.divide(graph.pi(), graph.constant(2.0)), graph.function(Operation::atan2, x, size));
    return sign > 0 ? out : graph.negate(out);
  }

  Expression resolved(Expression e, const Signs& signs, std::size_t known) const {
    Replacement replacement;
    for (const Bend& bend : bends) {
      if (bend.number >= known) continue;
      const Node n = graph.node(bend.node);
      const bool positive = signs[bend.number] * bend.side > 0;
      Expression branch;
      switch (n.operation) {
      case Operation::atan: {  // of p/q with q > 0, continued beyond q = 0
        const RegularFraction operand = regular(n.a, bend, signs, replacement);
        replacement[bend.node.index] = graph.function(Operation::atan2, operand.numerator, operand.denominator);
        continue;
      }
      case Operation::tanh: {  // the same, with its limit at q = 0
        const RegularFraction operand = regular(n.a, bend, signs, replacement);
        const Expression size = graph.function(Operation::max, operand.denominator, graph.constant(least_divisor));
        replacement[bend.node.index] = graph.function(Operation::tanh, graph.divide(operand.numerator, size));
        continue;
      }
      case Operation::atan2: {
        const RegularFraction first = regular(n.a, bend, signs, replacement), second = regular(n.b, bend, signs, replacement);
        const Expression y = graph.multiply(first.numerator, second.denominator),
                         x = graph.multiply(second.numerator, first.denominator);
        replacement[bend.node.index] =
            bend.cut ? angle(y, x, signs[*bend.cut] * bend.side) : graph.function(Operation::atan2, y, x);
        continue;
      }
      case Operation::abs:
        branch = positive ? n.a : graph.negate(n.a);
        break;
      case Operation::sign: {
        const bool vanishes = graph.is_constant(graph.substitute(n.a, replacement), 0.0);  // as in a dead zone
        branch = graph.constant(vanishes ? 0.0 : positive ? 1.0 : -1.0);
        break;
      }
      case Operation::step:
        branch = graph.constant(positive ? 1.0 : 0.0);
        break;
      default:
        branch = positive == (n.operation == Operation::max) ? n.a : n.b;
      }
      replacement[bend.node.index] = graph.substitute(branch, replacement);
    }
    return graph.substitute(e, replacement);
  }
  Expression resolved(Expression e, const Signs& signs) const { return resolved(e, signs, switches.size()); }
  Expression argument(std::size_t i, const Signs& signs) const {
    std::vector<SignedDivisor> divisors;
    for (std::size_t k = 0; k < i; ++k)
      if (switches[k].breaks) divisors.push_back({resolved(switches[k].argument, signs, k), signs[k]});
    return without_quotients(graph, resolved(switches[i].argument, signs, i), divisors, parameters).numerator;
  }
};

Signs flipped(Signs signs, std::size_t i) {
  signs[i] = -signs[i];
  return signs;
}

/// A mode of the text and the modes made from it.
struct SplitMode {
  Splitter splitter;
  std::vector<Signs> representatives;       ///< for each new mode
  std::map<Signs, std::size_t> class_of;    ///< number of the new mode of a combination, within this mode
  std::vector<std::vector<bool>> decisive;  ///< for each new mode: the signs whose change leads to another one
  std::vector<Signs> common;                ///< for each new mode: the signs of all its combinations, 0 where they differ
  std::size_t first = 0;                    ///< index of the first new mode
};

class Separation {
 public:
  Separation(Graph& graph, const Pieces& pieces, const std::vector<ParameterInfo>& parameters, const Symbols& symbols,
             const Source& source)
      : graph_(graph), pieces_(pieces), parameters_(parameters), symbols_(symbols), source_(source) {}

  Pieces run() {
    for (std::size_t m = 0; m < pieces_.modes.size(); ++m) split(m);
    for (std::size_t e = 0; e < pieces_.events.size(); ++e) distribute(e);
    for (const auto& [index, number] : to_group_) {
      std::size_t& event = out_.events[index].otherwise->event;
      event = first_of_event_[event][number];
    }
    for (std::size_t m = 0; m < split_.size(); ++m) switch_branches(m);
    return std::move(out_);
  }

 private:
  std::vector<Expression> roots(std::size_t m) const {
    std::vector<Expression> list = pieces_.modes[m].field;
    for (const EventPiece& event : pieces_.events) {
      if (event.from != m) continue;
      list.push_back(event.guard);
      list.insert(list.end(), event.map.begin(), event.map.end());
      if (event.accumulation) list.insert(list.end(), event.accumulation->map.begin(), event.accumulation->map.end());
    }
    return list;
  }

  std::string shown(Expression e) const { return to_text(graph_, e, symbols_, longest_argument); }

  bool vanishes(const Splitter& splitter, std::size_t i, const Signs& signs) {
    return graph_.is_constant(splitter.argument(i, signs), 0.0);
  }

  /// The combination behind a change of sign i. Those of arguments that vanish on one side change with it.
  template <class Combinations>
  std::optional<Signs> across(const Splitter& splitter, const Combinations& combinations, const Signs& at, std::size_t i) {
    Signs behind = flipped(at, i);
    for (std::size_t j = i + 1; j < at.size() && !combinations.contains(behind); ++j)
      if (splitter.switches[j].vanishes) behind[j] = -behind[j];
    if (!combinations.contains(behind)) return std::nullopt;
    return behind;
  }

  /// The number and the side of the switch with an argument, which is added if there is none.
  static std::pair<std::size_t, int> switch_of(Splitter& splitter, Expression argument) {
    Graph& graph = splitter.graph;
    const Expression up = normal_form(graph, argument), down = normal_form(graph, graph.negate(argument));
    const auto [same, is_new] = splitter.numbers.try_emplace(up, splitter.switches.size());
    if (!is_new) return {same->second, 1};
    if (const auto opposite = splitter.numbers.find(down);
        opposite != splitter.numbers.end() && opposite->second != same->second) {
      splitter.numbers.erase(same);
      return {opposite->second, -1};
    }
    splitter.switches.push_back({argument});
    return {splitter.switches.size() - 1, 1};
  }

  bool is_one_of(const std::vector<Expression>& divisors, Expression divisor) const {
    return std::any_of(divisors.begin(), divisors.end(),
                       [&](Expression one) { return same_up_to_sign(graph_, one, divisor) != 0; });
  }

  /// Adds atan, tanh or atan2, if it jumps.
  void add_bounded(Splitter& out, Expression node, const std::vector<Expression>& divisors) {
    const Node n = graph_.node(node);
    Bend bend{node};
    if (!divisors.empty())
      for (const Expression inner : reachable(graph_, node))
        if (const auto quotient = as_quotient(graph_, inner, parameters_); quotient && is_one_of(divisors, quotient->divisor)) {
          const auto [number, side] = switch_of(out, quotient->divisor);
          bend.divisors.push_back({quotient->divisor, number, side});
          bend.number = std::max(bend.number, number);
        }
    if (n.operation == Operation::atan2 && bounds(graph_, n.b, parameters_).lower <= 0.0 && dependence(graph_, n.a).moves()) {
      const auto [number, side] = switch_of(out, n.a);
      Switch& own = out.switches[number];
      own.jumps = own.breaks = true;
      bend.cut = number;
      bend.side = side;
      bend.number = std::max(bend.number, number);
    }
    if (!bend.divisors.empty() || bend.cut) out.bends.push_back(std::move(bend));
  }

  /// `divisors`: those that become switches.
  Splitter find_switches(std::size_t m, const std::vector<Expression>& divisors) {
    Splitter out{graph_, {}, {}, parameters_, {}};
    for (const Expression part : reachable(graph_, roots(m))) {
      const Node n = graph_.node(part);
      if (!divisors.empty())
        if (const auto quotient = as_quotient(graph_, part, parameters_); quotient && is_one_of(divisors, quotient->divisor)) {
          Switch& own = out.switches[switch_of(out, quotient->divisor).first];
          own.jumps = own.breaks = true;
        }
      if (jumps_at_poles(n.operation)) {
        add_bounded(out, part, divisors);
        continue;
      }
      if (!is_nonsmooth(n.operation)) continue;
      const Expression argument = switching_argument(graph_, n);
      if (!dependence(graph_, argument).moves()) continue;  // the sign of a parameter is not an event
      for (const Expression inner : reachable(graph_, argument))
        if (is_jump(graph_.node(inner).operation) && dependence(graph_, inner).moves())
          throw EquationError(source_, pieces_.modes[m].place,
                              fmt::format("sign or step inside of {} in mode {} is not handled; write its modes out",
                                          n.operation == Operation::abs ? "abs" : function_name(n.operation),
                                          pieces_.modes[m].name));
      const auto [number, side] = switch_of(out, argument);
      out.bends.push_back({part, number, side});
      Switch& own = out.switches[number];
      own.jumps = own.jumps || is_jump(n.operation);
    }
    return out;
  }

  /// The divisors of quotients in bounded functions whose zeros a motion passes in some combination of signs: there, no equation
  /// is divided by them.
  std::vector<Expression> passed_divisors(std::size_t m, const Splitter& splitter) {
    std::vector<Expression> inside;
    for (const Expression part : reachable(graph_, roots(m))) {
      const Node n = graph_.node(part);
      if (jumps_at_poles(n.operation)) inside.push_back(part);
      if (is_nonsmooth(n.operation)) inside.push_back(switching_argument(graph_, n));
    }
    std::vector<Expression> divisors = vanishing_divisors(graph_, inside, parameters_, true);
    if (divisors.empty()) return divisors;
    std::vector<bool> passed(divisors.size(), false);
    for (const Signs& at : combinations_of(splitter, m)) {
      std::vector<Expression> field;
      for (const Expression f : pieces_.modes[m].field) field.push_back(splitter.resolved(f, at));
      const std::vector<Expression> bare = vanishing_divisors(graph_, field, parameters_, false);
      for (std::size_t k = 0; k < divisors.size(); ++k)
        passed[k] = passed[k] || !is_one_of(bare, splitter.resolved(divisors[k], at));
    }
    for (std::size_t k = divisors.size(); k-- > 0;)
      if (!passed[k]) divisors.erase(divisors.begin() + static_cast<std::ptrdiff_t>(k));
    return divisors;
  }

  /// Collects all combinations of signs that bounds do not exclude.
  void combine(const Splitter& splitter, Signs& signs, std::vector<Expression>& arguments, std::vector<Signs>& out,
               std::size_t m) {
    const std::size_t i = signs.size();
    if (i == splitter.switches.size()) {
      if (out.size() >= most_combinations) refuse_number(m);
      out.push_back(signs);
      return;
    }
    const Expression argument = splitter.argument(i, signs);
    for (const int sign : {1, -1}) {
      const Expression own = sign > 0 ? argument : graph_.negate(argument);
      // A motion in the mode has sign * argument >= 0, also for the earlier arguments.
      if (bounds(graph_, own, parameters_).upper < 0.0) continue;
      if (sign < 0 && graph_.is_constant(own, 0.0)) continue;  // it vanishes here: both branches coincide
      const bool refuted = std::any_of(arguments.begin(), arguments.end(), [&](Expression earlier) {
        const Expression sum = normal_form(graph_, graph_.add(earlier, own));
        // Opposite arguments are both zero: at a change of sign, not in a region of its own.
        if (splitter.switches[i].vanishes && graph_.is_constant(sum, 0.0) && !graph_.is_constant(own, 0.0)) return true;
        return bounds(graph_, sum, parameters_).upper < 0.0;
      });
      if (refuted) continue;
      signs.push_back(sign);
      arguments.push_back(own);
      combine(splitter, signs, arguments, out, m);
      signs.pop_back();
      arguments.pop_back();
    }
  }

  [[noreturn]] void refuse_number(std::size_t m) const {
    throw EquationError(
        source_, pieces_.modes[m].place,
        fmt::format("the nonsmooth functions of mode {} make more than {} modes of it", pieces_.modes[m].name, max_split_modes));
  }

  std::vector<Signs> combinations_of(const Splitter& splitter, std::size_t m) {
    std::vector<Signs> out;
    Signs signs;
    std::vector<Expression> arguments;
    combine(splitter, signs, arguments, out, m);
    return out;
  }

  void split(std::size_t m) {
    const Splitter plain = find_switches(m, {});
    const std::vector<Expression> divisors = passed_divisors(m, plain);
    split_.push_back({divisors.empty() ? plain : find_switches(m, divisors), {}, {}, {}, {}, out_.modes.size()});
    SplitMode& mode = split_.back();
    std::vector<Signs> combinations = combinations_of(mode.splitter, m);
    bool some_vanish = false;
    for (const Signs& at : combinations)
      for (std::size_t j = 0; j < at.size(); ++j)
        if (mode.splitter.switches[j].jumps && vanishes(mode.splitter, j, at))
          some_vanish = mode.splitter.switches[j].vanishes = true;
    if (some_vanish) combinations = combinations_of(mode.splitter, m);  // some of them are refuted now
    const Splitter& splitter = mode.splitter;
    const std::vector<Expression> parts = roots(m);
    std::map<Signs, std::vector<Expression>> values;
    for (const Signs& one : combinations)
      for (const Expression part : parts) values[one].push_back(splitter.resolved(part, one));
    const std::size_t count = splitter.switches.size();
    // A sign matters if it changes an expression of the mode anywhere, or the argument of another sign that matters, or if others
    // may change with it.
    std::vector<bool> matters;
    for (const Switch& one : splitter.switches) matters.push_back(one.breaks);
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t i = 0; i < count; ++i)
        for (const Signs& at : combinations) {
          if (matters[i]) continue;
          const auto other = across(splitter, values, at, i);
          if (!other) continue;
          bool makes_difference = values.at(at) != values.at(*other);
          for (std::size_t j = i + 1; j < count; ++j)
            makes_difference = makes_difference || (matters[j] && splitter.argument(j, at) != splitter.argument(j, *other));
          if (makes_difference) matters[i] = changed = true;
        }
    }
    // Combinations form one mode if they have the same expressions and arguments, and the same neighbouring modes across each
    // sign.
    std::map<Signs, std::size_t> part_of;
    std::map<std::vector<Expression>, std::size_t> with_expressions;
    for (const Signs& at : combinations) {
      std::vector<Expression> key = values.at(at);
      for (std::size_t i = 0; i < count; ++i)
        if (matters[i]) key.push_back(splitter.argument(i, at));
      part_of[at] = with_expressions.emplace(std::move(key), with_expressions.size()).first->second;
    }
    for (std::size_t parts_before = 0, parts_now = with_expressions.size(); parts_now != parts_before;) {
      std::map<std::vector<std::pair<int, std::size_t>>, std::size_t> with_neighbours;
      std::map<Signs, std::size_t> finer;
      for (const Signs& at : combinations) {
        std::vector<std::pair<int, std::size_t>> key{{0, part_of[at]}};
        for (std::size_t i = 0; i < count; ++i) {
          const auto other = across(splitter, part_of, at, i);
          const bool leads_away = other && part_of.at(*other) != part_of.at(at);
          key.emplace_back(leads_away ? at[i] : 0, leads_away ? part_of.at(*other) : 0);
        }
        finer[at] = with_neighbours.emplace(std::move(key), with_neighbours.size()).first->second;
      }
      parts_before = std::exchange(parts_now, with_neighbours.size());
      part_of = std::move(finer);
    }
    for (const Signs& one : combinations) {
      if (const std::size_t number = part_of[one]; number < mode.representatives.size()) {  // numbered in order of appearance
        for (std::size_t i = 0; i < count; ++i)
          if (mode.common[number][i] != one[i]) mode.common[number][i] = 0;
        continue;
      }
      mode.common.push_back(one);
      mode.representatives.push_back(one);
    }
    for (std::size_t number = 0; number < mode.representatives.size(); ++number) {
      const Signs& one = mode.representatives[number];
      mode.decisive.emplace_back(count, false);
      for (std::size_t i = 0; i < count; ++i) {
        const auto other = across(splitter, part_of, one, i);
        const bool breaks = splitter.switches[i].breaks && mode.common[number][i] != 0;  // else it changes nothing here
        mode.decisive.back()[i] = breaks || (other && part_of.at(*other) != part_of.at(one));
      }
    }
    mode.class_of = std::move(part_of);
    if (mode.representatives.size() > max_split_modes) refuse_number(m);
    for (std::size_t number = 0; number < mode.representatives.size(); ++number) {
      const Signs& one = mode.representatives[number];
      ModePiece piece = pieces_.modes[m];
      std::string branch;
      for (std::size_t i = 0; i < count; ++i)
        if (mode.decisive[number][i])
          branch += fmt::format("{}{} {} 0", branch.empty() ? ": " : ", ", shown(splitter.switches[i].argument),
                                one[i] > 0 ? ">" : "<");
      if (mode.representatives.size() > 1) piece.name += branch;
      for (Expression& f : piece.field) f = splitter.resolved(f, one);
      // No single sign may lead out of a combination that no state has: guards alone would not exclude it at a start.
      for (std::size_t i = 0; i < count; ++i)
        if (mode.common[number][i] != 0 && !mode.decisive[number][i]) {
          const Expression argument = splitter.argument(i, one);
          piece.conditions.push_back(one[i] > 0 ? argument : graph_.negate(argument));
        }
      out_.modes.push_back(std::move(piece));
    }
  }

  /// Expressions known to be nonnegative at an event in a mode.
  std::vector<Expression> certain(const EventPiece& event, const SplitMode& mode, std::size_t number,
                                  const std::vector<Expression>& field) {
    std::vector<Expression> list;
    const Signs &signs = mode.representatives[number], &common = mode.common[number];
    for (std::size_t i = 0; i < signs.size(); ++i) {
      if (common[i] == 0) continue;
      const Expression argument = mode.splitter.argument(i, signs);
      list.push_back(signs[i] > 0 ? argument : graph_.negate(argument));
    }
    // The rate of the guard: it rises.
    Expression rate = graph_.derivative(event.guard, graph_.time());
    for (const std::size_t i : dependence(graph_, event.guard).states)
      rate = graph_.add(rate, graph_.multiply(graph_.derivative(event.guard, graph_.state(i)), field[i]));
    list.push_back(rate);
    return list;
  }

  /// The sign of an expression if those of the list are nonnegative; 0: unknown.
  int sign_of(Expression e, const std::vector<Expression>& nonnegative) {
    const auto by_bounds = [&](Expression of) {
      const Bounds b = bounds(graph_, of, parameters_);
      return b.lower >= 0.0 ? 1 : b.upper <= 0.0 ? -1 : 0;
    };
    const Expression normal = normal_form(graph_, e);
    if (const int sign = by_bounds(normal); sign != 0) return sign;
    for (const Expression one : nonnegative) {
      const Expression base = normal_form(graph_, one);
      if (graph_.is_constant(base, 0.0)) continue;
      // Known by the sign of e / one, e - one or e + one.
      if (const int sign = by_bounds(normal_form(graph_, graph_.divide(normal, base))); sign != 0) return sign;
      if (by_bounds(normal_form(graph_, graph_.subtract(normal, base))) > 0) return 1;
      if (by_bounds(normal_form(graph_, graph_.add(normal, base))) < 0) return -1;
    }
    return 0;
  }

  /// A mode that the state may reach after an event, and the conditions that are positive if it does.
  struct Reached {
    std::size_t mode = 0;
    std::vector<Expression> conditions;
  };

  void distribute(std::size_t number_of_event) {
    const EventPiece& event = pieces_.events[number_of_event];
    const SplitMode &from = split_[event.from], &to = split_[event.to];
    first_of_event_.emplace_back();
    for (std::size_t number = 0; number < from.representatives.size(); ++number) {
      const Signs& signs = from.representatives[number];
      EventPiece piece = event;
      piece.from = from.first + number;
      piece.guard = from.splitter.resolved(event.guard, signs);
      for (Expression& one : piece.map) one = from.splitter.resolved(one, signs);
      if (piece.opening_rate) piece.opening_rate = from.splitter.resolved(*piece.opening_rate, signs);
      first_of_event_.back().push_back(out_.events.size());
      std::vector<Reached> rests{{}};
      if (piece.accumulation) {
        for (Expression& one : piece.accumulation->map) one = from.splitter.resolved(one, signs);
        rests = reached(piece, piece.accumulation->map, split_[event.accumulation->sticking_mode], from, number);
      }
      add_event(piece, reached(piece, piece.map, to, from, number), rests);
      if (event.otherwise) {
        out_.events.back().otherwise->event = event.otherwise->event;
        to_group_.push_back({out_.events.size() - 1, number});
      }
    }
  }

  /// Adds an event with the modes that it may reach, as several with the same guard if there are several.
  void add_event(const EventPiece& piece, const std::vector<Reached>& targets, const std::vector<Reached>& rests) {
    for (std::size_t i = 0; i < targets.size(); ++i)
      for (std::size_t j = 0; j < rests.size(); ++j) {
        EventPiece one = piece;
        one.to = targets[i].mode;
        if (one.accumulation) one.accumulation->sticking_mode = rests[j].mode;
        if (i + 1 < targets.size() || j + 1 < rests.size()) {
          if (!one.otherwise) one.otherwise.emplace();
          auto& conditions = one.otherwise->conditions;
          conditions.insert(conditions.end(), targets[i].conditions.begin(), targets[i].conditions.end());
          conditions.insert(conditions.end(), rests[j].conditions.begin(), rests[j].conditions.end());
          one.otherwise->event = out_.events.size() + 1;
        }
        out_.events.push_back(std::move(one));
      }
  }

  /// The new modes that a state may reach after an event with this map; the last one needs no condition.
  /// `flipped`: the sign that changes at the event.
  std::vector<Reached> reached(const EventPiece& piece, const std::vector<Expression>& map, const SplitMode& to,
                               const SplitMode& from, std::size_t number, std::optional<std::size_t> flipped = {}) {
    if (to.representatives.size() == 1) return {{to.first, {}}};
    const auto known = certain(piece, from, number, out_.modes[piece.from].field);
    Replacement after, on_guard;
    for (std::size_t i = 0; i < map.size(); ++i) after.emplace(graph_.state(i).index, map[i]);
    if (const auto solution = solve_guard(graph_, piece.guard, map.size(), [](std::size_t) { return true; }))
      on_guard.emplace(graph_.state(solution->state).index, solution->value);
    std::vector<Reached> targets;
    Signs so_far, given(to.splitter.switches.size(), 0);
    if (flipped) given[*flipped] = -from.representatives[number][*flipped];
    std::vector<Expression> conditions;
    follow(to, after, on_guard, known, given, so_far, conditions, targets);
    const bool one_mode =
        std::all_of(targets.begin(), targets.end(), [&](const Reached& one) { return one.mode == targets[0].mode; });
    if (one_mode) targets.resize(std::min<std::size_t>(1, targets.size()));
    if (targets.empty() || targets.size() > max_split_modes)
      throw EquationError(source_, piece.reset.line > 0 ? piece.reset : piece.when,
                          fmt::format("the event {} does not tell the signs in mode {} behind it; write its modes out",
                                      piece.name, pieces_.modes[static_cast<std::size_t>(&to - split_.data())].name));
    return targets;
  }

  /// `given`: the signs that are known, 0 for the others.
  void follow(const SplitMode& to, const Replacement& after, const Replacement& on_guard, const std::vector<Expression>& known,
              const Signs& given, Signs& signs, std::vector<Expression>& conditions, std::vector<Reached>& targets) {
    const std::size_t i = signs.size();
    if (i == to.splitter.switches.size()) {
      if (const auto found = to.class_of.find(signs); found != to.class_of.end())
        targets.push_back({to.first + found->second, conditions});
      return;
    }
    const Expression behind = graph_.substitute(to.splitter.argument(i, signs), after);
    std::vector<Expression> there;
    for (const Expression one : known) there.push_back(graph_.substitute(one, on_guard));
    const int sign = given[i] != 0 ? given[i] : sign_of(graph_.substitute(behind, on_guard), there);
    // The first target counts whose conditions hold. Those with a positive sign come first: a negative one needs no condition,
    // and an argument that is zero there leaves the others their signs.
    for (const int one : {1, -1}) {
      if (sign == -one) continue;
      signs.push_back(one);
      const bool tested = sign == 0 && one > 0;
      if (tested) conditions.push_back(behind);
      follow(to, after, on_guard, known, given, signs, conditions, targets);
      if (tested) conditions.pop_back();
      signs.pop_back();
    }
  }

  /// Adds the events at which the arguments change their signs.
  void switch_branches(std::size_t m) {
    const SplitMode& mode = split_[m];
    for (std::size_t number = 0; number < mode.representatives.size(); ++number) {
      const Signs& signs = mode.representatives[number];
      for (std::size_t i = 0; i < signs.size(); ++i) {
        if (!mode.decisive[number][i]) continue;
        const Expression argument = mode.splitter.argument(i, signs);
        EventPiece event;
        event.name = fmt::format("{} {}", shown(mode.splitter.switches[i].argument), signs[i] > 0 ? "falls" : "rises");
        event.text = split_event;
        event.from = mode.first + number;
        event.guard = signs[i] > 0 ? graph_.negate(argument) : argument;
        for (std::size_t j = 0; j < pieces_.modes[m].field.size(); ++j) event.map.push_back(graph_.state(j));
        event.when = event.reset = pieces_.modes[m].place;
        const auto behind = across(mode.splitter, mode.class_of, signs, i);
        bool jumps = mode.splitter.switches[i].jumps;
        for (std::size_t j = i + 1; j < signs.size() && behind; ++j)
          jumps = jumps || (mode.splitter.switches[j].vanishes &&
                            vanishes(mode.splitter, j, signs) != vanishes(mode.splitter, j, *behind));
        event.continuous = !jumps;
        // Where arguments jump, the signs of others change as well.
        const std::vector<Reached> targets = mode.splitter.switches[i].breaks
                                                 ? reached(event, event.map, mode, mode, number, i)
                                                 : std::vector<Reached>{{mode.first + mode.class_of.at(behind.value()), {}}};
        if (targets.size() > 1 || targets[0].mode != event.from) add_event(event, targets, {{}});
      }
    }
  }

  Graph& graph_;
  const Pieces& pieces_;
  const std::vector<ParameterInfo>& parameters_;
  const Symbols& symbols_;
  const Source& source_;
  std::vector<SplitMode> split_;
  std::vector<std::vector<std::size_t>> first_of_event_;       // index among the new events, for each branch of its mode
  std::vector<std::pair<std::size_t, std::size_t>> to_group_;  // new events with an old alternative, and their branch
  Pieces out_;
};

}  // namespace

bool is_nonsmooth(Operation operation) {
  using enum Operation;
  return operation == abs || operation == sign || operation == step || operation == max || operation == min;
}

Expression switching_argument(Graph& graph, const Node& node) {
  if (operands(node.operation) == 2) return graph.subtract(node.a, node.b);
  // sign(a/b) and step(a/b) change at the zeros of b too, where a/b is no guard: a b has the same sign.
  const Node argument = graph.node(node.a);
  const bool of_sign = node.operation == Operation::sign || node.operation == Operation::step;
  return of_sign && argument.operation == Operation::divide ? graph.multiply(argument.a, argument.b) : node.a;
}

Pieces split_nonsmooth(Graph& graph, const Pieces& pieces, const std::vector<ParameterInfo>& parameters, const Symbols& symbols,
                       const Source& source) {
  return Separation(graph, pieces, parameters, symbols, source).run();
}

}  // namespace graze::equations
