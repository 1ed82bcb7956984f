// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of a reproduction: diagrams with spectra, phase portraits and Poincaré sections, and the data behind the claims;
// and the page that shows them beside the comparison.
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
  std::function<Picture()> picture;  ///< computes the missing data: the motion itself
};

/// The figures in the order of the file. `published` and `reproduction` must outlive them.
std::vector<Figure> figures_of(const Published& published, const Reproduction& reproduction);

/// The page: comparison, claims, figures (as `name`.png beside it). Plain HTML without scripts.
std::string index_page(const Published& published, const Reproduction& reproduction, const std::vector<Figure>& figures);

}  // namespace graze::apps
