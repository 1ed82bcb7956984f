// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/contacts.hpp>

#include <graze/lib/equations/constraints.hpp>
#include <graze/lib/equations/polynomial.hpp>

#include <fmt/format.h>

#include <algorithm>

namespace graze::equations {

namespace {

/// A negative constant is refused.
void not_negative(const Coordinates& coordinates, Expression e, const Text& text, const std::string& what) {
  const Node& node = coordinates.graph.node(e);
  if (node.operation == Operation::constant && node.value < 0.0)
    coordinates.names.refuse(text.place, fmt::format("the {} is {}; allowed is >= 0", what, text.text));
}

/// Computes direction, response and the quantities that follow from them.
void set_response(const Coordinates& coordinates, const Square& inverse_mass, Contact& contact) {
  Graph& graph = coordinates.graph;
  for (std::size_t i = 0; i < coordinates.n; ++i) contact.direction.push_back(graph.derivative(contact.rate, coordinates.v(i)));
  for (std::size_t i = 0; i < coordinates.n; ++i)
    contact.response.push_back(coordinates.tidy(coordinates.dot(inverse_mass[i], contact.direction)));
  contact.compliance = coordinates.tidy(coordinates.dot(contact.direction, contact.response));
  for (const Expression one : contact.response) contact.share.push_back(coordinates.tidy(graph.divide(one, contact.compliance)));
}

void check_name(const Names& names, const Text& name, const char* kind, const std::vector<Contact>& others) {
  if (name.text.empty()) names.refuse(name.place, fmt::format("a {} without a name", kind));
  for (const Contact& other : others)
    if (other.name.text == name.text)
      names.refuse(name.place, fmt::format("a stop or friction called '{}' exists already", name.text));
}

void read_law(const Coordinates& coordinates, const StopText& text, Contact& stop) {
  Graph& graph = coordinates.graph;
  Names& names = coordinates.names;
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
    names.refuse(text.law.place, fmt::format("the stop {} has an unknown law '{}'{}", name, text.law.text,
                                             suggestion_or_list(text.law.text, known)));
  }
  if (text.values.size() < law->least || text.values.size() > law->most)
    names.refuse(text.law.place, fmt::format("the law {} of the stop {} has {} value{}; it takes {}", law->name, name,
                                             text.values.size(), text.values.size() == 1 ? "" : "s", law->values));
  const std::string where = fmt::format("in the law of {}", name);
  // Depth and its rate are symbols of their own until the law is known.
  const Expression d = graph.state(2 * coordinates.n), d_rate = graph.state(2 * coordinates.n + 1);
  const Expression depth = graph.negate(stop.gap), depth_rate = graph.negate(stop.rate);
  if (law->name == "newton") {
    stop.rigid = true;
    stop.restitution = read_expression(coordinates, text.values[0], where);
    const Node node = graph.node(stop.restitution);
    if (node.operation == Operation::constant && !(node.value >= 0.0 && node.value <= 1.0))
      names.refuse(text.values[0].place,
                   fmt::format("the restitution of the stop {} is {}; allowed is 0 to 1", name, text.values[0].text));
    return;
  }
  Expression force;
  if (law->name == "force") {
    const Scope with_depth = with_name(coordinates.scope, "d", d);
    const Expression raw = parse_expression(graph, names.text.source, text.values[0], with_depth, where, &names.hazards);
    force = without_rates(coordinates, raw, text.values[0].place, where, {{graph.rate(d).index, d_rate}});
    Replacement powers;
    for (const Expression part : reachable(graph, force)) {
      const Node node = graph.node(part);
      if (node.operation != Operation::power || node.a != d) continue;
      const Node exponent = graph.node(node.b);
      if (exponent.operation == Operation::constant && exponent.value >= 1.0)
        powers.emplace(part.index, graph.contact_power(d, exponent.value));
    }
    force = graph.substitute(force, powers);
  } else {
    Column coefficients;
    for (const Text& one : text.values) coefficients.push_back(read_expression(coordinates, one, where));
    const bool hertz = law->name == "hertz";
    not_negative(coordinates, coefficients[0], text.values[0],
                 fmt::format("stiffness {} of the stop {}", hertz ? "k_H" : "k", name));
    const Expression elastic = graph.multiply(coefficients[0], hertz ? graph.contact_power(d, 1.5) : d);
    force = elastic;
    if (coefficients.size() > 1) {
      not_negative(coordinates, coefficients[1], text.values[1],
                   fmt::format("damping {} of the stop {}", hertz ? "b_H" : "c", name));
      const Expression damping = graph.multiply(coefficients[1], d_rate);
      force = hertz ? graph.multiply(elastic, graph.add(graph.constant(1.0), damping)) : graph.add(elastic, damping);
    }
  }
  const Expression at_opening = graph.substitute(force, {{d.index, coordinates.zero()}});
  stop.begins_softly = is_zero(graph, at_opening);
  if (!text.adhesion && !stop.begins_softly) stop.states = 3;
  const Replacement motion{{d.index, depth}, {d_rate.index, depth_rate}};
  stop.force = graph.substitute(force, motion);
}

/// A stop or a friction, with its name checked and its places in the text.
template <class ContactText>
Contact named_contact(const Coordinates& coordinates, const ContactText& text, const char* kind, const Place& where,
                      const std::vector<Contact>& others) {
  check_name(coordinates.names, text.name, kind, others);
  Contact contact;
  contact.name = text.name;
  contact.count = text.count;
  contact.where = where;
  contact.law = text.law.place;
  return contact;
}

Contact read_stop(const Coordinates& coordinates, const Square& inverse_mass, const StopText& text,
                  const std::vector<Contact>& others) {
  Graph& graph = coordinates.graph;
  Names& names = coordinates.names;
  const std::string& name = text.name.text;
  Contact stop = named_contact(coordinates, text, "stop", text.gap.place, others);
  stop.gap = read_expression(coordinates, text.gap, fmt::format("in the gap of {}", name));
  if (coordinates.has_velocity(stop.gap))
    names.refuse(text.gap.place,
                 fmt::format("the gap of {} depends on the velocity {}", name, coordinates.velocity_in(stop.gap)));
  if (dependence(graph, stop.gap).states.empty() || is_zero(graph, stop.gap))
    names.refuse(text.gap.place, fmt::format("the gap of {} depends on no coordinate", name));
  stop.rate = rate_along(graph, stop.gap, coordinates.field_of(Column(coordinates.n, coordinates.zero())));
  set_response(coordinates, inverse_mass, stop);
  if (is_zero(graph, stop.compliance)) names.refuse(text.gap.place, fmt::format("the gap of {} depends on no coordinate", name));
  read_law(coordinates, text, stop);
  return stop;
}

/// Whether the speed of one friction is a constant multiple of that of the other.
bool slides_with(const Coordinates& coordinates, const Contact& friction, const Contact& other) {
  Graph& graph = coordinates.graph;
  std::size_t k = 0;
  while (k < coordinates.n && coordinates.vanishes(other.direction[k])) ++k;
  if (k == coordinates.n) return false;
  const auto proportional = [&](Expression a, Expression b) {
    return coordinates.vanishes(graph.subtract(graph.multiply(a, other.direction[k]), graph.multiply(b, friction.direction[k])));
  };
  for (std::size_t i = 0; i < coordinates.n; ++i)
    if (!proportional(friction.direction[i], other.direction[i])) return false;
  return proportional(friction.rate, other.rate);
}

Contact read_friction(const Coordinates& coordinates, const Square& inverse_mass, const FrictionText& text,
                      const std::vector<Contact>& others) {
  Graph& graph = coordinates.graph;
  Names& names = coordinates.names;
  const std::string& name = text.name.text;
  Contact friction = named_contact(coordinates, text, "friction", text.speed.place, others);
  friction.is_stop = false;
  friction.states = 3;
  friction.rate = read_expression(coordinates, text.speed, fmt::format("in the speed of {}", name));
  if (!coordinates.has_velocity(friction.rate))
    names.refuse(text.speed.place, fmt::format("the speed of {} depends on no velocity", name));
  set_response(coordinates, inverse_mass, friction);
  for (const Expression one : friction.direction)
    if (coordinates.has_velocity(one))
      names.refuse(text.speed.place, fmt::format("the speed of {} is not linear in {}", name, coordinates.velocity_in(one)));
  for (const Contact& other : others)
    if (!other.is_stop && slides_with(coordinates, friction, other))
      names.refuse(text.speed.place,
                   fmt::format("{} slides whenever {} does, at the same speed or a multiple of it: which of them holds is "
                               "not determined; write one friction with the sum of their forces",
                               name, other.name.text));
  const Expression normal = read_expression(coordinates, text.normal, fmt::format("in the normal force of {}", name));
  not_negative(coordinates, normal, text.normal, fmt::format("normal force of the friction {}", name));
  const std::string where = fmt::format("in the law of {}", name);
  const auto coefficient = [&](Expression u) {
    return read_expression(coordinates, text.law, where, with_name(coordinates.scope, "u", u));
  };
  friction.slip_force[forward] = graph.multiply(coefficient(friction.rate), normal);
  friction.slip_force[backward] = graph.multiply(coefficient(graph.negate(friction.rate)), normal);
  const Expression slow = coefficient(coordinates.zero());
  not_negative(coordinates, slow, text.law, fmt::format("coefficient of the friction {}", name));
  Expression sticking = slow;
  if (text.sticking) {
    sticking = read_expression(coordinates, *text.sticking, fmt::format("in the static coefficient of {}", name));
    const double at_rest = coordinates.value(sticking), sliding = coordinates.value(slow);
    if (at_rest < sliding)
      names.refuse(
          text.sticking->place,
          fmt::format("the static coefficient of {} is {:.6g}, less than that of slow sliding, {:.6g}", name, at_rest, sliding));
  }
  friction.same_limit = is_zero(graph, graph.subtract(sticking, slow));
  friction.limit = graph.multiply(sticking, normal);
  return friction;
}

}  // namespace

std::vector<Contact> read_contacts(const Coordinates& coordinates, const Square& inverse_mass) {
  const SystemText& text = coordinates.names.text;
  std::vector<Contact> out;
  for (const StopText& stop : text.stops) out.push_back(read_stop(coordinates, inverse_mass, stop, out));
  for (const FrictionText& friction : text.friction) out.push_back(read_friction(coordinates, inverse_mass, friction, out));
  return out;
}

}  // namespace graze::equations
