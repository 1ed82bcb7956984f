// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/problem/toml_section.hpp>
#include <graze/apps/published/published.hpp>
#include <graze/apps/results/input_file.hpp>
#include <graze/apps/results/orbit_report.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

template <class Value>
Value required(std::optional<Value> value, const TomlSection& section, const std::string& key, const std::string& wanted) {
  if (!value) throw section.lacks(key, wanted);
  return std::move(*value);
}

std::string required_text(TomlSection& section, const std::string& key, const std::string& wanted) {
  return required(section.text(key), section, key, wanted);
}

PublishedSystem read_system(TomlSection& section) {
  PublishedSystem out;
  out.id = required_text(section, "id", "a name for the system");
  out.contact = required_text(section, "contact", "the contact law (graze models lists them)");
  TomlSection parameters = section.table("parameters");
  for (const std::string& name : parameters.keys()) out.parameters.emplace_back(name, *parameters.number(name));
  section.finish();
  return out;
}

std::array<double, 2> read_range(TomlSection& section) {
  const auto list = required(section.numbers("eta"), section, "eta", "the range [from, to]");
  if (list.size() != 2 || !(list[0] <= list[1]))
    throw std::invalid_argument(fmt::format("{}: eta must be a range [from, to] with from <= to", section.where("eta")));
  return {list[0], list[1]};
}

PublishedAttractor read_attractor(TomlSection& section) {
  PublishedAttractor out;
  out.type = required_text(section, "attractor", "\"impactless\", \"periodic\" or \"chaotic\"");
  if (out.type != "impactless" && out.type != "periodic" && out.type != "chaotic")
    throw std::invalid_argument(fmt::format("{}: attractor = {:?} must be \"impactless\", \"periodic\" or \"chaotic\"",
                                            section.where("attractor"), out.type));
  if (const auto z = section.numbers("z")) {
    const auto whole = [](double value) { return value >= 0.0 && value <= 1e6 && std::floor(value) == value; };
    if (z->size() != 2 || !whole(z->at(0)) || !whole(z->at(1)) || z->at(1) < 1.0)
      throw std::invalid_argument(fmt::format("{}: z must be [p, n]: p impacts in n forcing periods", section.where("z")));
    out.z = {static_cast<int>(z->at(0)), static_cast<int>(z->at(1))};
    out.periods = out.z->at(1);
  }
  out.periods = section.count("periods", 1, longest_period).value_or(out.periods);
  return out;
}

PublishedWindow read_window(TomlSection& section) {
  PublishedWindow out;
  const auto range = read_range(section);
  out.from = range[0];
  out.to = range[1];
  out.direction = section.text("direction").value_or("both");
  if (out.direction != "up" && out.direction != "down" && out.direction != "both")
    throw std::invalid_argument(
        fmt::format("{}: direction = {:?} must be \"up\", \"down\" or \"both\"", section.where("direction"), out.direction));
  out.attractor = read_attractor(section);
  out.note = section.text("note").value_or("");
  section.finish();
  return out;
}

}  // namespace

std::string label(const PublishedAttractor& attractor) {
  if (attractor.z) return z_label((*attractor.z)[0], (*attractor.z)[1]);
  if (attractor.type == "periodic" && attractor.periods > 0) return fmt::format("period {}", attractor.periods);
  return attractor.type;
}

std::size_t Published::items() const {
  std::size_t count = points.size() + exponents.size();
  for (const PublishedPoint& point : points) count += point.multipliers.empty() ? 0 : 1;
  for (const PublishedDiagram& diagram : diagrams) count += diagram.windows.size();
  return count;
}

