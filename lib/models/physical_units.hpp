// SPDX-License-Identifier: GPL-3.0-or-later
// Physical units: conversion of masses, springs and metres to the dimensionless oscillator (oscillator.hpp). Any coherent set
// of units is valid; `unit` names SI. There are three kinds of excitation, each with a natural frequency alpha, a length ell
// and a stiffness K; dimensionless time is tau = alpha t, displacement x = X / ell, frequency eta = omega / alpha:
//
//   kinematic  m X'' + c X' + (k + k_e) X [+ k_3 X^3] = k_e a cos(omega t)     K = k + k_e   alpha = sqrt(K/m)   ell = a
//   force      m X'' + c X' + k X [+ k_3 X^3] = F0 cos(omega t)                K = k         alpha = sqrt(K/m)   ell = F0/k
//   beam       mass M on two leaf springs of length L, stiffness EI            K = 12 EI/L^3 alpha = sqrt(K/M)   ell = L
//
// Damping, barrier (at X = rho) and contacts follow one rule: b = c / (2 sqrt(K m)), r = rho / ell, and
//   F = k_h (X - rho)^(3/2) (1 + b_h X')  or  k_s (X - rho):   k_H = k_h sqrt(ell)/K,  b_H = b_h ell alpha,  k_S = k_s/K.
// The cubic term is beta = k_3 ell^2 / K; for the cantilever, with x = X/L, beta = 36/35. Source: Serweta et al. (2014).
//
// The formulas are text (equations/parse.hpp): evaluated for a conversion, and read into the system if a motion is followed in
// a physical quantity.
#pragma once

#include <graze/lib/equations/parse.hpp>
#include <graze/lib/models/oscillator.hpp>

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace graze {

/// Values by name.
using Values = std::map<std::string, double, std::less<>>;

/// One kind of excitation: the quantities that a problem file may give, and their conversion.
struct ExcitationKind {
  std::string name;
  std::string formula;
  std::vector<ParameterInfo> quantities;  ///< with units and ranges, in order; none has a default
  /// stiffness (N/m), alpha (rad/s: tau = alpha t), length (m: x = X / length) and the dimensionless parameters b, beta, xi,
  /// eta, r, k_H, b_H, k_S. Each is an expression of quantities, contact_quantities() and the definitions before it.
  std::vector<equations::Definition> conversion;
  /// The inverse: the quantities, and contact_quantities(), as expressions of stiffness, alpha, length and the dimensionless
  /// parameters; also "energy" (J), the unit of energies per dimensionless mass: m (alpha length)^2 = stiffness length^2.
  std::vector<equations::Definition> inverse;
};

/// "kinematic", "force", "beam".
const std::vector<ExcitationKind>& excitation_kinds();
/// @throws std::invalid_argument with the nearest valid name.
const ExcitationKind& excitation_kind(std::string_view name);

/// A dimensionless parameter of a model, and the physical quantity of the contact from which it is computed.
struct ContactQuantity {
  ParameterInfo info;     ///< of the physical quantity
  std::string parameter;  ///< dimensionless: k_H, b_H, k_S
};
const std::vector<ContactQuantity>& contact_quantities();

/// Information on a quantity of that excitation or of a contact. @throws std::invalid_argument with the nearest valid name.
const ParameterInfo& quantity_info(const ExcitationKind& kind, std::string_view name);

/// The values of `conversion`, by name; missing quantities count as 0.
Values to_dimensionless(const ExcitationKind& kind, const Values& quantities);

/// The values of `inverse`, by name; missing values count as 0.
Values from_dimensionless(const ExcitationKind& kind, const Values& dimensionless);

/// The oscillator with the physical quantities `chosen` as parameters. The dimensionless parameters that depend on them are
/// tied to them, as are "stiffness", "alpha" and "length"; the others stay parameters. All other quantities keep their values.
/// `chosen` are names in `quantities`.
equations::TextSystem read_oscillator(const OscillatorKind& oscillator, const ContactLaw& law, const ExcitationKind& kind,
                                      const Values& quantities, const std::vector<std::string>& chosen);

}  // namespace graze
