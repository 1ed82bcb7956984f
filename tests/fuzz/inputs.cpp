// SPDX-License-Identifier: GPL-3.0-or-later
#include "inputs.hpp"

#include <graze/apps/drawing/picture.hpp>
#include <graze/apps/map/map_chunk.hpp>
#include <graze/apps/map/map_message.hpp>
#include <graze/apps/map/map_plan.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/written_result.hpp>
#include <graze/apps/problem/problem.hpp>
#include <graze/apps/program/program.hpp>
#include <graze/apps/results/input_file.hpp>

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>
#include <stdexcept>

namespace graze::fuzz {

namespace {

namespace fs = std::filesystem;
using namespace apps;
using Arguments = std::vector<std::string>;

std::string read(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string problem(const std::string& name) { return fmt::format("{}/problems/{}.toml", GRAZE_DATA_DIR, name); }
std::string model(const std::string& name) { return fmt::format("{}/models/{}.toml", GRAZE_DATA_DIR, name); }

struct Said {
  int code = 0;
  std::string out, err;
};

Said run(Arguments arguments) {
  arguments.insert(arguments.end(), {"--quiet", "--threads", "1"});
  std::ostringstream out, err;
  const int code = run_program(arguments, out, err);
  return {code, out.str(), err.str()};
}

/// The output of a command, which must not be empty.
std::string written(Arguments arguments, const char* option = "--json") {
  arguments.insert(arguments.end(), {option, "-"});
  Said said = run(arguments);
  if (said.out.empty()) throw std::runtime_error("no seed could be made: " + said.err);
  return std::move(said.out);
}

const Arguments words_of_systems = {"[system]",
                                    "[parameters]",
                                    "[definitions]",
                                    "[modes.free]",
                                    "[[events]]",
                                    "[mechanics]",
                                    "[[stops]]",
                                    "[[friction]]",
                                    "[[surfaces]]",
                                    "[outputs]",
                                    "[units]",
                                    "[start]",
                                    "[tables.a]",
                                    "states",
                                    "forcing",
                                    "period",
                                    "equations",
                                    "when",
                                    "reset",
                                    "kind",
                                    "from",
                                    "to",
                                    "count",
                                    "coordinates",
                                    "velocities",
                                    "mass",
                                    "damping",
                                    "stiffness",
                                    "force",
                                    "gap",
                                    "law",
                                    "newton",
                                    "hertz",
                                    "linear",
                                    "speed",
                                    "normal",
                                    "sticking",
                                    "sliding",
                                    "below",
                                    "above",
                                    "impact",
                                    "entry",
                                    "exit",
                                    "switch",
                                    "sin(",
                                    "cos(",
                                    "abs(",
                                    "sign(",
                                    "min(",
                                    "max(",
                                    "sqrt(",
                                    "exp(",
                                    "log(",
                                    "atan2(",
                                    "if",
                                    "pi",
                                    "t",
                                    "x",
                                    "v",
                                    "x'",
                                    "v'",
                                    "=",
                                    "==",
                                    "<",
                                    ">=",
                                    "^",
                                    "^-1",
                                    "^0.5",
                                    "*",
                                    "/",
                                    "+",
                                    "-",
                                    "(",
                                    ")",
                                    ",",
                                    "\"\"\"",
                                    "\"",
                                    "1e400",
                                    "0/0",
                                    "{",
                                    "}",
                                    "[",
                                    "]",
                                    "true"};

Kind problems() {
  Kind kind{"problem", Form::text, 1, words_of_systems, {}, {}, {}};
  kind.seeds = [] {
    std::vector<std::string> list;
    for (const char* folder : {GRAZE_DATA_DIR "/problems", GRAZE_DATA_DIR "/models", GRAZE_SOURCE_DIR "/tests/models",
                               GRAZE_SOURCE_DIR "/tests/random/systems"})
      for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        if (entry.path().extension() == ".toml") list.push_back(read(entry.path()));
    return list;
  };
  kind.take = [](const std::string& text) {
    const Problem read = parse_problem(text, "fuzz.toml");
    start_state(read, std::nullopt);
    describe(read);
  };
  return kind;
}

/// A real diagram takes a second. This file has the options below and fewer points.
std::string diagram() { return read(GRAZE_FUZZ_SEEDS "/diagram.json"); }
Arguments diagram_arguments() {
  return {"diagram",        problem("newton-elastic"),
          "--from",         "0.745",
          "--to",           "0.746",
          "--step",         "0.001",
          "--max-period",   "2",
          "--multiples",    "1",
          "--max-branches", "1",
          "--periods",      "100"};
}

/// Short results of each other command that has pictures.
std::vector<Arguments> results() {
  const std::string newton = problem("newton-elastic"), duffing = model("duffing-two-stops");
  return {{"orbit", newton, "--set", "eta=0.9", "--settle", "200", "--y", "max(x)"},
          {"orbit", duffing, "--settle", "100"},
          {"continue", newton, "--set", "eta=0.9", "--settle", "200", "--to", "0.905", "--y", "max(x)"},
          {"sweep", newton, "--from", "0.7", "--to", "0.72", "--step", "0.01", "--settle", "200", "--y", "max(x)"},
          {"attractors", newton, "--set", "eta=0.9", "--x=-1:1:3", "--v=-1:1:2", "--transient", "50", "--periods", "200"},
          {"attractors", newton, "--random", "4", "--x=-1:1", "--v=-1:1", "--transient", "50", "--periods", "200"},
          {"trajectory", newton, "--periods", "2", "--samples", "8", "--y", "x+v"},
          {"poincare", newton, "--points", "8"},
          {"map", newton, "--param", "eta:0.8:0.9:3", "--param", "r:1:2:2", "--y", "max(x)", "--follow", "both"},
          {"verify", newton, "--set", "eta=0.9", "--settle", "200", "--average", "0"},
          {"verify", problem("hertz-damped"), "--set", "eta=0.9", "--settle", "200", "--average", "0", "--hard-limit"},
          {"locate", newton, "--type", "GR", "--near", "0.74"}};
}

Kind plotted() {
  Kind kind{"result", Form::json, 10, {"null", "true", "[]", "{}", "[[]]", "\"\"", "-1", "graze.map/1"}, {}, {}, {}};
  kind.seeds = [] {
    std::vector<std::string> list;
    for (const Arguments& arguments : results()) list.push_back(written(arguments));
    list.push_back(diagram());
    return list;
  };
  kind.take = [](const std::string& text) {
    // The placement of words in pictures takes longer than all the rest, and is therefore tested in some of them only.
    const std::uint64_t sum = checksum(text);
    const auto draw_some = [&](const ResultView& view, std::uint64_t one_of) {
      const Picture picture = picture_of_text(text, "fuzz.json", view);
      if (sum % one_of == 0) gnuplot_script(picture, "svg");
    };
    draw_some({}, 3);
    const std::vector<std::string> names = picture_names(schema_of(parse_json(text)));
    const std::string name = names.at(sum % names.size());
    draw_some({.kind = name}, 5);
    draw_some(sum % 2 == 0 ? ResultView{.plane = "v,x"} : ResultView{.kind = name, .y = {"max(x)"}}, 7);
  };
  return kind;
}

Kind tables() {
  Kind kind{"table", Form::text, 2, {",", "\"", "\"\"", "\r\n", "x", "v", "type", "period", "stable", "attractor"}, {}, {}, {}};
  kind.seeds = [] {
    std::vector<std::string> list;
    for (const Arguments& arguments : results()) list.push_back(written(arguments, "--csv"));
    return list;
  };
  kind.take = [](const std::string& text) {
    gnuplot_script(picture_of_text(text, "fuzz.csv"), "svg");
    gnuplot_script(picture_of_text(text, "fuzz.csv", {.x = "x", .y = {"v", "x"}}), "svg");
  };
  return kind;
}

/// A map of 3 times 5 points, two rows in a chunk.
const MapPlan& small_map() {
  static const MapPlan plan = [] {
    MapPlan made;
    made.problem = load_problem(problem("newton-elastic"));
    made.grid = {{"eta", 0.8, 0.9, 3}, {"r", 1.0, 2.0, 5}};
    set_quantities(made, {"max(x)"});
    made.chunk_rows = 2;
    return made;
  }();
  return plan;
}

constexpr std::uint64_t fingerprint = 0x1234;

std::string chunk_of(int number) {
  const MapPlan& plan = small_map();
  MapChunk chunk{plan.first_row(number), plan.rows_of(number), {}};
  for (int i = 0; i < chunk.rows * plan.grid.columns.count; ++i) {
    MapPoint point;
    point.type = i == 1 ? MapType::chaotic : MapType::periodic;
    point.period = point.impacts = i;
    point.state = Vector{{0.1 * i, -1.0}};
    point.quantities = Vector{{1.0}};
    chunk.points.push_back(point);
  }
  return chunk_bytes(chunk, plan, fingerprint);
}

Kind chunks() {
  Kind kind{"chunk", Form::bytes, 1, {}, {}, {}, {}};
  kind.seeds = [] { return std::vector<std::string>{chunk_of(0), chunk_of(1), chunk_of(2)}; };
  kind.take = [](const std::string& bytes) {
    for (const int number : {-1, 0, 2, 3}) {
      const auto chunk = chunk_from(bytes, small_map(), fingerprint, number);
      if (!chunk) continue;
      // Accepted bytes must be written back identically.
      if (chunk_bytes(*chunk, small_map(), fingerprint) != bytes) throw std::runtime_error("a chunk has other bytes than it had");
      for (const MapPoint& point : chunk->points) map_type_name(point.type);
    }
  };
  kind.mend = [](std::string& bytes, Dice& dice) {
    if (bytes.size() < sizeof(std::uint64_t) || dice.one_in(4)) return;
    const std::uint64_t sum = checksum(std::string_view(bytes).substr(0, bytes.size() - sizeof(std::uint64_t)));
    std::memcpy(bytes.data() + bytes.size() - sizeof sum, &sum, sizeof sum);
  };
  return kind;
}

Kind messages() {
  Kind kind{"message", Form::text, 1, {"C", "D", "N", "E", "W", "H", "F", "B", "P", "+1", "-1", "00000001"}, {}, {}, {}};
  kind.seeds = [] {
    const std::string plan = flat(map_head(small_map(), {}));
    return std::vector<std::string>{
        map_message('C', 1), map_message('D', 2, chunk_of(2)), map_message('P', plan), "N", "E", "W", "H", "B",
        "Fended by a signal"};
  };
  kind.take = [](const std::string& text) {
    const auto message = message_from(text);
    if (!message) return;
    const std::string again = message->number < 0 ? map_message(message->letter, message->rest)
                                                  : map_message(message->letter, message->number, message->rest);
    if (again != text) throw std::runtime_error("a message reads otherwise than it is written");
    if (message->letter == 'D') chunk_from(message->rest, small_map(), fingerprint, message->number);
    if (message->letter == 'P') plan_of(parse_json(std::string(message->rest)));
  };
  return kind;
}

/// A temporary folder.
struct Folder {
  fs::path path;
  Folder() {
    std::string name = (fs::temp_directory_path() / "graze-fuzz-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw std::runtime_error("no temporary folder can be made");
    path = name;
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code error;
    fs::remove_all(path, error);
  }
};

constexpr const char* published = R"([[system]]
id = "newton-elastic"
contact = "newton"
parameters = { b = 0.05, r = 2.0, k_r = 1.0, xi = 1.0, beta = 0.0 }

[[diagram]]
system = "newton-elastic"
figure = "10"
eta = [0.9, 0.91]
step = 0.005
windows = [ { eta = [0.9, 0.91], direction = "both", attractor = "periodic", z = [1, 1] } ]
)";

/// A command that resumes a result. It computes the missing parts of the damaged result, so that the run must be short.
Kind resumed(std::size_t cost, Arguments arguments) {
  const std::string command = arguments.front();
  Kind kind{"resume-" + command, Form::json, cost, {"null", "[]", "{}", "-1", "interrupted", "done"}, {}, {}, {}};
  const auto folder = std::make_shared<Folder>();
  if (command == "reproduce") {
    std::ofstream(folder->path / "few.toml") << published;
    arguments.insert(arguments.begin() + 1, (folder->path / "few.toml").string());
  }
  kind.seeds = [arguments, command] { return std::vector<std::string>{command == "diagram" ? diagram() : written(arguments)}; };
  kind.take = [arguments, folder, command](const std::string& text) {
    const fs::path file = folder->path / (command + ".json");
    std::ofstream(file, std::ios::binary) << text;
    Arguments all = arguments;
    all.insert(all.end(), {"--resume", folder->path.string()});
    const Said said = run(all);
    // gnuplot is missing here, and the note about it comes first.
    std::string message = said.err;
    if (const std::size_t at = message.find("graze " + command + ": "); at != std::string::npos)
      message.erase(0, at + command.size() + 8);
    if (said.code == 2) {
      while (message.ends_with('\n')) message.pop_back();
      throw std::invalid_argument(message);
    }
    // Other terminations come with a result.
    if (read(file) == text && said.code != 0) throw std::runtime_error(message);
  };
  return kind;
}

}  // namespace

std::vector<Kind> kinds() {
  const std::string newton = problem("newton-elastic");
  const Arguments sweep = {"sweep", newton,     "--from", "0.9",         "--to", "0.91",      "--step",
                           "0.005", "--settle", "100",    "--direction", "both", "--periods", "100"};
  const Arguments attractors = {"attractors", newton,        "--set", "eta=0.744", "--x=-1:1:2",
                                "--v=-1:1:2", "--transient", "60",    "--periods", "100"};
  return {problems(),
          plotted(),
          tables(),
          chunks(),
          messages(),
          resumed(20, sweep),
          resumed(20, attractors),
          resumed(100, diagram_arguments()),
          resumed(100, {"reproduce", "--no-claims"})};
}

}  // namespace graze::fuzz
