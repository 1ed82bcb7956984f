// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/models/physical_units.hpp>

#include <array>
#include <cmath>
#include <stdexcept>

namespace graze {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// What the three kinds have in common once mass m, alpha, length and stiffness are known.
Dimensionless scale(double m, double c, double omega, double rho, const ContactQuantities& contact, Dimensionless out) {
  out.b = c / (2.0 * std::sqrt(out.stiffness * m));
  out.eta = omega / out.alpha;
  out.r = rho / out.length;
  out.k_H = contact.k_h * std::sqrt(out.length) / out.stiffness;
  out.b_H = contact.b_h * out.length * out.alpha;
  out.k_S = contact.k_s / out.stiffness;
  return out;
}

ParameterInfo positive(std::string name, std::string unit, std::string meaning) {
  return {std::move(name), 0.0, 0.0, infinity, true, std::move(unit), std::move(meaning)};
}

ParameterInfo not_negative(std::string name, std::string unit, std::string meaning) {
  return {std::move(name), 0.0, 0.0, infinity, false, std::move(unit), std::move(meaning)};
}

ParameterInfo any(std::string name, std::string unit, std::string meaning) {
  return {std::move(name), 0.0, -infinity, infinity, false, std::move(unit), std::move(meaning)};
}

double get(const std::map<std::string, double>& values, const char* name) {
  const auto found = values.find(name);
  return found == values.end() ? 0.0 : found->second;
}

ContactQuantities contact_of(const std::map<std::string, double>& q) {
  return {.k_h = get(q, "k_h"), .b_h = get(q, "b_h"), .k_s = get(q, "k_s")};
}

Dimensionless convert_kinematic(const std::map<std::string, double>& q) {
  return to_dimensionless(KinematicExcitation{.m = get(q, "m"),
                                              .k = get(q, "k"),
                                              .k_e = get(q, "k_e"),
                                              .c = get(q, "c"),
                                              .a = get(q, "a"),
                                              .omega = get(q, "omega"),
                                              .rho = get(q, "rho"),
                                              .k_3 = get(q, "k_3")},
                          contact_of(q));
}

Dimensionless convert_force(const std::map<std::string, double>& q) {
  return to_dimensionless(ForceExcitation{.m = get(q, "m"),
                                          .k = get(q, "k"),
                                          .c = get(q, "c"),
                                          .F0 = get(q, "F0"),
                                          .omega = get(q, "omega"),
                                          .rho = get(q, "rho"),
                                          .k_3 = get(q, "k_3")},
                          contact_of(q));
}

Dimensionless convert_beam(const std::map<std::string, double>& q) {
  return to_dimensionless(BeamExcitation{.M = get(q, "M"),
                                         .L = get(q, "L"),
                                         .EI = get(q, "EI"),
                                         .c = get(q, "c"),
                                         .F0 = get(q, "F0"),
                                         .omega = get(q, "omega"),
                                         .rho = get(q, "rho")},
                          contact_of(q));
}

}  // namespace

Dimensionless to_dimensionless(const KinematicExcitation& s, const ContactQuantities& contact) {
  Dimensionless out;
  out.stiffness = s.k + s.k_e;
  out.alpha = std::sqrt(out.stiffness / s.m);
  out.length = s.a;
  out.xi = s.k_e / out.stiffness;
  out.beta = s.k_3 * s.a * s.a / out.stiffness;
  return scale(s.m, s.c, s.omega, s.rho, contact, out);
}

Dimensionless to_dimensionless(const ForceExcitation& s, const ContactQuantities& contact) {
  Dimensionless out;
  out.stiffness = s.k;
  out.alpha = std::sqrt(s.k / s.m);
  out.length = s.F0 / s.k;
  out.xi = 1.0;
  out.beta = s.k_3 * out.length * out.length / s.k;
  return scale(s.m, s.c, s.omega, s.rho, contact, out);
}

Dimensionless to_dimensionless(const BeamExcitation& s, const ContactQuantities& contact) {
  Dimensionless out;
  out.stiffness = 12.0 * s.EI / (s.L * s.L * s.L);
  out.alpha = std::sqrt(out.stiffness / s.M);
  out.length = s.L;
  out.xi = s.F0 / (out.alpha * out.alpha * s.M * s.L);
  out.beta = 36.0 / 35.0;
  return scale(s.M, s.c, s.omega, s.rho, contact, out);
}

const std::vector<ExcitationKind>& excitation_kinds() {
  static const std::vector<ExcitationKind> list = [] {
    const ParameterInfo mass = positive("m", "kg", "mass"), c = not_negative("c", "N s/m", "damping"),
                        omega = positive("omega", "rad/s", "frequency of excitation"),
                        rho = any("rho", "m", "clearance: the barrier is at X = rho"),
                        F0 = positive("F0", "N", "amplitude of the force"),
                        k_3 = any("k_3", "N/m^3", "cubic stiffness (cantilever only)");
    return std::vector<ExcitationKind>{
        {"kinematic",
         "m X'' + c X' + (k + k_e) X + k_3 X^3 = k_e a cos(omega t)",
         {mass, not_negative("k", "N/m", "stiffness of the spring to the ground"),
          positive("k_e", "N/m", "stiffness of the spring to the moving base"), c, positive("a", "m", "amplitude of the base"),
          omega, rho, k_3},
         convert_kinematic},
        {"force",
         "m X'' + c X' + k X + k_3 X^3 = F0 cos(omega t)",
         {mass, positive("k", "N/m", "stiffness of the spring"), c, F0, omega, rho, k_3},
         convert_force},
        {"beam",
         "mass M on two leaf springs, k_1 = 12 EI/L^3, force F0 cos(omega t)",
         {positive("M", "kg", "mass"), positive("L", "m", "length of the leaf springs"),
          positive("EI", "N m^2", "bending stiffness"), c, F0, omega, rho},
         convert_beam},
    };
  }();
  return list;
}

const ExcitationKind& excitation_kind(std::string_view name) {
  std::vector<std::string> names;
  for (const ExcitationKind& kind : excitation_kinds()) {
    if (kind.name == name) return kind;
    names.push_back(kind.name);
  }
  throw std::invalid_argument(unknown_name("excitation", name, names));
}

const std::vector<ContactQuantity>& contact_quantities() {
  static const std::vector<ContactQuantity> list = {
      {positive("k_h", "N/m^(3/2)", "stiffness of the Hertz contact"), "k_H"},
      {not_negative("b_h", "s/m", "damping of the Hertz contact"), "b_H"},
      {positive("k_s", "N/m", "stiffness of the linear stop"), "k_S"},
  };
  return list;
}

const double* find_value(const Dimensionless& values, std::string_view name) {
  const std::array<std::pair<std::string_view, const double*>, 8> list = {{{"b", &values.b},
                                                                           {"beta", &values.beta},
                                                                           {"xi", &values.xi},
                                                                           {"eta", &values.eta},
                                                                           {"r", &values.r},
                                                                           {"k_H", &values.k_H},
                                                                           {"b_H", &values.b_H},
                                                                           {"k_S", &values.k_S}}};
  for (const auto& [key, value] : list)
    if (key == name) return value;
  return nullptr;
}

}  // namespace graze
