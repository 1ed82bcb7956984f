// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/text/number.hpp>

#include <graze/lib/system/parameters.hpp>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace graze::apps {

namespace {

/// "--near" from "-n,--near".
std::string long_name(const std::string& names) { return names.substr(names.rfind(',') + 1); }

[[noreturn]] void refuse(const std::string& names, const std::string& given, const std::string& wanted) {
  throw CLI::ValidationError(fmt::format("{} {}", long_name(names), given), "must be " + wanted);
}

constexpr const char* magnitude = "0 or of a magnitude from 4.9e-324 to 1.8e308, which a double holds";

double number(const std::string& names, const std::string& text) {
  const std::optional<double> value = parse_number(text);
  if (!value) refuse(names, text, is_beyond_double(text) ? magnitude : "a number (0.92, 36/35 and 2*pi are)");
  return *value;
}

int count(const std::string& names, const std::string& text, int least, int most) {
  const std::optional<double> value = parse_number(text);
  if (value && *value >= least && *value <= most && *value == std::floor(*value)) return static_cast<int>(*value);
  // A limit that is hardly ever reached is named only if it is exceeded.
  const bool limited = most < std::numeric_limits<int>::max() || (value && *value > most) || is_beyond_double(text);
  refuse(names, text, fmt::format("a whole number >= {}{}", least, limited ? fmt::format(" and <= {}", most) : ""));
}

bool equal_but_case(const std::string& a, const std::string& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char c, unsigned char d) { return std::tolower(c) == std::tolower(d); });
}

/// The common part: an option whose text is passed to `take`.
void add(CLI::App& app, const std::string& names, const std::string& placeholder, const std::string& help, Need need,
         const std::function<void(const std::string&)>& take) {
  CLI::Option* option = app.add_option_function<std::string>(names, take, help)->type_name(placeholder);
  if (need == Need::required) option->required();
}

void add_many(CLI::App& app, const std::string& names, const std::string& placeholder, const std::string& help,
              const std::function<void(const std::vector<std::string>&)>& take) {
  app.add_option_function<std::vector<std::string>>(names, take, help)->type_name(placeholder)->allow_extra_args(false);
}

}  // namespace

void add_flag(CLI::App& app, const std::string& names, bool& target, const std::string& help) {
  app.add_flag(names, target, help);
}

void add_text(CLI::App& app, const std::string& names, std::string& target, const std::string& placeholder,
              const std::string& help, Need need) {
  add(app, names, placeholder, help, need, [&target, names](const std::string& text) {
    if (text.empty()) refuse(names, "\"\"", "a name, and not empty");
    target = text;
  });
}

void add_texts(CLI::App& app, const std::string& names, std::vector<std::string>& target, const std::string& placeholder,
               const std::string& help) {
  add_many(app, names, placeholder, help, [&target](const std::vector<std::string>& texts) { target = texts; });
}

void add_number(CLI::App& app, const std::string& names, std::optional<double>& target, const std::string& help, Need need) {
  add(app, names, "VALUE", help, need, [&target, names](const std::string& text) { target = number(names, text); });
}

void add_numbers(CLI::App& app, const std::string& names, std::vector<double>& target, const std::string& help) {
  add_many(app, names, "VALUE", help, [&target, names](const std::vector<std::string>& texts) {
    target.clear();
    for (const std::string& text : texts) target.push_back(number(names, text));
  });
}

void add_count(CLI::App& app, const std::string& names, std::optional<int>& target, int least, const std::string& help,
               int most) {
  add(app, names, "N", help, Need::optional,
      [&target, names, least, most](const std::string& text) { target = count(names, text, least, most); });
}

void add_count(CLI::App& app, const std::string& names, int& target, int least, const std::string& help, int most) {
  add(app, names, "N", help, Need::optional,
      [&target, names, least, most](const std::string& text) { target = count(names, text, least, most); });
}

void add_state(CLI::App& app, const std::string& names, std::optional<StateText>& target, const std::string& help) {
  add(app, names, "x,v", help, Need::optional, [&target, names](const std::string& text) {
    target = parse_state(text);
    if (!target) refuse(names, text, state_form(text));
  });
}

std::optional<StateText> parse_state(const std::string& text) {
  StateText state;
  std::string values;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const std::size_t equals = part.find('=');
    const bool named = equals != std::string::npos && equals > 0;
    if (begin > 0 && named == state.names.empty()) return std::nullopt;  // all names or none
    if (named) state.names.push_back(part.substr(0, equals));
    values += (begin > 0 ? "," : "") + (named ? part.substr(equals + 1) : part);
    begin = end + 1;
  }
  const std::optional<Vector> numbers = parse_numbers(values);
  if (!numbers || numbers->size() == 0) return std::nullopt;
  state.values = *numbers;
  return state;
}

void add_choice(CLI::App& app, const std::string& names, std::string& target, const std::vector<std::string>& choices,
                const std::string& help, Need need) {
  add(app, names, fmt::format("{}", fmt::join(choices, "|")), help, need, [&target, names, choices](const std::string& text) {
    if (std::find(choices.begin(), choices.end(), text) == choices.end()) {
      // "pd" differs from PD by two letters, but its meaning is clear.
      const auto same =
          std::find_if(choices.begin(), choices.end(), [&](const std::string& choice) { return equal_but_case(choice, text); });
      const std::string nearest = same != choices.end() ? *same : nearest_name(text, choices);
      refuse(names, text,
             fmt::format("one of {}{}", fmt::join(choices, ", "),
                         nearest.empty() ? "" : fmt::format(" (did you mean {}?)", nearest)));
    }
    target = text;
  });
}

std::string state_form(const std::string& text) {
  const std::size_t comma = text.find(',');
  const bool beyond =
      is_beyond_double(text.substr(0, comma)) || (comma != std::string::npos && is_beyond_double(text.substr(comma + 1)));
  return fmt::format("two numbers x,v{}, or one for each state of another system, for example 0.5,-1.2, or by name, x=0.5,v=-1.2",
                     beyond ? fmt::format(", each {}", magnitude) : "");
}

void begin_group(CLI::App& app, const std::string& heading) { app.option_defaults()->group(heading); }

}  // namespace graze::apps
