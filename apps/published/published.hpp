// SPDX-License-Identifier: GPL-3.0-or-later
// Published: figures printed in a study, as data for comparison (data/published.toml is an example of such a file).
//
//   [[system]]         id, contact, parameters = { b = 0.05, ... }      the common parameters of all its figures
//   [[special_point]]  system, type = "PD", eta, digits                 and printed_multipliers_at, printed_multipliers
//   [[exponents]]      system, eta, attractor, lambda, digits, figure   and beta, z = [p, n], periods, initial = [x, v]
//   [[diagram]]        system, figure, eta = [from, to], step, windows  the windows that a sweep passes through
//
// `attractor` is "impactless", "periodic" or "chaotic"; `digits` is the number of printed decimals. A printed value is a claim.
#pragma once

#include <graze/apps/problem/problem.hpp>

#include <array>
#include <complex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace graze::apps {

/// The source's description of a motion. z = [p, n] or the number of periods may be missing.
struct PublishedAttractor {
  std::string type;  ///< "impactless", "periodic", "chaotic"
  std::optional<std::array<int, 2>> z;
  int periods = 0;  ///< 0: not stated
};

/// "impactless", "chaotic", "z = 7/8", "period 2", "periodic".
std::string label(const PublishedAttractor& attractor);

struct PublishedSystem {
  std::string id, contact;
  std::vector<std::pair<std::string, double>> parameters;
};

struct PublishedPoint {
  std::string system, type;
  double eta = 0.0;
  int digits = 0;
  std::optional<double> multipliers_at;
  std::vector<std::complex<double>> multipliers;
};

struct PublishedExponents {
  std::string system, figure;
  PublishedAttractor attractor;
  std::optional<double> eta, beta;  ///< empty: those of the system
  std::optional<Vector> initial;
  std::vector<double> lambda;
  int digits = 0;
};

struct PublishedWindow {
  double from = 0.0, to = 0.0;
  std::string direction;  ///< "up", "down", "both"
  PublishedAttractor attractor;
  std::string note;
};

struct PublishedDiagram {
  std::string system, figure;
  double from = 0.0, to = 0.0, step = 0.0;
  std::vector<PublishedWindow> windows;
};

struct Published {
  std::string file;
  std::vector<PublishedSystem> systems;
  std::vector<PublishedPoint> points;
  std::vector<PublishedExponents> exponents;
  std::vector<PublishedDiagram> diagrams;

  /// Number of rows of the comparison: points, their multipliers, exponents, windows.
  std::size_t items() const;
};

/// @throws std::invalid_argument with one sentence: file, line, given value, allowed values.
Published load_published(const std::string& file);
Published parse_published(std::string_view text, const std::string& file);

/// The model of a system at its parameters, with eta and beta as given. beta is 0 unless it is given.
Problem problem_of(const Published& published, const std::string& system, std::optional<double> eta = {},
                   std::optional<double> beta = {});

}  // namespace graze::apps
