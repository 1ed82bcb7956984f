// SPDX-License-Identifier: GPL-3.0-or-later
// Physical units: from masses, springs and metres to the dimensionless oscillator (oscillator.hpp). Any coherent set of
// units will do; SI is what `unit` names. Three kinds of excitation, each with a natural frequency alpha, a length ell and a
// stiffness K; dimensionless time is tau = alpha t, displacement x = X / ell, frequency eta = omega / alpha:
//
//   kinematic  m X'' + c X' + (k + k_e) X [+ k_3 X^3] = k_e a cos(omega t)     K = k + k_e   alpha = sqrt(K/m)   ell = a
//   force      m X'' + c X' + k X [+ k_3 X^3] = F0 cos(omega t)                K = k         alpha = sqrt(K/m)   ell = F0/k
//   beam       mass M on two leaf springs of length L, stiffness EI            K = 12 EI/L^3 alpha = sqrt(K/M)   ell = L
//
// Damping and barrier (at X = rho) then follow one rule: b = c / (2 sqrt(K m)), r = rho / ell, and so do the contacts,
//   F = k_h (X - rho)^(3/2) (1 + b_h X')  or  k_s (X - rho):   k_H = k_h sqrt(ell)/K,  b_H = b_h ell alpha,  k_S = k_s/K.
// The cubic term is beta = k_3 ell^2 / K; the cantilever's own, with x = X/L, is beta = 36/35. Source: Serweta et al. (2014).
#pragma once

#include <graze/lib/system/parameters.hpp>

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace graze {

/// Of the contact; quantities of another law than the one in use stay 0.
struct ContactQuantities {
  double k_h = 0.0;  ///< Hertz stiffness, N/m^(3/2)
  double b_h = 0.0;  ///< Hertz damping, s/m
  double k_s = 0.0;  ///< linear stiffness, N/m
};

/// A base moving as a cos(omega t) at the far end of the spring k_e.
struct KinematicExcitation {
  double m = 0.0, k = 0.0, k_e = 0.0, c = 0.0;  ///< kg, N/m, N/m, N s/m
  double a = 0.0, omega = 0.0;                  ///< m, rad/s
  double rho = 0.0;                             ///< clearance, m
  double k_3 = 0.0;                             ///< cubic stiffness, N/m^3
};

/// A force F0 cos(omega t) on the mass.
struct ForceExcitation {
  double m = 0.0, k = 0.0, c = 0.0;  ///< kg, N/m, N s/m
  double F0 = 0.0, omega = 0.0;      ///< N, rad/s
  double rho = 0.0;                  ///< clearance, m
  double k_3 = 0.0;                  ///< cubic stiffness, N/m^3
};

/// A force F0 cos(omega t) on the mass M between two leaf springs.
struct BeamExcitation {
  double M = 0.0, L = 0.0, EI = 0.0, c = 0.0;  ///< kg, m, N m^2, N s/m
  double F0 = 0.0, omega = 0.0;                ///< N, rad/s
  double rho = 0.0;                            ///< clearance, m
};

/// The dimensionless values, and the scales by which they came about.
struct Dimensionless {
  double alpha = 0.0;      ///< rad/s: tau = alpha t
  double length = 0.0;     ///< m: x = X / length
  double stiffness = 0.0;  ///< N/m
  double b = 0.0, beta = 0.0, xi = 0.0, eta = 0.0, r = 0.0;
  double k_H = 0.0, b_H = 0.0, k_S = 0.0;
};

/// xi = k_e/(k + k_e).
Dimensionless to_dimensionless(const KinematicExcitation& system, const ContactQuantities& contact = {});
/// xi = 1.
Dimensionless to_dimensionless(const ForceExcitation& system, const ContactQuantities& contact = {});
/// xi = F0/(alpha^2 M L), beta = 36/35 (the linear theory of the beam has beta = 0: set it so).
Dimensionless to_dimensionless(const BeamExcitation& system, const ContactQuantities& contact = {});

/// What a problem file may say of one kind of excitation.
struct ExcitationKind {
  std::string name;
  std::string formula;
  std::vector<ParameterInfo> quantities;  ///< with units and ranges, in order; none has a default
  /// The conversion from named quantities; those that are missing count as 0.
  Dimensionless (*convert)(const std::map<std::string, double>& quantities) = nullptr;
};

/// "kinematic", "force", "beam".
const std::vector<ExcitationKind>& excitation_kinds();
/// @throws std::invalid_argument with the nearest valid name.
const ExcitationKind& excitation_kind(std::string_view name);

/// A dimensionless parameter of a model and the physical quantity of the contact that it comes from.
struct ContactQuantity {
  ParameterInfo info;     ///< of the physical quantity
  std::string parameter;  ///< dimensionless: k_H, b_H, k_S
};
const std::vector<ContactQuantity>& contact_quantities();

/// The value that parameter `name` of a model takes; nullptr where the conversion does not give it (k_r stays as it is).
const double* find_value(const Dimensionless& values, std::string_view name);

}  // namespace graze
