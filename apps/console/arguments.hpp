// SPDX-License-Identifier: GPL-3.0-or-later
// Options of a command, one function per kind of value. Each function reports an invalid value in one sentence. All numbers are
// read by parse_number: 0.92, 36/35, 2*pi.
//
// `names` are CLI11's: "--near", "-o,--output", or "PROBLEM" for a positional argument. The target must outlive the parsing of
// the command line. Only arguments.cpp and program.cpp include CLI11 itself.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming)
class App;
}

namespace graze::apps {

enum class Need { optional, required };

void add_flag(CLI::App& app, const std::string& names, bool& target, const std::string& help);

void add_text(CLI::App& app, const std::string& names, std::string& target, const std::string& placeholder,
              const std::string& help, Need need = Need::optional);

/// May be given several times.
void add_texts(CLI::App& app, const std::string& names, std::vector<std::string>& target, const std::string& placeholder,
               const std::string& help);

void add_number(CLI::App& app, const std::string& names, std::optional<double>& target, const std::string& help,
                Need need = Need::optional);

/// May be given several times.
void add_numbers(CLI::App& app, const std::string& names, std::vector<double>& target, const std::string& help);

/// A whole number from `least` to `most`.
void add_count(CLI::App& app, const std::string& names, std::optional<int>& target, int least, const std::string& help,
               int most = std::numeric_limits<int>::max());
void add_count(CLI::App& app, const std::string& names, int& target, int least, const std::string& help,
               int most = std::numeric_limits<int>::max());

/// A state as given by the user: numbers by position (no names), or by name.
struct StateText {
  std::vector<std::string> names;
  Vector values;
};

/// A state "0.5,-1.2" or "x=0.5,v=-1.2".
void add_state(CLI::App& app, const std::string& names, std::optional<StateText>& target, const std::string& help);
/// The same from a text. nullopt: neither form.
std::optional<StateText> parse_state(const std::string& text);

/// One of the given names.
void add_choice(CLI::App& app, const std::string& names, std::string& target, const std::vector<std::string>& choices,
                const std::string& help, Need need = Need::optional);

/// Options added from now on are listed under this heading in the help.
void begin_group(CLI::App& app, const std::string& heading);

/// The form that a text must have to be read as a state.
std::string state_form(const std::string& text);

}  // namespace graze::apps
