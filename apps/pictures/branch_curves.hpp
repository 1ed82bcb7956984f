// SPDX-License-Identifier: GPL-3.0-or-later
// Curves of the branches in graze.branch/1: which iterates a point has, in which stroke it is drawn, where a stroke ends.
#pragma once

#include <graze/apps/drawing/picture.hpp>
#include <graze/apps/text/json.hpp>

#include <string>
#include <vector>

namespace graze::apps {

/// gnuplot's point type for the type of a special point, told apart in black and white too.
int mark_of_type(const std::string& type);
int mark_of(const Json& special_point);

/// The end of a branch (EP) has a name and no mark.
bool is_marked(const Json& special_point);

/// x of a point at forcing phase 0: one, or where the result has them, one per period of the orbit.
std::vector<double> positions(const Json& point);

/// Whether points before it were left out.
bool follows_gap(const Json& point);

Stroke stroke_of(const Json& point);
const char* stroke_name(Stroke stroke);

/// A point of a branch as it is drawn; `border`: a special point, which ends one stroke and begins the next.
struct Drawn {
  const Json* point = nullptr;
  bool border = false;
};

/// Points of a branch with its special points put in where they lie, so that stability changes there and not a step beside it.
std::vector<Drawn> points_in_order(const Json& branch);

/// The k-th iterate of a branch, cut into curves of one stroke each.
std::vector<Curve> curves_of(const std::vector<Drawn>& points, std::size_t k);

/// Whether a result has a branch that can be drawn.
bool has_branches(const Json& result);

}  // namespace graze::apps
