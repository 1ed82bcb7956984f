// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/mechanics.hpp>

#include <graze/lib/equations/contact_events.hpp>
#include <graze/lib/equations/polynomial.hpp>

#include <fmt/format.h>

#include <cmath>

namespace graze::equations {

namespace {

/// Relative tolerance for the entries of a symmetric matrix.
constexpr double symmetry_tolerance = 1e-12;

Square read_matrix(const Coordinates& coordinates, const std::vector<std::vector<Text>>& rows, const char* kind) {
  const Names& names = coordinates.names;
  const std::size_t n = coordinates.n;
  const Place first = rows.empty() || rows[0].empty() ? coordinates.text.place : rows[0][0].place;
  const auto counted = [](std::size_t count, const char* one, const char* more) {
    return fmt::format("{} {}", count, count == 1 ? one : more);
  };
  const std::string wanted = n == 1 ? std::string("it needs 1 row of 1 entry, as there is 1 coordinate")
                                    : fmt::format("it needs {0} rows of {0} entries, as there are {0} coordinates", n);
  if (rows.size() != n)
    names.refuse(first, fmt::format("the {} matrix has {}; {}", kind, counted(rows.size(), "row", "rows"), wanted));
  Square out;
  for (std::size_t i = 0; i < n; ++i) {
    if (rows[i].size() != n)
      names.refuse(rows[i].empty() ? first : rows[i][0].place, fmt::format("row {} of the {} matrix has {}; {}", i + 1, kind,
                                                                           counted(rows[i].size(), "entry", "entries"), wanted));
    out.emplace_back();
    for (std::size_t j = 0; j < n; ++j)
      out.back().push_back(
          read_expression(coordinates, rows[i][j], fmt::format("in the {} matrix, row {}, column {}", kind, i + 1, j + 1)));
  }
  return out;
}

/// M^-1. M is checked.
Square read_inverse_mass(const Coordinates& coordinates) {
  Graph& graph = coordinates.graph;
  const Names& names = coordinates.names;
  const MechanicsText& text = coordinates.text;
  const std::size_t n = coordinates.n;
  const Square mass = read_matrix(coordinates, text.mass, "mass");
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      const Dependence on = dependence(graph, mass[i][j]);
      const Place& place = text.mass[i][j].place;
      if (coordinates.has_velocity(mass[i][j]))
        names.refuse(place, fmt::format("the mass matrix depends on the velocity {}", coordinates.velocity_in(mass[i][j])));
      if (on.time) names.refuse(place, "the mass matrix depends on the time");
      if (j < i && !is_zero(graph, graph.subtract(mass[i][j], mass[j][i]))) {
        const double a = coordinates.value(mass[i][j]), b = coordinates.value(mass[j][i]);
        if (!(std::abs(a - b) <= symmetry_tolerance * (std::abs(a) + std::abs(b))))
          names.refuse(place,
                       fmt::format("the mass matrix is not symmetric: row {}, column {} is {:.6g}, row {}, column {} is {:.6g}",
                                   i + 1, j + 1, a, j + 1, i + 1, b));
      }
    }
  }
  Square identity(n, Column(n, coordinates.zero()));
  for (std::size_t i = 0; i < n; ++i) identity[i][i] = graph.constant(1.0);
  std::size_t row = 0;
  const auto inverse = solve_linear(coordinates, mass, identity, &row);
  if (!inverse)
    names.refuse(text.mass[row][row].place, fmt::format("the mass matrix is singular or not positive definite {} (row {})",
                                                        names.start ? "at the start" : "at the default parameters", row + 1));
  return *inverse;
}

/// The force on each coordinate without contacts: force - C q' - K q.
Column read_force(const Coordinates& coordinates) {
  Graph& graph = coordinates.graph;
  const Names& names = coordinates.names;
  const MechanicsText& text = coordinates.text;
  const std::size_t n = coordinates.n;
  Column out;
  if (!text.force.empty() && text.force.size() != n)
    names.refuse(text.force[0].place,
                 fmt::format("the number of forces is {}, and that of coordinates {}; give one force for each coordinate",
                             text.force.size(), n));
  const Square damping = text.damping.empty() ? Square() : read_matrix(coordinates, text.damping, "damping");
  const Square stiffness = text.stiffness.empty() ? Square() : read_matrix(coordinates, text.stiffness, "stiffness");
  for (std::size_t i = 0; i < n; ++i) {
    Expression sum = text.force.empty() ? coordinates.zero()
                                        : read_expression(coordinates, text.force[i],
                                                          fmt::format("in the force on {}", text.coordinates[i].text));
    for (std::size_t j = 0; j < n && !damping.empty(); ++j)
      sum = graph.subtract(sum, graph.multiply(damping[i][j], coordinates.v(j)));
    for (std::size_t j = 0; j < n && !stiffness.empty(); ++j)
      sum = graph.subtract(sum, graph.multiply(stiffness[i][j], coordinates.q(j)));
    out.push_back(sum);
  }
  return out;
}

}  // namespace

Pieces make_mechanics(Names& names) {
  const Coordinates coordinates(names);
  const Square inverse_mass = read_inverse_mass(coordinates);
  const Column force = read_force(coordinates);
  const ContactModes modes = combine_contacts(coordinates, inverse_mass, force, read_contacts(coordinates, inverse_mass));
  Pieces out;
  for (const Combination& at : modes.combinations) out.modes.push_back(make_mode(coordinates, modes.contacts, at));
  for (const Combination& at : modes.combinations) {
    for (std::size_t c = 0; c < modes.contacts.size(); ++c) {
      add_contact_events(coordinates, modes, at, c, out.events);
      add_contact_surfaces(modes, at, c, out.surfaces);
    }
  }
  return out;
}

}  // namespace graze::equations
