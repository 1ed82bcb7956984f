// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/models/contact_law.hpp>

#include <limits>
#include <stdexcept>

namespace graze {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// F = k_H (x - r)^(3/2) (1 + b_H x') for x >= r (Serweta et al. 2014). State and field are continuous at x = r.
ContactLaw hertz_law() {
  return {.name = "hertz",
          .formula = "F = k_H (x - r)^(3/2) (1 + b_H x') for x >= r",
          .parameters = {{"k_H", 100.0, 0.0, infinity, true, "dimensionless", "contact stiffness"},
                         {"b_H", 0.0, 0.0, infinity, false, "dimensionless", "contact damping (0: undamped Hertz)"}},
          .stop = "hertz",
          .values = {"k_H", "b_H"}};
}

/// A linear elastic stop. State and field are continuous at x = r.
ContactLaw linear_elastic_law() {
  return {.name = "linear",
          .formula = "F = k_S (x - r) for x >= r",
          .parameters = {{"k_S", 25.0, 0.0, infinity, true, "dimensionless", "stiffness of the elastic stop"}},
          .stop = "linear",
          .values = {"k_S"}};
}

/// Newton's law of restitution at a rigid stop. With k_r < 1 impacts may accumulate; the mass then sticks at (r, 0) while xi
/// cos(eta tau) - r - beta r^3 > 0 presses it there, and is released when that changes sign. |det S| = k_r^2 at an impact.
ContactLaw newton_law() {
  return {.name = "newton",
          .formula = "x'+ = -k_r x'- at x = r; x <= r always",
          .hard = true,
          .parameters = {{"k_r", 1.0, 0.0, 1.0, false, "dimensionless", "coefficient of restitution"}},
          .stop = "newton",
          .values = {"k_r"}};
}

}  // namespace

const std::vector<ContactLaw>& contact_laws() {
  static const std::vector<ContactLaw> list = {hertz_law(), linear_elastic_law(), newton_law()};
  return list;
}

const ContactLaw& contact_law(std::string_view name) {
  std::vector<std::string> names;
  for (const ContactLaw& law : contact_laws()) {
    if (law.name == name) return law;
    names.push_back(law.name);
  }
  throw std::invalid_argument(unknown_name("contact law", name, names));
}

}  // namespace graze
