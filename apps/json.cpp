// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/json.hpp>
#include <graze/apps/version.hpp>

#include <algorithm>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr std::size_t line_width = 110;

void write(const Json& json, std::size_t indent, std::string& out) {
  const std::string flat = json.dump();
  // Arrays of numbers stay on one line however long: a list of 5 multipliers is one thing to the eye.
  const bool scalars = json.is_array() && std::none_of(json.begin(), json.end(), [](const Json& e) { return e.is_structured(); });
  if (!json.is_structured() || json.empty() || scalars || (indent + flat.size() <= line_width && indent > 0)) {
    out += flat;
    return;
  }
  const std::string padding(indent + 2, ' ');
  out += json.is_array() ? "[" : "{";
  const char* separator = "\n";
  for (auto it = json.begin(); it != json.end(); ++it) {
    out += separator + padding;
    if (json.is_object()) out += Json(it.key()).dump() + ": ";
    write(*it, indent + 2, out);
    separator = ",\n";
  }
  out.append(1, '\n').append(indent, ' ').append(json.is_array() ? "]" : "}");
}

}  // namespace

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

Json to_json(const std::vector<std::complex<double>>& values) {
  Json out = Json::array();
  for (const std::complex<double>& value : values) out.push_back({value.real(), value.imag()});
  return out;
}

std::string pretty(const Json& json) {
  std::string out;
  write(json, 0, out);
  return out + "\n";
}

Json result_head(const std::string& schema, const std::string& command, const Problem& problem, Json options) {
  Json head;
  head["schema"] = "graze." + schema;
  head["graze"] = program_version;
  head["command"] = command;
  head["model"] = {{"oscillator", problem.oscillator}, {"contact", problem.contact}};
  for (std::size_t i = 0; i < problem.system.parameters.size(); ++i)
    head["parameters"][problem.system.parameters[i].name] = problem.parameters[static_cast<Eigen::Index>(i)];
  if (problem.converted_from) {
    const ConvertedFrom& from = *problem.converted_from;
    Json& quantities = head["converted_from"] = {{"excitation", from.excitation}};
    for (const auto& [name, value] : from.quantities) quantities[name] = value;
    head["converted_from"]["alpha"] = from.alpha;
    head["converted_from"]["length"] = from.length;
  }
  head["options"] = std::move(options);
  return head;
}

std::string plain(const Json::exception& error) {
  const std::string text = error.what();  // "[json.exception.out_of_range.403] key 'model' not found"
  const std::size_t end = text.starts_with("[json") ? text.find("] ") : std::string::npos;
  return end == std::string::npos ? text : text.substr(end + 2);
}

const char* status_name(Status status) {
  return status == Status::done ? "done" : status == Status::failed ? "failed" : "interrupted";
}

void set_status(Json& result, Status status, const std::string& message) {
  result["status"] = status_name(status);
  if (!message.empty()) result["message"] = message;
}

int exit_code(Status status) { return status == Status::done ? 0 : status == Status::failed ? 1 : 130; }

Problem problem_of(const Json& result) {
  try {
    const Json& model = result.at("model");
    Problem problem = make_problem(model.at("oscillator").get<std::string>(), model.at("contact").get<std::string>());
    for (const auto& [name, value] : result.at("parameters").items()) set_parameter(problem, name, value.get<double>());
    return problem;
  } catch (const Json::exception& error) {
    throw std::invalid_argument(std::string("the result does not say which model it is of: ") + plain(error));
  }
}

}  // namespace graze::apps