Published parse_published(std::string_view text, const std::string& file) {
  const toml::table root = parse_toml(text, file);
  check_sections(root, {file, std::string(text)}, {"system", "special_point", "exponents", "diagram"});
  Published out;
  out.file = file;
  TomlSection file_section(file, "", root);
  for (TomlSection& section : file_section.tables("system")) out.systems.push_back(read_system(section));
  const auto known = [&](TomlSection& section) {
    std::string id = required_text(section, "system", "the id of a [[system]]");
    std::vector<std::string> ids;
    for (const PublishedSystem& system : out.systems) ids.push_back(system.id);
    if (std::find(ids.begin(), ids.end(), id) == ids.end())
      throw std::invalid_argument(fmt::format("{}: {}", section.where("system"), unknown_name("system", id, ids)));
    return id;
  };
  for (TomlSection& section : file_section.tables("special_point")) {
    PublishedPoint point;
    point.system = known(section);
    point.type = required_text(section, "type", "\"PD\", \"LP\", \"GR\" or another type of special point");
    point.eta = required(section.number("eta"), section, "eta", "the printed value");
    point.digits = required(section.count("digits", 0, 15), section, "digits", "the number of decimals printed");
    point.multipliers_at = section.number("printed_multipliers_at");
    for (const Vector& pair : section.states("printed_multipliers")) point.multipliers.emplace_back(pair[0], pair[1]);
    if (!point.multipliers.empty() && !point.multipliers_at)
      throw section.lacks("printed_multipliers_at", "the value of eta for which they are printed");
    section.finish();
    out.points.push_back(std::move(point));
  }
  for (TomlSection& section : file_section.tables("exponents")) {
    PublishedExponents row;
    row.system = known(section);
    row.eta = section.number("eta");
    row.beta = section.number("beta");
    row.attractor = read_attractor(section);
    row.initial = section.state("initial");
    row.lambda = required(section.numbers("lambda"), section, "lambda", "the printed exponents, largest first");
    row.digits = required(section.count("digits", 0, 15), section, "digits", "the number of decimals printed");
    row.figure = section.text("figure").value_or("");
    section.finish();
    out.exponents.push_back(std::move(row));
  }
  for (TomlSection& section : file_section.tables("diagram")) {
    PublishedDiagram diagram;
    diagram.system = known(section);
    diagram.figure = section.text("figure").value_or("");
    const auto range = read_range(section);
    diagram.from = range[0];
    diagram.to = range[1];
    diagram.step = required(section.number("step"), section, "step", "from one value of eta to the next");
    if (!(diagram.step > 0.0) || !(diagram.from < diagram.to))
      throw std::invalid_argument(
          fmt::format("{}: a diagram goes from one value of eta up to another by a step > 0", section.where("step")));
    for (TomlSection& window : section.tables("windows")) diagram.windows.push_back(read_window(window));
    section.finish();
    out.diagrams.push_back(std::move(diagram));
  }
  if (out.items() == 0)
    throw std::invalid_argument(
        fmt::format("{}: holds nothing to compare with: no [[special_point]], [[exponents]] or [[diagram]]", file));
  return out;
}

Published load_published(const std::string& file) { return parse_published(read_whole(file), file); }

Problem problem_of(const Published& published, const std::string& system, std::optional<double> eta, std::optional<double> beta) {
  const auto found =
      std::find_if(published.systems.begin(), published.systems.end(), [&](const auto& s) { return s.id == system; });
  if (found == published.systems.end())
    throw std::invalid_argument(fmt::format("{}: there is no system {:?}", published.file, system));
  std::vector<std::pair<std::string, double>> values = found->parameters;
  if (beta) values.emplace_back("beta", *beta);
  if (eta) values.emplace_back("eta", *eta);
  double cubic = 0.0;
  for (const auto& [name, value] : values)
    if (name == "beta") cubic = value;
  Problem problem = make_problem(cubic == 0.0 ? "linear" : "cantilever", found->contact);
  for (const auto& [name, value] : values) {
    try {
      set_parameter(problem, name, value);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("{}: system {:?}: {}", published.file, system, error.what()));
    }
  }
  problem.file = published.file;
  return problem;
}

}  // namespace graze::apps
