// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/sliding.hpp>

#include <graze/lib/equations/constraints.hpp>
#include <graze/lib/equations/polynomial.hpp>

#include <fmt/format.h>

#include <algorithm>

namespace graze::equations {

namespace {

class Surfaces {
 public:
  Surfaces(Names& names, Pieces& pieces) : names_(names), graph_(names.graph), pieces_(pieces) {}

  void add(const SurfaceText& text) {
    const Expression h = function_of(text);
    const std::size_t below = mode_number(names_, pieces_, text.below, "a surface");
    const std::size_t above = mode_number(names_, pieces_, text.above, "a surface");
    if (below == above)
      names_.refuse(text.above.place, fmt::format("the mode {} stands on both sides of a surface", text.above.text));
    const Expression rate_below = rate_along(graph_, h, pieces_.modes[below].field);
    const Expression rate_above = rate_along(graph_, h, pieces_.modes[above].field);
    const std::string& name = text.sliding ? text.sliding->text : text.function.text;
    std::optional<std::size_t> sliding;
    Column stay = identity();
    if (text.sliding) {
      sliding = pieces_.modes.size();
      pieces_.modes.push_back(sliding_mode(text, h, below, above, rate_below, rate_above));
      if (solution_) stay[solution_->state] = solution_->value;
    }
    SurfacePiece surface{h, below, above, sliding, {}};
    if (solution_) surface.state_on_surface.emplace(graph_.state(solution_->state).index, solution_->value);
    pieces_.surfaces.push_back(std::move(surface));
    const auto on_surface = [&](Expression e) {
      return solution_ ? graph_.substitute(e, {{graph_.state(solution_->state).index, solution_->value}}) : e;
    };
    for (const bool upwards : {true, false}) {
      const std::size_t from = upwards ? below : above, to = upwards ? above : below;
      const Expression guard = upwards ? h : graph_.negate(h);
      const std::string way = upwards ? " upwards" : " downwards";
      if (sliding) {
        EventPiece& event = push(text, name + (upwards ? " from below" : " from above"), EventKind::stick, from, *sliding, guard);
        event.map = stay;
        event.count = text.count;
        // It slides if the field on the other side points back.
        const Expression back = upwards ? graph_.negate(rate_above) : rate_below;
        event.otherwise = AlternativePiece{{on_surface(back)}, pieces_.events.size()};
      }
      EventPiece& crossing = push(text, name + way, EventKind::other, from, to, guard);
      if (upwards && !sliding) crossing.count = text.count;
    }
    if (!sliding) return;
    push(text, name + " left downwards", EventKind::release, *sliding, below, on_surface(graph_.negate(rate_below))).continuous =
        true;
    push(text, name + " left upwards", EventKind::release, *sliding, above, on_surface(rate_above)).continuous = true;
    solution_.reset();
  }

 private:
  using Column = std::vector<Expression>;

  Expression function_of(const SurfaceText& text) const {
    const Expression h = parse_expression(graph_, names_.text.source, text.function, names_.scope(true),
                                          "in the function of a surface", &names_.hazards);
    const Dependence on = dependence(graph_, h);
    if (on.rate) names_.refuse(text.function.place, "a rate stands in the function of a surface");
    if (on.states.empty() || is_zero(graph_, h))
      names_.refuse(text.function.place, "the function of a surface does not depend on the motion: no state stands in it");
    return h;
  }

  Column identity() const {
    Column out;
    for (std::size_t i = 0; i < names_.symbols.states.size(); ++i) out.push_back(graph_.state(i));
    return out;
  }

  ModePiece sliding_mode(const SurfaceText& text, Expression h, std::size_t below, std::size_t above, Expression rate_below,
                         Expression rate_above) {
    for (const ModePiece& other : pieces_.modes)
      if (other.name == text.sliding->text)
        names_.refuse(text.sliding->place, fmt::format("a mode called '{}' exists already", other.name));
    const Column &f = pieces_.modes[below].field, &g = pieces_.modes[above].field;
    const Expression sum = graph_.subtract(rate_below, rate_above);
    if (is_zero(graph_, sum))
      names_.refuse(text.function.place,
                    fmt::format("nothing slides on this surface: the fields of {} and {} cross it at the same rate",
                                text.below.text, text.above.text));
    solution_ = solve_constraint(names_, h, [](std::size_t) { return true; });
    ModePiece mode;
    mode.name = text.sliding->text;
    mode.place = text.sliding->place;
    ConstraintPiece& constraint = mode.constraints.emplace_back(ConstraintPiece{h});
    for (std::size_t i = 0; i < f.size(); ++i) constraint.direction.push_back(graph_.subtract(f[i], g[i]));
    mode.equation = pieces_.modes[below].equation;
    const Expression weight = graph_.divide(rate_below, sum);  // weight of the field above
    for (std::size_t i = 0; i < f.size(); ++i) {
      const Expression both = f[i] == g[i] ? f[i] : graph_.add(f[i], graph_.multiply(weight, graph_.subtract(g[i], f[i])));
      mode.field.push_back(solution_ ? graph_.substitute(both, {{graph_.state(solution_->state).index, solution_->value}})
                                     : both);
    }
    if (solution_) {
      mode.field[solution_->state] = graph_.constant(0.0);  // its own value does not contain it
      mode.field[solution_->state] = rate_along(graph_, solution_->value, mode.field);
    }
    return mode;
  }

  EventPiece& push(const SurfaceText& text, const std::string& name, EventKind kind, std::size_t from, std::size_t to,
                   Expression guard) {
    EventPiece event;
    event.name = name;
    event.text = made_event;
    event.kind = kind;
    event.from = from;
    event.to = to;
    event.guard = guard;
    event.map = identity();
    event.when = event.reset = text.function.place;
    pieces_.events.push_back(std::move(event));
    return pieces_.events.back();
  }

  Names& names_;
  Graph& graph_;
  Pieces& pieces_;
  std::optional<Solution> solution_;  // of h = 0
};

}  // namespace

void add_surfaces(Names& names, Pieces& pieces) {
  Surfaces surfaces(names, pieces);
  for (const SurfaceText& text : names.text.surfaces) surfaces.add(text);
}

}  // namespace graze::equations
