// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/problem/head.hpp>
#include <graze/apps/text/column.hpp>
#include <graze/apps/text/version.hpp>

#include <stdexcept>

namespace graze::apps {

Json result_head(const std::string& schema, const std::string& command, const Problem& problem, Json options) {
  Json head = Json::object();
  reserve_members(head, 24);
  head["schema"] = "graze." + schema;
  head["graze"] = program_version;
  head["command"] = command;
  if (is_built_in(problem)) {
    head["model"] = {{"oscillator", problem.oscillator}, {"contact", problem.contact}};
  } else {
    head["model"] = {{"system", problem.system.name}, {"file", problem.file}, {"text", problem.text}};
    head["states"] = state_columns(problem);
  }
  for (std::size_t i = 0; i < problem.system.parameters.size(); ++i)
    head["parameters"][problem.system.parameters[i].name] = problem.parameters[static_cast<Eigen::Index>(i)];
  for (const equations::TiedParameter& tied : problem.written->tied)
    head["tied"][tied.info.name] = tied.value(problem.parameters);
  if (problem.converted_from) {
    const ConvertedFrom& from = *problem.converted_from;
    Json& quantities = head["converted_from"] = {{"excitation", from.excitation}};
    for (const auto& [name, value] : from.quantities) quantities[name] = value;
    head["converted_from"]["alpha"] = from.alpha;
    head["converted_from"]["length"] = from.length;
    if (!from.chosen.empty()) head["converted_from"]["varied"] = from.chosen;
  }
  head["options"] = std::move(options);
  return head;
}

Json plain_result_schema(const std::string& schema, const std::string& meaning, const std::vector<Json>& members) {
  const Json text = JsonForm<std::string>::schema();
  const Json head = object_schema({{"schema", "name and version of the format", {{"const", "graze." + schema}}},
                                   {"graze", "version of the program", text},
                                   {"command", "command that made it", text},
                                   {"status", "how the command ended", {{"enum", {"done", "failed", "interrupted"}}}},
                                   {"message", "remark on the result, such as the reason of a failure", text, false}});
  std::vector<Json> all = {head};
  all.insert(all.end(), members.begin(), members.end());
  Json out = {
      {"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "graze." + schema}, {"description", meaning}};
  out.update(merged_schemas(all));
  return out;
}

Json result_schema(const std::string& schema, const std::string& meaning, const std::vector<Json>& members) {
  const Json text = JsonForm<std::string>::schema(), number = JsonForm<double>::schema();
  const Json numbers = JsonForm<std::map<std::string, double>>::schema(), any = {{"type", "object"}};
  const Json built_in = object_schema({{"oscillator", "its name", text}, {"contact", "its law", text}});
  const Json written =
      object_schema({{"system", "its name", text}, {"file", "it was read from", text}, {"text", "of the file", text}});
  const Json from = {{"type", "object"}, {"additionalProperties", {{"type", {"string", "number", "array"}}}}};
  std::vector<Json> all = {object_schema(
      {{"model", "the model", {{"anyOf", {built_in, written}}}},
       {"states", "their names, in the order of every state below; x, v where it is missing", list_schema(text), false},
       {"parameters", "all of them", numbers, false},
       {"tied", "values of the parameters that are expressions of others", numbers, false},
       {"converted_from", "the physical quantities that were given", from, false},
       {"options", "options of the command", any},
       {"notes", "sentences on events that meet at an instant and whose order matters", list_schema(text), false}})};
  all.insert(all.end(), members.begin(), members.end());
  return plain_result_schema(schema, meaning, all);
}

const char* status_name(Status status) {
  return status == Status::done ? "done" : status == Status::failed ? "failed" : "interrupted";
}

void set_status(Json& result, Status status, const std::string& message) {
  result["status"] = status_name(status);
  if (!message.empty()) result["message"] = message;
}

int exit_code(Status status) {
  if (status == Status::interrupted) return is_out_of_time() ? 1 : 130;
  return status == Status::done ? 0 : 1;
}

Problem problem_of(const Json& result) {
  try {
    const Json& model = result.at("model");
    Problem problem = model.contains("text")
                          ? parse_problem(model.at("text").get<std::string>(), model.at("file").get<std::string>())
                          : make_problem(model.at("oscillator").get<std::string>(), model.at("contact").get<std::string>());
    if (result.contains("converted_from")) {
      ConvertedFrom& from = problem.converted_from.emplace();
      std::vector<std::string> chosen;
      for (const auto& [name, value] : result["converted_from"].items()) {
        if (name == "excitation")
          from.excitation = value;
        else if (name == "alpha")
          from.alpha = value;
        else if (name == "length")
          from.length = value;
        else if (name == "varied")
          chosen = value.get<std::vector<std::string>>();
        else
          from.quantities.emplace_back(name, value.get<double>());
      }
      vary_quantities(problem, chosen);
    }
    std::vector<std::pair<std::string, double>> values;
    for (const auto& [name, value] : result.at("parameters").items()) values.emplace_back(name, value.get<double>());
    set_parameters(problem, values);
    return problem;
  } catch (const Json::exception& error) {
    throw std::invalid_argument(std::string("the result does not say which model it is of: ") + plain(error));
  }
}

}  // namespace graze::apps
