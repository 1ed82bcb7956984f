// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/text/json.hpp>
#include <graze/apps/text/json_layout.hpp>
#include <graze/apps/text/json_member.hpp>
#include <graze/apps/text/write_items.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <algorithm>
#include <stdexcept>

namespace graze::apps {

namespace {

std::string text_of(const LongList& list, std::size_t k) {
  constexpr std::size_t usual = 1024;
  std::string text;
  text.reserve(usual);
  list.item(k, text);
  return text;
}

}  // namespace

void reserve_members(Json& object, std::size_t count) { object.get_ref<Json::object_t&>().reserve(count); }

Json to_json(const Vector& vector) {
  Json out = Json::array();
  for (const double value : vector) out.push_back(value);
  return out;
}

Vector vector_from(const Json& json) {
  Vector out(static_cast<Eigen::Index>(json.size()));
  for (std::size_t i = 0; i < json.size(); ++i) out[static_cast<Eigen::Index>(i)] = json[i].get<double>();
  return out;
}

Json to_json(const std::vector<Vector>& vectors) {
  Json out = Json::array();
  for (const Vector& vector : vectors) out.push_back(to_json(vector));
  return out;
}

Json to_json(const std::vector<std::complex<double>>& values) {
  Json out = Json::array();
  for (const std::complex<double>& value : values) out.push_back({value.real(), value.imag()});
  return out;
}

std::string flat(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

bool is_utf8(const std::string& text) {
  try {
    Json(text).dump();
    return true;
  } catch (const Json::type_error&) {
    return false;
  }
}

std::string pretty(const Json& json) {
  std::string out;
  lay_out(flat(json), 0, out);
  out += "\n";
  return out;
}

void pretty(const Json& json, const LongList& list, int threads, const TextSink& sink) {
  // A list of at most this many empty objects might fit on one line; in a longer list each object has its own lines.
  constexpr std::size_t short_lists = json_line_width / 3;
  if (!list.name.empty() && list.size <= short_lists) return pretty(with_items(json, list, threads), {}, threads, sink);
  if (!json.is_object() || json.empty()) return sink(pretty(json));
  std::string out = "{";
  const char* separator = "\n  ";
  for (const auto& [name, value] : json.items()) {
    out += separator + flat(name) + ": ";
    separator = ",\n  ";
    const Json& here = value;
    const bool listed = name == list.name;
    const bool is_long = here.is_array() && here.size() > short_lists &&
                         std::all_of(here.begin(), here.end(), [](const Json& item) { return item.is_structured(); });
    if (!listed && !is_long) {
      lay_out(flat(here), 2, out);
      continue;
    }
    sink(out + "[");
    write_items(threads, listed ? list.size : here.size(), sink, [&](std::size_t k, std::string& text) {
      text += k == 0 ? "\n    " : ",\n    ";
      lay_out(listed ? text_of(list, k) : flat(here[k]), 4, text);
    });
    out = "\n  ]";
  }
  sink(out + "\n}\n");
}

Json with_items(const Json& json, const LongList& list, int threads) {
  Json out = json;
  if (list.name.empty()) return out;
  Json& items = out[list.name] = Json::array_t(list.size);
  in_parallel_on(threads, list.size, [&](std::size_t k) { items[k] = Json::parse(text_of(list, k)); });
  return out;
}

std::string plain(const Json::exception& error) {
  const std::string text = error.what();  // "[json.exception.out_of_range.403] key 'model' not found"
  const std::size_t end = text.starts_with("[json") ? text.find("] ") : std::string::npos;
  return end == std::string::npos ? text : text.substr(end + 2);
}

std::string schema_of(const Json& result) { return text_of(result, "schema"); }

}  // namespace graze::apps
