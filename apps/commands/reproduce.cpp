// SPDX-License-Identifier: GPL-3.0-or-later
// graze reproduce: published figures beside computed ones, row by row, and the pictures.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/output_file.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/drawing/draw_files.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/problem/shipped.hpp>
#include <graze/apps/published/figures.hpp>
#include <graze/apps/results/input_file.hpp>
#include <graze/apps/results/sweep_report.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/apps/text/version.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <stdexcept>

namespace graze::apps {

namespace {

struct ReproduceArguments {
  std::string file, resume;
  bool no_claims = false;
  OutputOptions output;
};

/// The given file, or the one shipped with the program: installed beside it, or in the source tree.
std::string published_file(const ReproduceArguments& options) {
  if (!options.file.empty()) return options.file;
  const std::filesystem::path found = shipped("published.toml");
  if (!found.empty()) return found.string();
  throw std::invalid_argument(
      "published.toml is neither installed beside the program nor in the tree it was built from; give the file");
}

Json diagrams_json(const std::vector<SweptDiagram>& diagrams) {
  Json list = Json::array();
  for (const SweptDiagram& swept : diagrams)
    list.push_back({{"figure", swept.diagram.figure},
                    {"system", swept.diagram.system},
                    {"eta", {swept.diagram.from, swept.diagram.to}},
                    {"step", swept.diagram.step},
                    {"rows", rows_json(swept.rows)}});
  return list;
}

/// The results of an earlier run that apply to this one: diagrams of the same range, rows, claims.
Reproduction earlier_run(const Json& json, const ReproduceArguments& options, const Published& published) {
  Reproduction earlier;
  if (json.is_null()) return earlier;
  try {
    earlier.rows = value_of<std::vector<Comparison>>(json.at("rows"));
    earlier.claims = value_of<std::vector<Claim>>(json.at("claims"));
    for (const Json& swept : json.at("diagrams"))
      for (const PublishedDiagram& diagram : published.diagrams)
        if (swept.at("figure") == diagram.figure && swept.at("system") == diagram.system && swept.at("step") == diagram.step &&
            swept.at("eta") == Json{diagram.from, diagram.to})
          earlier.diagrams.push_back(
              {diagram, problem_of(published, diagram.system), value_of<std::vector<SweepRow>>(swept.at("rows"))});
  } catch (const Json::exception& error) {
    throw_not_resumable(options.resume, "reproduce", fmt::format("is damaged ({}); compute it anew", plain(error)));
  }
  return earlier;
}

std::string report(const Reproduction& found) {
  Table numbers{{"figure", "system", "eta", "quantity", "published", "computed", "verdict"}, {}};
  Table windows{{"figure", "system", "published window", "verdict"}, {}};
  const Table all = comparisons_table(found.rows);
  for (std::size_t k = 0; k < found.rows.size(); ++k) {
    const std::vector<std::string>& cells = all.rows[k];
    if (found.rows[k].quantity == "window")
      windows.rows.push_back({cells[0], cells[1], cells[4], cells[6]});
    else
      numbers.rows.push_back(cells);
  }
  std::string text = aligned(numbers) + "\n" + aligned(windows);
  text += fmt::format("\n{} of {} rows agree, {} differ\n", count_of(found.rows, Verdict::agrees), found.rows.size(),
                      count_of(found.rows, Verdict::differs));
  std::string remarks;
  for (const Comparison& row : found.rows)
    if (!row.remark.empty())
      remarks += fmt::format("  {}{} {} {}: {}\n", row.figure.empty() ? "" : row.figure + " ", row.system, row.quantity,
                             row.published_text, row.remark);
  if (!remarks.empty()) text += "\nremarks\n" + remarks;
  for (const Claim& claim : found.claims)
    text += fmt::format("\nclaim: {}\n  criterion: {}\n  computed: {}\n  verdict: {}\n", claim.statement, claim.criterion,
                        claim.computed, verdict_name(claim.verdict));
  return text;
}

/// Draws the figures into the folder, in parallel, and writes the page. Returns sentences on outputs that could not be written.
std::vector<std::string> write_pictures(const Published& published, const Reproduction& found, const std::string& folder,
                                        const Console& console) {
  const std::vector<Figure> figures = figures_of(published, found);
  std::vector<Drawing> drawings;
  for (const Figure& figure : figures) drawings.push_back({fmt::format("{}/{}.png", folder, figure.name), figure.picture});
  std::vector<std::string> failures;
  Progress progress(console.err, console.quiet, "drawing");
  std::size_t done = 0;
  draw_into_files(
      drawings, console, [&](const std::string& sentence) { failures.push_back(sentence); },
      [&](std::size_t k) {
        progress.update(static_cast<double>(++done) / static_cast<double>(figures.size()), [&] { return figures[k].name; });
      });
  if (const auto failure = write_whole(folder + "/index.html", index_page(published, found, figures)))
    failures.push_back(*failure);
  return failures;
}

int run(const ReproduceArguments& given, const Console& console) {
  ReproduceArguments options = given;
  if (!options.resume.empty() && options.output.out.empty()) options.output.out = options.resume;
  const std::string file = published_file(options);
  const Published published = load_published(file);
  const OutputFolder folder(options.output, "reproduce", file, options.resume);
  const Reproduction earlier = earlier_run(folder.earlier(), options, published);
  Result result;
  result.json = {{"schema", "graze.reproduce/1"}, {"graze", program_version},
                 {"command", "reproduce"},        {"file", file},
                 {"systems", Json::object()},     {"options", {{"claims", !options.no_claims}}}};
  for (const PublishedSystem& system : published.systems) {
    result.json["systems"][system.id]["contact"] = system.contact;
    for (const auto& [name, value] : system.parameters) result.json["systems"][system.id]["parameters"][name] = value;
  }
  folder.check_free_for(result.json);
  Reproduction found;
  {
    Progress progress(console.err, console.quiet, "reproducing");
    ReproductionOptions asking;
    asking.threads = console.thread_count();
    asking.claims = !options.no_claims;
    asking.cancelled = interrupted;
    asking.progress = [&](const std::string& what, double fraction) { progress.update(fraction, [&] { return what; }); };
    found = reproduce(published, asking, earlier);
  }
  const Status status = found.complete ? Status::done : Status::interrupted;
  const std::string message =
      found.complete ? "" : fmt::format("{} with {} of {} rows", interruption(), found.rows.size(), published.items());
  set_status(result.json, status, message);
  result.json["rows"] = json_of(found.rows);
  result.json["claims"] = json_of(found.claims);
  result.json["diagrams"] = diagrams_json(found.diagrams);
  result.table = comparisons_table(found.rows);
  result.table.columns.emplace_back("remark");
  for (std::size_t k = 0; k < found.rows.size(); ++k) result.table.rows[k].push_back(found.rows[k].remark);
  result.text = report(found);
  if (status != Status::done) console.err << "graze reproduce: " << message << resume_advice(status, options.output) << "\n";
  int code = deliver(result, options.output, "reproduce", exit_code(status), console);
  if (options.output.out.empty() || status != Status::done) return code;
  for (const std::string& failure : write_pictures(published, found, options.output.out, console)) {
    console.err << "graze reproduce: " << failure << "\n";
    if (code == 0) code = interrupted() ? 130 : 2;
  }
  console.note(fmt::format("{}/index.html shows all of it", options.output.out));
  return code;
}

Json reproduce_result_schema() {
  const Json text = JsonForm<std::string>::schema(), number = JsonForm<double>::schema();
  const Json system = object_schema(
      {{"contact", "its law", text}, {"parameters", "of the system", JsonForm<std::map<std::string, double>>::schema(), false}});
  const Json diagram = object_schema({{"figure", "published figure", text},
                                      {"system", "id of the system", text},
                                      {"eta", "its range", JsonForm<std::array<double, 2>>::schema()},
                                      {"step", "from one value to the next", number},
                                      {"rows", "of the sweeps", rows_schema()}});
  return plain_result_schema("reproduce/1", "published figures against computed ones",
                             {object_schema({{"file", "of the published figures", text},
                                             {"systems", "by id", {{"type", "object"}, {"additionalProperties", system}}},
                                             {"options", "options of the command", {{"type", "object"}}},
                                             {"rows", "one for each published item", JsonForm<std::vector<Comparison>>::schema()},
                                             {"claims", "claims made in words", JsonForm<std::vector<Claim>>::schema()},
                                             {"diagrams", "bifurcation diagrams", list_schema(diagram)}})});
}

std::function<int(const Console&)> set_up_reproduce(CLI::App& app) {
  auto options = std::make_shared<ReproduceArguments>();
  begin_group(app, "Reproduction");
  add_text(app, "FILE", options->file, "FILE",
           "published figures (TOML; default: the published.toml that came with the program)");
  add_flag(app, "--no-claims", options->no_claims, "leave out the claims that the source makes in words");
  add_text(app, "--resume", options->resume, "DIR", "continue an interrupted run with --out DIR");
  add_output_options(app, options->output, "reproduce/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command reproduce_command() {
  return {
      "reproduce",
      "published figures against computed ones, row by row, and the pictures",
      "Every special point, pair of exponents and window of a bifurcation diagram in the file is computed anew, with its\n"
      "uncertainty. A number agrees where it lies within half a unit of the last printed decimal and three standard errors of\n"
      "ours; a remark gives the cause of a difference, if known. --out gets the figures as well, and index.html, which shows\n"
      "them beside the comparison. The exit code is 0 for any verdicts.",
      {"graze reproduce --out reproduction", "graze reproduce data/published.toml --json -"},
      set_up_reproduce,
      {{"reproduce", reproduce_result_schema}}};
}

}  // namespace graze::apps
