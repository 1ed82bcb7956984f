// SPDX-License-Identifier: GPL-3.0-or-later
// Curves of the branches in graze.branch/1: the iterates of a point, its stroke, and where a stroke ends.
#pragma once

#include <graze/apps/drawing/picture.hpp>
#include <graze/apps/text/json.hpp>

#include <string>
#include <vector>

namespace graze::apps {

/// gnuplot's point type for the type of a special point; the types differ in black and white as well.
int mark_of_type(const std::string& type);
int mark_of(const Json& special_point);

/// Whether a special point has a mark: the end of a branch (EP) has a name only.
bool is_marked(const Json& special_point);

/// x of a point at forcing phase 0: one value, or one per period of the orbit if the result has them.
std::vector<double> positions(const Json& point);

/// Whether points before this one were left out.
bool follows_gap(const Json& point);

Stroke stroke_of(const Json& point);
const char* stroke_name(Stroke stroke);

/// A point of a branch to draw; `border`: a special point, which ends one stroke and begins the next.
struct Drawn {
  const Json* point = nullptr;
  bool border = false;
};

/// The points of a branch with its special points inserted, so that stability changes exactly there and not one step beside.
std::vector<Drawn> points_in_order(const Json& branch);

/// The k-th iterate of a branch, cut into curves of one stroke each.
std::vector<Curve> curves_of(const std::vector<Drawn>& points, std::size_t k);

/// Whether a result has a branch that can be drawn.
bool has_branches(const Json& result);

}  // namespace graze::apps
