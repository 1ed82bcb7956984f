// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of a reproduction: diagrams over spectra, phase portraits and Poincaré sections, and what the claims rest on; and
// the page that shows them beside the comparison.
#pragma once

#include <graze/apps/drawing/picture.hpp>
#include <graze/apps/published/reproduction.hpp>

#include <functional>
#include <string>
#include <vector>

namespace graze::apps {

struct Figure {
  std::string name;  ///< of its file: "figure-4b"
  std::string caption;
  std::function<Picture()> picture;  ///< computes what is still needed for it: the motion itself
};

/// In the order of the file. `published` and `reproduction` must outlive them.
std::vector<Figure> figures_of(const Published& published, const Reproduction& reproduction);

/// The page: comparison, claims, figures (as `name`.png beside it). Plain HTML without scripts.
std::string index_page(const Published& published, const Reproduction& reproduction, const std::vector<Figure>& figures);

}  // namespace graze::apps
