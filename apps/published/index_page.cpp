// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/published/figures.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/apps/text/version.hpp>

#include <fmt/format.h>

namespace graze::apps {

namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

constexpr const char* head = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>Published and computed figures</title>
<style>
body { font-family: sans-serif; margin: 2em auto; max-width: 1300px; padding: 0 1em; line-height: 1.4; }
table { border-collapse: collapse; font-size: 0.85em; }
th, td { border: 1px solid #ccc; padding: 0.25em 0.5em; text-align: left; vertical-align: top; }
th { background: #f0f0f0; }
.agrees { background: #e3f4e3; }
.differs { background: #fbe5e1; }
figure { margin: 2em 0; }
figure img { max-width: 100%; border: 1px solid #ddd; }
</style>
</head>
<body>
)";

std::string row_of(const Comparison& row, const std::vector<Figure>& figures) {
  std::string figure = escaped(row.figure);
  for (const Figure& candidate : figures)
    if (!row.figure.empty() && candidate.name == "figure-" + row.figure)
      figure = fmt::format("<a href=\"#{}\">{}</a>", candidate.name, figure);
  const char* verdict = verdict_name(row.verdict);
  return fmt::format(
      "<tr class=\"{}\"><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", verdict,
      figure, escaped(row.system), row.eta ? rounded(*row.eta, 7) : "", escaped(row.quantity), escaped(row.published_text),
      escaped(row.computed_text), verdict, escaped(row.remark));
}

}  // namespace

std::string index_page(const Published& published, const Reproduction& reproduction, const std::vector<Figure>& figures) {
  std::string page = head;
  page += "<h1>Published and computed figures</h1>\n";
  page += fmt::format("<p>graze {}, figures of {}: {} of {} rows agree, {} differ{}.</p>\n", program_version,
                      escaped(published.file), count_of(reproduction.rows, Verdict::agrees), reproduction.rows.size(),
                      count_of(reproduction.rows, Verdict::differs),
                      reproduction.complete ? "" : fmt::format("; interrupted: {} rows are wanted", published.items()));
  page +=
      "<p>A number agrees where it lies within half a unit of the last printed decimal and three standard errors of our own; "
      "exponents of periodic motions come from their multipliers and have no such error. A window agrees where at every value "
      "of eta the attractor is the one described. Nothing is tuned to a printed value.</p>\n";
  page += "<table>\n<tr><th>figure</th><th>system</th><th>eta</th><th>quantity</th><th>published</th><th>computed</th>"
          "<th>verdict</th><th>remark</th></tr>\n";
  for (const Comparison& row : reproduction.rows) page += row_of(row, figures);
  page += "</table>\n";
  if (!reproduction.claims.empty()) page += "<h2>Claims in words</h2>\n";
  for (const Claim& claim : reproduction.claims)
    page += fmt::format("<p class=\"{}\"><b>{}.</b> Criterion: {}. Computed: {}. <b>{}</b></p>\n", verdict_name(claim.verdict),
                        escaped(claim.statement), escaped(claim.criterion), escaped(claim.computed),
                        claim.verdict == Verdict::agrees ? "Agrees." : "Differs.");
  page += "<h2>Figures</h2>\n";
  for (const Figure& figure : figures)
    page += fmt::format("<figure id=\"{0}\"><img src=\"{0}.png\" alt=\"{1}\"><figcaption>{1}</figcaption></figure>\n",
                        figure.name, escaped(figure.caption));
  return page + "</body>\n</html>\n";
}

}  // namespace graze::apps
