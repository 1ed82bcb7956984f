// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/map/ranks.hpp>
#include <graze/apps/program/program.hpp>
#include <graze/apps/text/json.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/apps/text/version.hpp>

#include <graze/lib/system/parameters.hpp>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <iostream>
#include <map>
#include <new>
#include <optional>
#include <thread>

namespace graze::apps {

namespace {

struct Global {
  bool quiet = false;
  int threads = 0;
  std::optional<double> time;
};

/// Adds the options of every command; they may also stand before the command's name.
void add_global_options(CLI::App& app, Global& global, const std::string& version) {
  begin_group(app, "General");
  app.get_help_ptr()->group("General");
  app.set_version_flag("--version", version, "the program's version")->group("General");
  add_flag(app, "--quiet", global.quiet, "no progress and no notes on stderr");
  add_count(app, "--threads", global.threads, 0, "threads, where a command can use several (default 0: all)");
  add_number(app, "--time", global.time,
             "time limit in seconds; the partial result is kept, as after Ctrl-C (exit code 1 if it is incomplete)");
}

/// CLI11 reads "--start -0.1,2" as two options; joined by "=" it is one option with a negative value.
std::vector<std::string> join_negative_values(const std::vector<std::string>& arguments) {
  std::vector<std::string> out;
  for (const std::string& argument : arguments) {
    const bool negative =
        argument.size() > 1 && argument[0] == '-' &&
        (std::isdigit(static_cast<unsigned char>(argument[1])) || argument[1] == '.' || argument.starts_with("-pi"));
    const bool after_option = !out.empty() && out.back().starts_with("--") && out.back().find('=') == std::string::npos;
    if (negative && after_option)
      out.back() += "=" + argument;
    else
      out.push_back(argument);
  }
  return out;
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

/// Advice such as "; give --to VALUE: last value of the parameter".
std::string advice_on(const CLI::App& app, const std::string& name) {
  const CLI::Option* option = app.get_option_no_throw(name);
  if (!option) return "";
  const std::string given = name.starts_with("-") ? name + " " + option->get_type_name() : "a " + option->get_type_name();
  return fmt::format("; give {}: {}", given, option->get_description());
}

/// One sentence on an error found by CLI11.
std::string sentence(const CLI::App& app, const CLI::App& used, const CLI::ParseError& error) {
  const bool command_given = &used != &app;
  const std::string help = fmt::format("`graze {}--help` lists all", command_given ? used.get_name() + " " : "");
  if (dynamic_cast<const CLI::ExtrasError*>(&error)) {
    std::vector<std::string> extra = command_given ? used.remaining() : app.remaining();
    if (extra.empty()) extra = app.remaining(true);
    const std::string argument = extra.empty() ? "" : extra.front();
    const std::string given = argument.substr(0, argument.starts_with("-") ? argument.find('=') : std::string::npos);
    if (given.starts_with("-")) {
      const std::string nearest = nearest_name(given, option_names(used));
      return fmt::format("there is no option {}{}; {}", given, nearest.empty() ? "" : fmt::format(" (did you mean {}?)", nearest),
                         help);
    }
    if (command_given && given.find('=') != std::string::npos && used.get_option_no_throw("--set"))
      return fmt::format("\"{}\" is one argument too many; a setting stands behind a --set of its own: --set {}", given, given);
    if (command_given) return fmt::format("\"{}\" is one argument too many; {}", given, help);
    std::vector<std::string> names;
    for (const Command& command : commands()) names.push_back(command.name);
    return unknown_name("command", given, names);
  }
  std::string text = error.what();
  if (dynamic_cast<const CLI::RequiredError*>(&error)) return text + advice_on(used, text.substr(0, text.find(' ')));
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error)) {
    const std::string option = text.substr(0, text.find(':'));
    const std::size_t received = text.find("but received ");  // "--period: At Most 1 required but received 2"
    if (received != std::string::npos)
      return fmt::format("{} is given {} times; give it once", option, text.substr(received + 13));
    if (text.find("missing") != std::string::npos) return option + " lacks its value" + advice_on(used, option);
  }
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::string footer(const Command& command) {
  std::string text = command.details + (command.examples.size() > 1 ? "\n\nExamples:" : "\n\nExample:");
  for (const std::string& example : command.examples) text += "\n  " + example;
  return text;
}

}  // namespace

int run_program(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err) {
  CLI::App app("Periodic orbits of vibro-impact oscillators: found, followed, and their stability measured.", "graze");
  const std::string version = std::string("graze ") + program_version;
  app.get_formatter()->column_width(32);
  Global global;
  add_global_options(app, global, version);
  app.require_subcommand(0, 1);
  app.footer("graze COMMAND --help says everything about a command, with an example.\n"
             "Exit codes: 0 done, 1 a numerical stop or the end of --time, 2 misuse or an output that cannot be written, 130 "
             "interrupted.");
  std::map<const CLI::App*, std::function<int(const Console&)>> runs;
  for (const Command& command : commands()) {
    CLI::App* subcommand = app.add_subcommand(command.name, command.summary);
    runs[subcommand] = command.setup(*subcommand);
    add_global_options(*subcommand, global, version);
    subcommand->footer(footer(command));
  }

  const auto used = [&]() -> const CLI::App& {
    const std::vector<CLI::App*> chosen = app.get_subcommands();
    return chosen.empty() ? app : *chosen.front();
  };
  std::string name = "graze";
  try {
    std::vector<std::string> reversed = join_negative_values(arguments);
    std::reverse(reversed.begin(), reversed.end());
    app.parse(reversed);
    if (&used() == &app) {
      err << app.help();
      return 2;
    }
    name += " " + used().get_name();
    if (global.time && !(*global.time > 0.0))
      throw std::invalid_argument(fmt::format("--time is {}; allowed is > 0, in seconds", exact(*global.time)));
    const TimeBudget budget(global.time);
    if (!global.quiet && !std::all_of(arguments.begin(), arguments.end(), is_utf8))
      err << "graze: a name on the command line is not UTF-8; results have U+FFFD in place of its invalid bytes\n";
    // The limit also holds for code that does not choose its own number of threads.
    std::optional<oneapi::tbb::global_control> limit;
    if (global.threads > 0)
      limit.emplace(oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(global.threads));
    return runs.at(&used())({out, err, global.quiet, global.threads});
  } catch (const CLI::Success& request) {  // --help, --version
    errno = 0;
    const int code = app.exit(request, out, err);
    if (out.flush()) return code;
    err << name << ": " << cannot_write_stdout(errno) << "\n";
    return 2;
  } catch (const CLI::ParseError& error) {
    if (&used() != &app) name += " " + used().get_name();
    err << name << ": " << sentence(app, used(), error) << "\n";
    return 2;
  } catch (const std::invalid_argument& error) {
    err << name << ": " << error.what() << "\n";
    return 2;
  } catch (const Interrupted& error) {
    err << name << ": " << error.what() << "\n";
    return 130;
  } catch (const std::bad_alloc&) {
    err << name << ": out of memory\n";
    return 1;
  } catch (const std::exception& error) {
    err << name << ": " << error.what() << "\n";
    return 1;
  }
}

namespace {

/// Discards all output.
class NullBuffer : public std::streambuf {
  int overflow(int character) override { return character; }
  std::streamsize xsputn(const char*, std::streamsize size) override { return size; }
};

}  // namespace

int run_main(int argc, char** argv, const Additions& additions) {
  watch_interrupts();
  try {
    for (const Command& command : additions.commands) add_command(command);
    for (const PictureKind& kind : additions.pictures) add_picture_kind(kind);
  } catch (const std::invalid_argument& error) {
    std::cerr << "graze: " << error.what() << "\n";
    return 2;
  }
  const std::vector<std::string> arguments(argv + (argc > 0 ? 1 : 0), argv + argc);
  if (!is_helper()) return run_program(arguments, std::cout, std::cerr);
  // Of several processes under mpirun, only one prints.
  NullBuffer nowhere;
  std::ostream silent(&nowhere);
  const int code = run_program(arguments, silent, silent);
  // A failure here also stops the rank that prints. The launcher would then end that rank because of this one's exit code: give
  // it time to print first.
  if (code != 0) std::this_thread::sleep_for(std::chrono::seconds(2));
  return code;
}

}  // namespace graze::apps
