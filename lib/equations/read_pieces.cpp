// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/read_pieces.hpp>

#include <graze/lib/equations/constraints.hpp>
#include <graze/lib/equations/mechanics.hpp>
#include <graze/lib/equations/polynomial.hpp>
#include <graze/lib/equations/sliding.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace graze::equations {

Expression Rates::resolve(Expression e) {
  Graph& graph = names_.graph;
  if (!dependence(graph, e).rate) return e;
  Replacement known;
  for (const Expression part : reachable(graph, e)) {
    const Node n = graph.node(part);
    if (n.operation != Operation::rate) continue;
    known.emplace(part.index, rate_along(graph, graph.substitute(n.a, known), [this](std::size_t i) { return field(i); }));
  }
  return graph.substitute(e, known);
}

Expression Rates::field(std::size_t state) {
  if (field_[state]) return *field_[state];
  if (in_progress_[state])
    names_.refuse(mode_.equation[state],
                  fmt::format("the rate of {} in mode {} depends on itself", names_.symbols.states[state], mode_.name));
  in_progress_[state] = true;
  field_[state] = resolve(mode_.field[state]);
  return *field_[state];
}

namespace {

constexpr std::array event_kinds = {EventKind::impact, EventKind::enter,   EventKind::leave,
                                    EventKind::stick,  EventKind::release, EventKind::other};

class PiecesReader {
 public:
  explicit PiecesReader(Names& names) : names_(names), text_(names.text), graph_(names.graph) {}

  Pieces read() {
    make_modes();
    read_events();
    return std::move(out_);
  }

 private:
  void read_modes() {
    if (text_.modes.empty()) names_.refuse({}, "the system has no modes");
    const Scope names = names_.scope(true);
    for (const ModeText& text : text_.modes) {
      ModePiece mode;
      mode.name = text.name.text;
      mode.place = text.name.place;
      std::vector<std::optional<Assignment>> equation(names_.states.size());
      const auto where = [&](std::string_view name) { return fmt::format("in the equation of {}", name); };
      for (Assignment& one : parse_block(graph_, text_.source, text.equations, names, where, fmt::format("in mode {}", mode.name),
                                         &names_.hazards)) {
        const auto i = names_.state_number(one.name);
        if (!i)
          names_.refuse(one.place, fmt::format("an equation of '{}', which is no state, in mode {}{}", one.name, mode.name,
                                               suggestion(one.name, names_.symbols.states)));
        if (!one.primed) names_.refuse(one.place, fmt::format("an equation of mode {} begins with {}' =", mode.name, one.name));
        if (equation[*i]) names_.refuse(one.place, fmt::format("a second equation of {} in mode {}", one.name, mode.name));
        equation[*i] = std::move(one);
      }
      for (std::size_t i = 0; i < equation.size(); ++i) {
        if (!equation[i])
          names_.refuse(text.name.place.line > 0 ? text.name.place : text.equations.place,
                        fmt::format("the state {} has no equation in mode {}", names_.symbols.states[i], mode.name));
        mode.field.push_back(equation[i]->value);
        mode.equation.push_back(equation[i]->equation);
      }
      out_.modes.push_back(std::move(mode));
    }
    std::vector<std::vector<Expression>> resolved;
    for (const ModePiece& mode : out_.modes) {
      Rates rates(names_, mode);
      resolved.emplace_back();
      for (std::size_t i = 0; i < names_.symbols.states.size(); ++i) resolved.back().push_back(rates.field(i));
    }
    for (std::size_t m = 0; m < out_.modes.size(); ++m) out_.modes[m].field = resolved[m];
  }

  /// Makes the modes from the text, from mechanics and from surfaces.
  void make_modes() {
    if (text_.mechanics) {
      out_ = make_mechanics(names_);
    } else {
      read_modes();
    }
    add_surfaces(names_, out_);
    for (const ModePiece& mode : out_.modes) rates_.emplace_back(names_, mode);
  }

  std::size_t mode_of(const Text& name, const std::string& event) const {
    return mode_number(names_, out_, name, "the event " + event);
  }

  /// A mode to which a reset may lead; it does if the conditions are positive.
  struct Side {
    std::size_t mode = 0;
    std::vector<Expression> conditions;
  };

