// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/map/map_columns.hpp>

#include <cstring>
#include <limits>

namespace graze::apps {

namespace {

void set_quantity(MapPoint& point, Eigen::Index place, double value) {
  if (place >= point.quantities.size()) point.quantities.conservativeResize(place + 1);
  point.quantities[place] = value;
}

Column<MapPoint> column_of(const char* name, const char* meaning, MapType MapPoint::*member) {
  return Column<MapPoint>(name, meaning, member);
}

Column<MapPoint> column_of(const char* name, const char* meaning, int MapPoint::*member) {
  return Column<MapPoint>(
      name, meaning,
      [member](const MapPoint& point) { return point.type == MapType::periodic ? std::optional(point.*member) : std::nullopt; },
      [member](MapPoint& point, std::optional<int> value) { point.*member = value.value_or(0); });
}

Column<MapPoint> column_of(const char* name, const char* meaning, double MapPoint::*member) {
  return Column<MapPoint>(
      name, meaning, [member](const MapPoint& point) { return finite(point.*member); },
      [member](MapPoint& point, MaybeFinite number) {
        if (!std::isnan(number.value)) point.*member = number.value;  // if it is null, "sticking" may have set it
      });
}

Column<MapPoint> column_of(const char* name, const char* meaning, Vector MapPoint::*member) {
  return Column<MapPoint>(
      name, meaning,
      [member](const MapPoint& point) { return (point.*member).allFinite() ? std::optional(point.*member) : std::nullopt; },
      [member](MapPoint& point, const std::optional<Vector>& value) { point.*member = value.value_or(Vector()); });
}

Column<MapPoint> column_of(const char* name, const char* meaning, Eigen::Index place) {
  return Column<MapPoint>(
      name, meaning, [place](const MapPoint& point) { return finite(quantity_of(point, place)); },
      [place](MapPoint& point, MaybeFinite number) { set_quantity(point, place, number.value); });
}

MapField field(const char* name, const std::string& dataset, const char* meaning, auto member,
               const char* unit = "dimensionless") {
  MapField out{member, dataset, column_of(name, meaning, member)};
  out.column.unit = unit;
  return out;
}

std::string dataset_of(const Quantity& quantity) {
  std::string name = "y/";
  for (const char c : quantity.text) name += c == '/' ? std::string("_over_") : std::string(1, c);
  return name;
}

}  // namespace

double quantity_of(const MapPoint& point, Eigen::Index place) {
  return place < point.quantities.size() ? point.quantities[place] : std::nan("");
}

std::vector<MapField> map_fields(const std::vector<Quantity>& quantities) {
  std::vector<MapField> list = {
      field("type", "attractor", "type of attractor", &MapPoint::type),
      field("period", "period", "n of z = p/n, in forcing periods, or returns of an autonomous system; 0: not periodic",
            &MapPoint::period),
      field("impacts", "impacts", "p of z = p/n; 0 also where not periodic", &MapPoint::impacts),
      field("lambda_1", "lambda_1", "first Lyapunov exponent per unit of dimensionless time", &MapPoint::lambda_1),
      field("standard_error", "standard_error", "of lambda_1; 0: exact, from the multipliers", &MapPoint::standard_error),
      field("state", "state", "the states on the attractor at forcing phase 0", &MapPoint::state)};
  for (const Quantity& one : quantities)
    list.push_back(field(one.text.c_str(), dataset_of(one), one.text.c_str(), static_cast<Eigen::Index>(&one - quantities.data()),
                         one.unit.c_str()));
  return list;
}

const Columns<MapPoint>& map_columns() {
  static const Columns<MapPoint> list = [] {
    Columns<MapPoint> columns;
    for (const MapField& one : map_fields()) columns.push_back(one.column);
    const auto forgets = [](MapPoint& point, bool value) {
      if (value) point.lambda_1 = -std::numeric_limits<double>::infinity();
    };
    constexpr std::ptrdiff_t behind_impacts = 3;
    columns.insert(
        columns.begin() + behind_impacts,
        Column<MapPoint>("sticking", "the mass sticks in every turn: lambda_1 is -infinity", sticks, forgets).not_needed());
    return columns;
  }();
  return list;
}

std::size_t MapField::bytes() const {
  return std::holds_alternative<MapType MapPoint::*>(member) ? sizeof(MapType)
         : std::holds_alternative<int MapPoint::*>(member)   ? sizeof(int)
                                                             : sizeof(double);
}

void write_bytes(const MapField& field, const MapPoint& point, char* bytes) {
  std::visit(
      [&](const auto member) {
        if constexpr (std::is_same_v<decltype(member), const Eigen::Index>) {
          const double value = quantity_of(point, member);
          std::memcpy(bytes, &value, sizeof value);
        } else if constexpr (requires { (point.*member).data(); })
          std::memcpy(bytes, (point.*member).data(), static_cast<std::size_t>((point.*member).size()) * sizeof(double));
        else
          std::memcpy(bytes, &(point.*member), sizeof(point.*member));
      },
      field.member);
}

void read_bytes(const MapField& field, const char* bytes, std::size_t states, MapPoint& point) {
  std::visit(
      [&](const auto member) {
        if constexpr (std::is_same_v<decltype(member), const Eigen::Index>) {
          double value;
          std::memcpy(&value, bytes, sizeof value);
          set_quantity(point, member, value);
        } else if constexpr (requires { (point.*member).data(); }) {
          (point.*member).resize(static_cast<Eigen::Index>(states));
          std::memcpy((point.*member).data(), bytes, states * sizeof(double));
        } else {
          std::memcpy(&(point.*member), bytes, sizeof(point.*member));
        }
      },
      field.member);
}

bool sticks(const MapPoint& point) {
  return point.type == MapType::periodic && point.lambda_1 == -std::numeric_limits<double>::infinity();
}

}  // namespace graze::apps
