// SPDX-License-Identifier: GPL-3.0-or-later
// graze models: the names available to a problem file: oscillators, contact laws, excitations; their parameters, ranges,
// defaults, units.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/problem/problem.hpp>
#include <graze/apps/problem/shipped.hpp>
#include <graze/apps/text/column.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/apps/text/version.hpp>

#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/models/physical_units.hpp>

#include <fmt/format.h>

#include <cmath>
#include <memory>

namespace graze::apps {

namespace {

Columns<ParameterInfo> parameter_columns(bool with_default) {
  using P = ParameterInfo;
  Columns<P> list = {{"name", "of the parameter", &P::name},
                     {"meaning", "of the parameter", &P::meaning},
                     {"unit", "of the parameter", &P::unit},
                     {"range", "in words", [](const P& info) { return range_text(info); }},
                     {"lower", "end of the range; null: none", [](const P& info) { return finite(info.lower); }},
                     {"lower_open", "the lower end is not in it", &P::lower_open},
                     {"upper", "end of the range; null: none", [](const P& info) { return finite(info.upper); }}};
  if (with_default) list.push_back(Column<P>("default", "where the file gives none", &P::default_value));
  return list;
}

Json parameters_json(const std::vector<ParameterInfo>& list, bool with_default) {
  const Columns<ParameterInfo> columns = parameter_columns(with_default);
  Json out = Json::array();
  for (const ParameterInfo& info : list) out.push_back(json_of(columns, info));
  return out;
}

void add_rows(Table& table, const std::string& owner, const std::vector<ParameterInfo>& list, bool with_default) {
  for (const ParameterInfo& info : list)
    table.rows.push_back(
        {owner, info.name, range_text(info), with_default ? rounded(info.default_value, 8) : "none", info.unit, info.meaning});
}

/// The values of beta that distinguish the oscillators.
std::string beta_defaults() {
  std::string text;
  for (const OscillatorKind& kind : oscillator_kinds())
    text += fmt::format("{}{}: beta = {}", text.empty() ? "" : "; ", kind.name, rounded(kind.beta, 8));
  return text;
}

std::vector<ParameterInfo> contact_infos() {
  std::vector<ParameterInfo> list;
  for (const ContactQuantity& quantity : contact_quantities()) list.push_back(quantity.info);
  return list;
}

Result describe_models() {
  Result result;
  Json& json =
      result.json = {{"schema", "graze.models/1"}, {"graze", program_version}, {"command", "models"}, {"status", "done"}};
  result.table.columns = {"of", "name", "range", "default", "unit", "meaning"};
  std::string text = "Oscillators: ' = d/dtau, forcing period 2 pi / eta, one barrier at x = r, F from a contact law\n";
  for (const OscillatorKind& kind : oscillator_kinds()) {
    json["oscillators"].push_back({{"name", kind.name}, {"formula", kind.formula}, {"beta", kind.beta}});
    text += fmt::format("  {:<12} {}\n", kind.name, kind.formula);
  }
  json["parameters"] = parameters_json(oscillator_parameters(), true);
  add_rows(result.table, "oscillator", oscillator_parameters(), true);
  text += "\nContact laws\n";
  for (const ContactLaw& law : contact_laws()) {
    json["contact_laws"].push_back({{"name", law.name},
                                    {"formula", law.formula},
                                    {"hard", law.hard},
                                    {"parameters", parameters_json(law.parameters, true)}});
    add_rows(result.table, law.name, law.parameters, true);
    text += fmt::format("  {:<12} {}\n", law.name, law.formula);
  }
  text += "\nParameters (section [parameters] of a problem file)\n" + aligned(result.table);
  text += "  default of beta by oscillator: " + beta_defaults() + "\n";
  json["smallest_eta"] = slowest_forcing;
  text += fmt::format("  motions are computed for eta >= {}\n", slowest_forcing);
  text += "\nPhysical quantities (section [physical], with excitation = \"...\"), converted; in one coherent set of units\n";
  Table physical{result.table.columns, {}};
  for (const ExcitationKind& kind : excitation_kinds()) {
    json["excitations"].push_back(
        {{"name", kind.name}, {"formula", kind.formula}, {"quantities", parameters_json(kind.quantities, false)}});
    add_rows(physical, kind.name, kind.quantities, false);
    text += fmt::format("  {:<12} {}\n", kind.name, kind.formula);
  }
  json["contact_quantities"] = parameters_json(contact_infos(), false);
  add_rows(physical, "contact", contact_infos(), false);
  text += aligned(physical);
  text += "\nModels written as text (graze models NAME prints the file, to begin a system of one's own from)\n";
  for (const std::string& name : shipped_models()) {
    const std::string model = shipped_model(name);
    const std::string title = model.substr(0, model.find('\n'));
    json["models"].push_back({{"name", name}, {"title", title.substr(std::min<std::size_t>(2, title.size()))}});
    text += fmt::format("  {:<25} {}\n", name, json["models"].back()["title"].get<std::string>());
  }
  result.text = std::move(text);
  result.table.rows.insert(result.table.rows.end(), physical.rows.begin(), physical.rows.end());
  return result;
}

Json models_result_schema() {
  const Json text = JsonForm<std::string>::schema(), number = JsonForm<double>::schema();
  const Json parameters = list_schema(schema_of(parameter_columns(true))),
             quantities = list_schema(schema_of(parameter_columns(false)));
  const Member name = {"name", "as problem files have it", text}, formula = {"formula", "in words", text};
  const Json oscillator = object_schema({name, formula, {"beta", "its cubic stiffness", number}});
  const Json law = object_schema(
      {name, formula, {"hard", "contacts take no time", JsonForm<bool>::schema()}, {"parameters", "of the law", parameters}});
  const Json excitation = object_schema({name, formula, {"quantities", "physical ones", quantities}});
  const Json model = object_schema({name, {"title", "first line of the file", text}});
  return plain_result_schema("models/1", "names for problem files",
                             {object_schema({{"oscillators", "built in", list_schema(oscillator)},
                                             {"parameters", "of every oscillator", parameters},
                                             {"contact_laws", "built in", list_schema(law)},
                                             {"smallest_eta", "smallest forcing frequency that is computed", number},
                                             {"excitations", "of physical problems", list_schema(excitation)},
                                             {"contact_quantities", "of physical problems", quantities},
                                             {"models", "models that come as files", list_schema(model), false}})});
}

std::function<int(const Console&)> set_up_models(CLI::App& app) {
  auto options = std::make_shared<OutputOptions>();
  auto name = std::make_shared<std::string>();
  add_text(app, "NAME", *name, "NAME", "print the file of this model");
  add_output_options(app, *options, "models/1");
  return [options, name](const Console& console) {
    if (!name->empty()) {
      console.out << shipped_model(*name);
      return 0;
    }
    const OutputFolder folder(*options, "models");
    const Result models = describe_models();
    folder.check_free_for(models.json);
    return deliver(models, *options, "models", 0, console);
  };
}

}  // namespace

Command models_command() {
  return {"models",
          "built-in oscillators and contact laws, their parameters, ranges, defaults",
          "The names that a problem file may use, and the models that come as files with their own equations.",
          {"graze models", "graze models duffing-two-stops > mine.toml", "graze models --json -"},
          set_up_models,
          {{"models", models_result_schema}}};
}

}  // namespace graze::apps
