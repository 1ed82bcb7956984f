// SPDX-License-Identifier: GPL-3.0-or-later
#include "runner.hpp"

#include <sys/wait.h>

#include <chrono>
#include <cstdio>
#include <ostream>
#include <set>
#include <stdexcept>

namespace graze::reference {

namespace {

std::string problem(const Plan& plan) {
  return (plan.model == Model::barrier ? plan.data : plan.systems) + "/" +
         std::string(model_names[static_cast<std::size_t>(plan.model)]) + ".toml";
}

}  // namespace

Answer answered(const Plan& plan, const std::string& command, const std::string& arguments) {
  const std::string line = "timeout " + std::to_string(plan.patience) + " '" + plan.program + "' " + command + " '" +
                           problem(plan) + "'" + arguments + " --quiet --threads 1" +
                           (plan.limit > 0.0 ? " --time " + std::to_string(plan.limit) : "") +
                           " --json - 2> /dev/null < /dev/null";
  Answer out;
  std::FILE* pipe = ::popen(line.c_str(), "r");
  if (!pipe) {
    out.failure = "the program cannot be started";
    return out;
  }
  std::string text;
  std::array<char, 65536> piece;
  for (std::size_t size = 0; (size = std::fread(piece.data(), 1, piece.size(), pipe)) > 0;) text.append(piece.data(), size);
  const int state = ::pclose(pipe), code = WIFEXITED(state) ? WEXITSTATUS(state) : -1;
  if (code == 124) {
    out.failure = "nothing within " + std::to_string(plan.patience) + " s";
  } else if (code == 2) {
    throw std::runtime_error("misuse, exit code 2: " + line);
  } else {
    // 1: a numerical stop; the partial result is checked.
    out = parse_answer(text);
    if (!out.failure.empty()) out.failure += ", exit code " + std::to_string(code);
  }
  return out;
}

Summary run(const Plan& plan, std::ostream& out) {
  Summary summary;
  const auto start = std::chrono::steady_clock::now();
  for (std::uint64_t k = plan.first; k < plan.first + plan.cases; ++k) {
    if (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > plan.time) break;
    std::string command = "continue", what;
    std::size_t name = ETA;
    Verdict verdict;
    if (plan.skeletons) {
      const SkeletonCase one = random_skeleton(plan.seed, k, plan.name);
      command = "diagram";
      what = arguments(one);
      name = one.frame.name;
      verdict = check_skeleton(one, answered(plan, command, what), plan.most_impacts);
    } else {
      const Case one = random_case(plan.seed, k, plan.name, plan.model);
      what = arguments(one);
      name = one.frame.name;
      verdict = check(one, answered(plan, command, what), plan.most_impacts);
    }
    ++summary.cases;
    summary.families += static_cast<std::uint64_t>(verdict.families);
    summary.unresolved += static_cast<std::uint64_t>(verdict.unresolved);
    if (verdict.undecided) ++summary.undecided;
    if (verdict.complaints.empty()) continue;
    ++summary.failed;
    std::set<std::string> kinds;
    out << "case " << plan.seed << ":" << k << " (" << parameter_names(plan.model)[name] << ")";
    for (const Complaint& complaint : verdict.complaints) {
      out << (&complaint == verdict.complaints.data() ? " " : "; ") << complaint.kind << ": " << complaint.text;
      kinds.insert(complaint.kind);
    }
    for (const std::string& kind : kinds) ++summary.kinds[kind];
    out << " | graze " << command << " " << problem(plan) << what << std::endl;
  }
  return summary;
}

}  // namespace graze::reference
