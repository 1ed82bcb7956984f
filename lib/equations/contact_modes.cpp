// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/contact_modes.hpp>

#include <graze/lib/equations/constraints.hpp>

#include <fmt/format.h>

#include <algorithm>

namespace graze::equations {

namespace {

bool constrains(const Contact& contact, int status) {
  return contact.is_stop ? contact.rigid && status == closed : status == stuck;
}

/// Solves constraint = 0 for one more state, and returns it.
std::optional<std::size_t> replace(const Names& names, Combination& at, Expression constraint,
                                   const std::function<bool(std::size_t)>& allowed) {
  Graph& graph = names.graph;
  Replacement known;
  for (const Solution& one : at.solved) known.emplace(graph.state(one.state).index, one.value);
  const auto solution = solve_constraint(names, graph.substitute(constraint, known), allowed);
  if (!solution) return std::nullopt;
  for (Solution& one : at.solved)
    one.value = graph.substitute(one.value, {{graph.state(solution->state).index, solution->value}});
  at.solved.push_back(*solution);
  return solution->state;
}

/// Computes accelerations, multipliers and the states that constraints determine; false: the constraints are dependent.
bool constrain(const Coordinates& coordinates, const Square& inverse_mass, Column force, const std::vector<Contact>& contacts,
               Combination& at) {
  Graph& graph = coordinates.graph;
  const std::size_t n = coordinates.n;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Contact& contact = contacts[c];
    std::optional<Expression> size;
    if (contact.is_stop) {
      if (!contact.rigid && at.status[c] == closed) size = contact.force;
    } else if (at.status[c] != stuck) {
      const Expression friction = *contact.slip_force[at.status[c]];
      size = at.status[c] == forward ? graph.negate(friction) : friction;
    }
    for (std::size_t i = 0; i < n && size; ++i) force[i] = graph.add(force[i], graph.multiply(contact.direction[i], *size));
    if (constrains(contact, at.status[c])) at.constraints.push_back(c);
  }
  for (std::size_t i = 0; i < n; ++i) at.acceleration.push_back(coordinates.dot(inverse_mass[i], force));
  if (at.constraints.empty()) return true;
  const Column free = coordinates.field_of(at.acceleration);
  if (at.constraints.size() == 1) {
    const Contact& contact = contacts[at.constraints[0]];
    const Expression acceleration = rate_along(graph, contact.rate, free);
    at.multiplier.push_back(graph.negate(graph.divide(acceleration, contact.compliance)));
    for (std::size_t i = 0; i < n; ++i)
      at.acceleration[i] = graph.subtract(at.acceleration[i], graph.multiply(contact.share[i], acceleration));
  } else {
    Square A, B;
    for (const std::size_t c : at.constraints) {
      A.emplace_back();
      for (const std::size_t other : at.constraints)
        A.back().push_back(coordinates.dot(contacts[c].direction, contacts[other].response));
      B.push_back({graph.negate(rate_along(graph, contacts[c].rate, free))});
    }
    const auto solution = solve_linear(coordinates, A, B);
    if (!solution) return false;
    for (std::size_t k = 0; k < at.constraints.size(); ++k) {
      at.multiplier.push_back((*solution)[k][0]);
      for (std::size_t i = 0; i < n; ++i)
        at.acceleration[i] =
            graph.add(at.acceleration[i], graph.multiply(contacts[at.constraints[k]].response[i], at.multiplier[k]));
    }
  }
  for (const std::size_t c : at.constraints) {
    std::optional<std::size_t> coordinate;
    if (contacts[c].is_stop) coordinate = replace(coordinates.names, at, contacts[c].gap, [&](std::size_t i) { return i < n; });
    // For a determined coordinate, its velocity.
    const auto own = [&](std::size_t i) { return coordinate && i == n + *coordinate; };
    if (!coordinate || !replace(coordinates.names, at, contacts[c].rate, own))
      replace(coordinates.names, at, contacts[c].rate, [&](std::size_t i) { return i >= n; });
  }
  for (const Solution& one : at.solved) at.replacement.emplace(graph.state(one.state).index, one.value);
  return true;
}

std::string mode_name(const std::vector<Contact>& contacts, const std::vector<int>& status) {
  std::string out;
  for (std::size_t c = 0; c < status.size(); ++c) {
    const Contact& contact = contacts[c];
    if (contact.is_stop && status[c] == open) continue;
    out += (out.empty() ? "" : "+") + contact.name.text;
    if (contact.is_stop && status[c] == apart) out += " apart";
    if (!contact.is_stop) out += status[c] == forward ? " forward" : status[c] == backward ? " backward" : " stick";
  }
  return out.empty() ? "free" : out;
}

}  // namespace

Expression Combination::multiplier_of(std::size_t contact) const {
  const auto found = std::find(constraints.begin(), constraints.end(), contact);
  return multiplier[static_cast<std::size_t>(found - constraints.begin())];
}

const Combination* ContactModes::find(const std::vector<int>& status) const {
  const auto found = by_status.find(status);
  return found == by_status.end() ? nullptr : &combinations[found->second];
}

ContactModes combine_contacts(const Coordinates& coordinates, const Square& inverse_mass, const Column& force,
                              std::vector<Contact> contacts) {
  std::size_t count = 1;
  for (const Contact& contact : contacts) {
    count *= static_cast<std::size_t>(contact.states);
    if (count > max_contact_modes)
      coordinates.names.refuse(contact.name.place, fmt::format("stops and friction up to {} make {} modes; at most {} are made",
                                                               contact.name.text, count, max_contact_modes));
  }
  std::vector<int> status(contacts.size(), 0);
  ContactModes out{std::move(contacts)};
  for (std::size_t number = 0; number < count; ++number) {
    Combination at;
    at.status = status;
    if (constrain(coordinates, inverse_mass, force, out.contacts, at)) {
      at.mode = out.combinations.size();
      out.by_status.emplace(status, at.mode);
      out.combinations.push_back(std::move(at));
    }
    for (std::size_t c = 0; c < status.size(); ++c) {
      if (++status[c] < out.contacts[c].states) break;
      status[c] = 0;
    }
  }
  return out;
}

ModePiece make_mode(const Coordinates& coordinates, const std::vector<Contact>& contacts, const Combination& at) {
  Graph& graph = coordinates.graph;
  const MechanicsText& text = coordinates.text;
  const std::size_t n = coordinates.n;
  ModePiece mode;
  mode.name = mode_name(contacts, at.status);
  mode.place = text.place;
  mode.field.assign(2 * n, coordinates.zero());
  const Column raw = coordinates.field_of(at.acceleration);
  std::vector<char> given(2 * n, 0);
  for (const Solution& one : at.solved) given[one.state] = 1;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (!given[i]) mode.field[i] = graph.substitute(raw[i], at.replacement);
    const std::size_t coordinate = i < n ? i : i - n;
    const std::vector<Text>& of = i < n || text.force.empty() ? text.coordinates : text.force;
    mode.equation.push_back(of[coordinate].place);
  }
  for (const Solution& one : at.solved) mode.field[one.state] = rate_along(graph, one.value, mode.field);
  for (const std::size_t c : at.constraints) {
    const Column &response = contacts[c].response, none(n, coordinates.zero());
    const auto along = [](Column first, const Column& second) {
      first.insert(first.end(), second.begin(), second.end());
      return first;
    };
    if (contacts[c].is_stop) mode.constraints.push_back({contacts[c].gap, along(response, none)});
    mode.constraints.push_back({contacts[c].rate, along(none, response)});
  }
  return mode;
}

}  // namespace graze::equations
