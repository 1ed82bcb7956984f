// SPDX-License-Identifier: GPL-3.0-or-later
// graze reproduce: published figures beside computed ones, row by row, and the pictures.
#include <graze/apps/arguments.hpp>
#include <graze/apps/commands/command.hpp>
#include <graze/apps/interrupt.hpp>
#include <graze/apps/progress.hpp>
#include <graze/apps/published/reproduction.hpp>
#include <graze/apps/result.hpp>
#include <graze/apps/version.hpp>

#include <fmt/format.h>

#include <memory>
#include <stdexcept>

namespace graze::apps {

namespace {

struct Options {
  std::string file, resume;
  OutputOptions output;
};

int run(const Options& options, const Console& console) {
  const Published published = load_published(options.file);
  Reproduction found;
  {
    Progress progress(console.err, console.quiet, "reproducing");
    ReproductionOptions asking;
    asking.threads = console.thread_count();
    asking.cancelled = interrupted;
    asking.progress = [&](const std::string& what, double fraction) { progress.update(fraction, [&] { return what; }); };
    found = reproduce(published, asking);
  }
  Result result;
  result.json["rows"] = Json::array();
  for (const Comparison& row : found.rows) result.json["rows"].push_back(comparison_json(row));
  for (const Claim& claim : found.claims) result.json["claims"].push_back(claim_json(claim));
  result.table = comparisons_table(found.rows);
  result.text = aligned(result.table);
  for (const Comparison& row : found.rows)
    if (!row.remark.empty())
      result.text += fmt::format("\n{} {} {}: {}", row.figure, row.quantity, row.published_text, row.remark);
  for (const Claim& claim : found.claims) result.text += "\n" + claim.statement + ": " + claim.computed;
  return deliver(result, options.output, "reproduce", 0, console);
}

std::function<int(const Console&)> setup(CLI::App& app) {
  auto options = std::make_shared<Options>();
  add_text(app, "FILE", options->file, "FILE", "published figures (TOML)");
  add_output_options(app, options->output, "reproduce/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command reproduce_command() {
  return {"reproduce", "published figures against computed ones, row by row, and the pictures", "", {}, setup};
}

}  // namespace graze::apps
