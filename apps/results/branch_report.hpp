// SPDX-License-Identifier: GPL-3.0-or-later
// Report of branches and special points: as JSON (graze.branch/1, graze.point/1), as text, as table rows.
#pragma once

#include <graze/apps/problem/problem.hpp>
#include <graze/apps/quantities/quantities.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/results/same_points.hpp>
#include <graze/apps/text/json.hpp>
#include <graze/apps/text/table.hpp>

#include <graze/continuation/problems/branch.hpp>

#include <optional>
#include <string>
#include <vector>

namespace graze::apps {

/// Quantities at the points of a branch, in the order of the points; empty: none.
struct BranchQuantities {
  std::vector<QuantityValues> points, special_points;
};

/// Measures the quantities at all points of these branches, on `threads` threads. Empty if there are no quantities.
std::vector<BranchQuantities> measure(const Quantities& quantities, const HybridSystem& system,
                                      const std::vector<Branch>& branches, int threads);

/// Adds the quantities to the points of branches in the JSON of json_of(). An empty list removes them.
void put_quantities(Json& list, const std::vector<BranchQuantities>& measured);

/// The columns in graze.branch/1.
const Columns<BranchParent>& parent_columns();
const Columns<Symmetry>& symmetry_columns();
const Columns<BranchPoint>& point_columns();
const Columns<SpecialPoint>& special_point_columns();
const Columns<Branch>& branch_columns();

const char* point_status_name(PointStatus status);

template <>
struct JsonForm<PointType> : ChoiceForm<PointType, point_type_name, PointType::EP, PointType::LP, PointType::PD, PointType::BP,
                                        PointType::NS, PointType::GR, PointType::UZ, PointType::MX> {};
template <>
struct JsonForm<PointStatus> : ChoiceForm<PointStatus, point_status_name, PointStatus::bracketed, PointStatus::converged> {};
template <>
struct JsonForm<BranchStop>
    : ChoiceForm<BranchStop, branch_stop_name, BranchStop::reached_bound, BranchStop::parameter_range, BranchStop::point_limit,
                 BranchStop::grazing, BranchStop::step_too_small, BranchStop::chatter, BranchStop::returned,
                 BranchStop::equilibrium, BranchStop::start_failed, BranchStop::interrupted> {};
template <> struct JsonForm<Detail> {
  static Json json(const Detail& detail) {
    return std::visit([](const auto& value) { return Json(value); }, detail);
  }
  static Detail value(const Json& json) {
    if (json.is_array()) return json.get<std::vector<double>>();
    return json.is_string() ? Detail(json.get<std::string>()) : Detail(json.get<double>());
  }
  static void write(const Detail& detail, JsonText& text) {
    std::visit([&](const auto& value) { text.value(value); }, detail);
  }
  static Json schema() { return {{"type", {"string", "number", "array"}}, {"items", {{"type", "number"}}}}; }
};
template <> struct JsonForm<BranchParent> : RecordForm<BranchParent, parent_columns> {};
template <> struct JsonForm<Symmetry> : RecordForm<Symmetry, symmetry_columns> {};
template <> struct JsonForm<BranchPoint> : RecordForm<BranchPoint, point_columns> {};
template <> struct JsonForm<SpecialPoint> : RecordForm<SpecialPoint, special_point_columns> {};
template <> struct JsonForm<Branch> : RecordForm<Branch, branch_columns> {};

/// The schemas of a special point and of a list of branches, with the members added to them.
Json special_point_schema();
Json branches_schema();

/// A special point with twelve digits: its place and precision, its orbit and its details.
std::string special_point_text(const SpecialPoint& point, const std::string& parameter);

/// The stability of the orbit at the point; the multipliers alone do not always determine it.
std::string stability_text(const SpecialPoint& point);

/// A table cell: "yes", "no", or empty if the stability is unknown.
std::string stable_cell(std::optional<bool> stable);

/// A branch: a table of its points (thinned to `most` rows), its special points, and why it stopped. A special point that an
/// earlier branch also has is marked with the name it has there.
std::string branch_text(const Problem& problem, const Branch& branch, std::size_t most, const SamePoints& same,
                        const BranchQuantities& measured = {});

/// One row per point of each branch, special points in their places with their labels.
Table branches_table(const Problem& problem, const std::vector<Branch>& branches,
                     const std::vector<BranchQuantities>& measured = {});

/// The branches of a result (graze.branch/1), from which a run can continue: values, states, stability and special points, but
/// no events, no monodromy matrices, and no report of Newton's method on the orbit of a special point (PeriodicOrbit::newton is
/// not_run; SpecialPoint::newton tells how the point was located). @throws std::invalid_argument in one sentence if something is
/// missing or damaged.
std::vector<Branch> branches_from_json(const Json& result);

}  // namespace graze::apps
