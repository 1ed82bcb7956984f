// SPDX-License-Identifier: GPL-3.0-or-later
// graze schema: the contents of a result, as a JSON Schema.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>

#include <graze/lib/system/parameters.hpp>

#include <CLI/CLI.hpp>

#include <memory>
#include <stdexcept>

namespace graze::apps {

namespace {

int run(const std::string& name, const Console& console) {
  std::vector<std::string> names;
  for (const Command& command : commands())
    for (const ResultKind& kind : command.results) {
      names.push_back(kind.name);
      if (kind.name == name) console.out << pretty(kind.schema());
      if (kind.name == name) return 0;
    }
  if (!name.empty()) throw std::invalid_argument(unknown_name("result", name, names));
  for (const std::string& one : names) console.out << one << "\n";
  return 0;
}

std::function<int(const Console&)> set_up_schema(CLI::App& app) {
  auto name = std::make_shared<std::string>();
  add_text(app, "NAME", *name, "NAME", "name of the result: orbit of \"graze.orbit/1\"; without, the names are listed");
  return [name](const Console& console) { return run(*name, console); };
}

}  // namespace

Command schema_command() {
  return {"schema",
          "the format of a result: a JSON Schema (draft 2020-12) that describes each field",
          "A result in JSON names its schema: \"graze.orbit/1\" is described by `graze schema orbit`. The schemas also come as "
          "files,\n"
          "data/schemas/NAME.json, for validators and editors.",
          {"graze schema", "graze schema orbit > orbit.schema.json"},
          set_up_schema};
}

}  // namespace graze::apps
