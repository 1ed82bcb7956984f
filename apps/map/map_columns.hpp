// SPDX-License-Identifier: GPL-3.0-or-later
// The one list of the fields of a map's point. Its JSON and CSV, the bytes of a chunk and the datasets of HDF5 follow from it.
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

/// The member of a MapPoint that a field holds. Only periodic points have a period and a number of impacts. In JSON, numbers
/// that are not finite and unknown states are null; in CSV, NaN is an empty cell.
using MapMember = std::variant<MapType MapPoint::*, int MapPoint::*, double MapPoint::*, Vector MapPoint::*, Eigen::Index>;

struct MapField {
  MapMember member;         ///< an index: the position of a quantity among those of a point
  std::string dataset;      ///< name in HDF5
  Column<MapPoint> column;  ///< in JSON and CSV; in JSON, quantities are members of an object "y"
  bool of_quantity() const { return std::holds_alternative<Eigen::Index>(member); }
  bool of_states() const { return std::holds_alternative<Vector MapPoint::*>(member); }
  std::size_t bytes() const;                                                                    ///< of one number
  std::size_t bytes(std::size_t states) const { return bytes() * (of_states() ? states : 1); }  ///< of one point
};

/// The fields in the order of every format. Each quantity is a dataset in the group "y"; "/" in its name, which separates
/// groups, becomes "_over_" there.
std::vector<MapField> map_fields(const std::vector<Quantity>& quantities = {});

/// The columns of JSON without the quantities; "sticking" follows from the others.
const Columns<MapPoint>& map_columns();

/// The quantity of a point; NaN: unknown.
double quantity_of(const MapPoint& point, Eigen::Index place);

/// The numbers of a point in the machine's format: field.bytes(states) bytes.
void write_bytes(const MapField& field, const MapPoint& point, char* bytes);
void read_bytes(const MapField& field, const char* bytes, std::size_t states, MapPoint& point);

/// Whether the motion sticks to the barrier in every turn. Such a motion forgets its past at once: its first exponent is
/// -infinity. Its number of impacts is a matter of definition.
bool sticks(const MapPoint& point);

}  // namespace graze::apps