  /// Finds the modes after a reset that names no mode: it stays in its mode, but goes to the side of a surface on which it
  /// ends.
  void find_sides(const Side& side, const std::vector<Expression>& decided, const std::vector<Expression>& map,
                  std::vector<Side>& out) {
    Replacement after;
    for (std::size_t i = 0; i < map.size(); ++i) after.emplace(graph_.state(i).index, map[i]);
    for (const SurfacePiece& surface : out_.surfaces) {
      if (!surface.parts(side.mode) || std::find(decided.begin(), decided.end(), surface.h) != decided.end()) continue;
      const Expression behind = graph_.substitute(surface.h, after);
      const Expression change =
          side.mode == surface.sliding ? graph_.substitute(behind, surface.state_on_surface) : graph_.subtract(behind, surface.h);
      if (is_zero(graph_, change)) continue;
      std::vector<Expression> known = decided;
      known.push_back(surface.h);
      for (const bool upwards : {true, false}) {
        if (surface.below == surface.above && !upwards) break;
        Side next{upwards ? surface.above : surface.below, side.conditions};
        if (surface.below != surface.above) next.conditions.push_back(upwards ? behind : graph_.negate(behind));
        find_sides(next, known, map, out);
      }
      return;
    }
    out.push_back(side);
  }

  void read_events() {
    const Scope names = names_.scope(true);
    for (std::size_t number = 0; number < text_.events.size(); ++number) {
      const EventText& text = text_.events[number];
      const std::string& name = text.name.text;
      EventPiece event{
          .name = name, .text = number, .count = text.count, .guard = {}, .map = {}, .when = text.when.place, .reset = {}};
      if (text.kind) {
        std::vector<std::string> kinds;
        for (const EventKind kind : event_kinds) kinds.emplace_back(event_kind_name(kind));
        const auto found = std::find(kinds.begin(), kinds.end(), text.kind->text);
        if (found == kinds.end())
          names_.refuse(text.kind->place, fmt::format("the event {} has an unknown kind '{}'{}", name, text.kind->text,
                                                      suggestion_or_list(text.kind->text, kinds)));
        event.kind = event_kinds[static_cast<std::size_t>(found - kinds.begin())];
      }
      const Expression guard =
          parse_expression(graph_, text_.source, text.when, names, fmt::format("in the guard of {}", name), &names_.hazards);
      std::vector<Expression> map;
      for (std::size_t i = 0; i < names_.symbols.states.size(); ++i) map.push_back(graph_.state(i));
      if (text.reset) {
        event.reset = text.reset->place;
        std::vector<char> seen(map.size(), 0);
        const auto where = [&](std::string_view of) { return fmt::format("in the reset of {} by {}", of, name); };
        for (const Assignment& one : parse_block(graph_, text_.source, *text.reset, names, where,
                                                 fmt::format("in the reset of {}", name), &names_.hazards)) {
          const auto i = names_.state_number(one.name);
          if (!i)
            names_.refuse(one.place, fmt::format("the reset of {} sets '{}', which is no state{}", name, one.name,
                                                 suggestion_or_list(one.name, names_.symbols.states)));
          if (one.primed) names_.refuse(one.place, fmt::format("the reset of {} sets a rate; write {} = ...", name, one.name));
          if (seen[*i]++) names_.refuse(one.place, fmt::format("the reset of {} sets {} twice", name, one.name));
          map[*i] = one.value;
        }
      }
      const std::size_t first = text.from ? mode_of(*text.from, name) : 0;
      const std::size_t last = text.from ? first : out_.modes.size() - 1;
      for (event.from = first; event.from <= last; ++event.from) {
        event.to = text.to ? mode_of(*text.to, name) : event.from;
        event.guard = rates_[event.from].resolve(guard);
        if (dependence(graph_, event.guard).states.empty() || is_zero(graph_, event.guard))
          names_.refuse(text.when.place,
                        fmt::format("the guard of {} does not depend on the motion: no state stands in it", name));
        event.map.clear();
        for (const Expression one : map) event.map.push_back(rates_[event.from].resolve(one));
        std::vector<Side> sides;
        if (text.to) {
          sides.push_back({event.to, {}});
        } else {
          find_sides({event.to, {}}, {}, event.map, sides);
        }
        for (std::size_t i = 0; i < sides.size(); ++i) {
          event.to = sides[i].mode;
          event.otherwise.reset();
          if (i + 1 < sides.size()) event.otherwise = AlternativePiece{sides[i].conditions, out_.events.size() + 1};
          out_.events.push_back(event);
        }
      }
    }
  }

  Names& names_;
  const SystemText& text_;
  Graph& graph_;
  Pieces out_;
  std::vector<Rates> rates_;  // of each mode
};

}  // namespace

Pieces read_pieces(Names& names) { return PiecesReader(names).read(); }

}  // namespace graze::equations
