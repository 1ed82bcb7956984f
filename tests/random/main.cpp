// SPDX-License-Identifier: GPL-3.0-or-later
// Runs any number of random cases:
//
//     random_cases [--command continue|diagram] [--cases N] [--seed S] [--first K] [--model NAME] [--param NAME]
//                  [--most-impacts M] [--limit SECONDS] [--patience SECONDS] [--time SECONDS] [--program PATH]
//
// NAME of a model: newton-elastic (default), or a file of systems/ without its extension.
// Prints one line for each case that fails, with the command that reproduces it, and then the number of complaints of each
// kind. The exit code is 0 only if none failed.
#include "runner.hpp"

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <stdexcept>

using namespace graze::reference;

namespace {

Plan plan_of(int argc, char** argv) {
  Plan plan;
  plan.program = GRAZE_PROGRAM;
  plan.data = GRAZE_DATA_DIR "/problems";
  plan.systems = GRAZE_RANDOM_SYSTEMS;
  std::string parameter;
  for (int i = 1; i < argc; i += 2) {  // pairs of name and value
    const std::string name = argv[i];
    if (i + 1 == argc) throw std::invalid_argument(name + ": a value is missing");
    const std::string value = argv[i + 1];
    if (name == "--cases")
      plan.cases = std::stoull(value);
    else if (name == "--seed")
      plan.seed = std::stoull(value);
    else if (name == "--first")
      plan.first = std::stoull(value);
    else if (name == "--most-impacts")
      plan.most_impacts = std::stoi(value);
    else if (name == "--patience")
      plan.patience = std::stod(value);
    else if (name == "--limit")
      plan.limit = std::stod(value);
    else if (name == "--time")
      plan.time = std::stod(value);
    else if (name == "--command") {
      if (value != "continue" && value != "diagram") throw std::invalid_argument("--command: continue or diagram, not " + value);
      plan.skeletons = value == "diagram";
    } else if (name == "--program")
      plan.program = value;
    else if (name == "--param")
      parameter = value;
    else if (name == "--model") {
      const auto found = std::find(model_names.begin(), model_names.end(), value);
      if (found == model_names.end()) throw std::invalid_argument("--model: no model " + value);
      plan.model = static_cast<Model>(found - model_names.begin());
    } else
      throw std::invalid_argument("unknown option " + name);
  }
  const auto names = parameter_names(plan.model);
  const auto found = std::find(names.begin(), names.end(), parameter);
  if (!parameter.empty() && found == names.end()) throw std::invalid_argument("--param: no parameter " + parameter);
  if (!parameter.empty()) plan.name = static_cast<std::size_t>(found - names.begin());
  if (plan.skeletons && plan.model != Model::barrier) throw std::invalid_argument("--command diagram: of newton-elastic only");
  return plan;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Plan plan = plan_of(argc, argv);
    const Summary summary = run(plan, std::cout);
    std::cout << summary.cases << " cases, " << summary.families << " families compared, " << summary.unresolved << " not, "
              << summary.undecided << " undecided, " << summary.failed << " failed\n";
    for (const auto& [kind, count] : summary.kinds) std::cout << "  " << count << "  " << kind << "\n";
    return summary.failed == 0 ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}
