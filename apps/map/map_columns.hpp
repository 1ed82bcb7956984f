// SPDX-License-Identifier: GPL-3.0-or-later
// The one list of what a map has of a point: its JSON and CSV, the bytes of a chunk and the datasets of HDF5 follow from it.
#pragma once

#include <graze/apps/quantities/quantities.hpp>
#include <graze/apps/text/column.hpp>

#include <graze/floquet/follow/parameter_map.hpp>

#include <cstddef>
#include <string>
#include <variant>
#include <vector>

namespace graze::apps {

template <>
struct JsonForm<MapType> : ChoiceForm<MapType, map_type_name, MapType::undecided, MapType::periodic, MapType::chaotic,
                                      MapType::inadmissible, MapType::lost, MapType::not_run> {};

/// Periods and numbers of impacts are told of periodic points alone; numbers that are not finite and states that are not known
/// are null in JSON, and those that are no number are empty in CSV.
using MapMember = std::variant<MapType MapPoint::*, int MapPoint::*, double MapPoint::*, Vector MapPoint::*, Eigen::Index>;

struct MapField {
  MapMember member;         ///< a number: the place of a quantity among those of a point
  std::string dataset;      ///< its name in HDF5
  Column<MapPoint> column;  ///< in JSON and CSV; JSON has those of quantities in an object "y"
  bool of_quantity() const { return std::holds_alternative<Eigen::Index>(member); }
  bool of_states() const { return std::holds_alternative<Vector MapPoint::*>(member); }
  std::size_t bytes() const;                                                                    ///< of a number
  std::size_t bytes(std::size_t states) const { return bytes() * (of_states() ? states : 1); }  ///< of a point
};

/// In the order in which they stand in every format. Each quantity is a dataset in the group "y"; "/" in its name, which
/// separates groups, is "_over_" there.
std::vector<MapField> map_fields(const std::vector<Quantity>& quantities = {});

/// Those of JSON but for quantities: "sticking" follows from the others.
const Columns<MapPoint>& map_columns();

/// NaN: not known.
double quantity_of(const MapPoint& point, Eigen::Index place);

/// The numbers of a point as the machine has them, as many bytes as field.bytes(states).
void put_bytes(const MapField& field, const MapPoint& point, char* bytes);
void take_bytes(const MapField& field, const char* bytes, std::size_t states, MapPoint& point);

/// Whether the motion sticks to the barrier in every turn: it then forgets all at once, and its first exponent is -infinity. Its
/// number of impacts is a matter of definition.
bool sticks(const MapPoint& point);

}  // namespace graze::apps
