// SPDX-License-Identifier: GPL-3.0-or-later
// The random tester: its reference against the closed form, its checker against mutations of right answers, and the program
// against both. More cases and other seeds: the program random_cases (main.cpp), or these variables of the environment for the
// last two test cases: GRAZE_RANDOM_CASES, GRAZE_RANDOM_SKELETONS, GRAZE_RANDOM_SEED.
#include "one_impact.hpp"
#include "runner.hpp"

#include <catch2/catch.hpp>

#include <cstdlib>
#include <functional>
#include <sstream>

using namespace graze::reference;

namespace {

Family followed(const Case& one) { return follow(one.frame, one.start, one.range(), one.direction()); }

/// Complaints about the right answer after a mutation.
std::vector<Complaint> mutated(const Family& family, const std::function<bool(AnswerBranch&)>& mutate, bool& applied) {
  AnswerBranch branch = answer_of(family, 1);
  applied = mutate(branch);
  return compare(family, branch);
}

AnswerSpecial* first_of(AnswerBranch& branch, const std::string& type) {
  for (AnswerSpecial& special : branch.special_points)
    if (special.type == type) return &special;
  return nullptr;
}

/// Twelfth decimal of the first value, under an error bar that covers it. Ranges of parameters are up to 4 wide.
bool moved(AnswerBranch& branch, double by) {
  if (branch.special_points.empty()) return false;
  AnswerSpecial& special = branch.special_points.front();
  special.value += by * std::max(0.4, std::fabs(special.value));
  special.precision = 1e-10;
  special.interval = {special.value - special.precision, special.value + special.precision};
  return true;
}

std::string variable(const char* name, const std::string& otherwise) {
  const char* value = std::getenv(name);
  return value ? value : otherwise;
}

}  // namespace

TEST_CASE("the reference of the random tester agrees with the closed form of one-impact orbits") {
  int points = 0, doublings = 0;
  for (std::uint64_t k = 0; k < 60; ++k) {
    const Case one = random_case(7, k);
    if (one.frame.impacts() != 1) continue;
    const Family family = followed(one);
    INFO(arguments(one));
    REQUIRE(family.end != End::broken);
    for (const Sample& sample : family.samples) {
      const OneImpactForm<double> form = one_impact(one.frame.at(sample.y.back()), one.frame.periods);
      const double v = sample.y[1], amplitude = impactless_amplitude(form.q);
      // Size of the three terms, to which a relative error of the parameter and the speed applies.
      const double size = form.a() * v * v + std::fabs(form.h() * v) + form.q[R] * form.q[R] + amplitude * amplitude;
      CHECK(std::fabs(form.mismatch(v)) < 1e-9 * size);
    }
    for (const Located& point : family.points) {
      const Quad v = point.orbit[1];
      const OneImpactForm<Quad> form = one_impact(one.frame.at(point.value), one.frame.periods);
      const Quad expected = point.kind == Kind::LP   ? form.fold_speed()
                            : point.kind == Kind::PD ? form.flip_speed()
                            : point.gained           ? v
                                                     : Quad(0);
      CHECK(static_cast<double>(magnitude(v - expected)) < 1e-18 * (1.0 + static_cast<double>(magnitude(expected))));
      CHECK(static_cast<double>(magnitude(form.mismatch(v))) < 1e-20);
      CHECK(point.error < 1e-20);
      ++points;
      // Beyond a supercritical doubling the doubled orbits are stable: by their multipliers, which the verdict does not use.
      if (point.kind != Kind::PD || !point.supercritical) continue;
      const std::optional<Family> doubled = follow_doubled(family, point);
      if (!doubled) continue;
      const Table<double> M = monodromy(doubled->frame, doubled->samples.front().y);
      CHECK((characteristic(M, 1.0) > 0.0) == *point.supercritical);
      ++doublings;
    }
  }
  CHECK(points > 40);
  CHECK(doublings > 5);
}

TEST_CASE("the checker of the random tester finds nothing in right answers and every mutation of them") {
  const std::vector<std::pair<std::string, std::function<bool(AnswerBranch&)>>> mutations = {
      {"a point is removed",
       [](AnswerBranch& branch) {
         if (branch.special_points.empty()) return false;
         branch.special_points.erase(branch.special_points.begin());
         return true;
       }},
      {"a point is given twice",
       [](AnswerBranch& branch) {
         if (branch.special_points.empty()) return false;
         branch.special_points.push_back(branch.special_points.front());
         return true;
       }},
      {"a value is moved up by 3e-12", [](AnswerBranch& branch) { return moved(branch, 3.1e-12); }},
      {"a value is moved down by 3e-12", [](AnswerBranch& branch) { return moved(branch, -3.1e-12); }},
      {"an error bar is too small",
       [](AnswerBranch& branch) {
         if (branch.special_points.empty()) return false;
         AnswerSpecial& special = branch.special_points.front();
         special.value += 4e-15 * (1.0 + std::fabs(special.value));
         return true;
       }},
      {"a fold is called a doubling",
       [](AnswerBranch& branch) {
         AnswerSpecial* special = first_of(branch, "LP");
         if (special) special->type = "PD";
         return special != nullptr;
       }},
      {"a doubling is called a fold",
       [](AnswerBranch& branch) {
         AnswerSpecial* special = first_of(branch, "PD");
         if (special) special->type = "LP";
         return special != nullptr;
       }},
      {"the label has another number of impacts",
       [](AnswerBranch& branch) {
         if (branch.special_points.empty()) return false;
         ++branch.special_points.front().impacts;
         return true;
       }},
      {"lost and gained are exchanged",
       [](AnswerBranch& branch) {
         AnswerSpecial* special = first_of(branch, "GR");
         if (special) special->kind = special->kind == "lost" ? "gained" : "lost";
         return special != nullptr;
       }},
      {"impacts before and after a grazing are exchanged",
       [](AnswerBranch& branch) {
         AnswerSpecial* special = first_of(branch, "GR");
         if (special) std::swap(special->change[0], special->change[1]);
         return special != nullptr;
       }},
      {"the scenario is exchanged",
       [](AnswerBranch& branch) {
         AnswerSpecial* special = first_of(branch, "GR");
         if (!special || special->scenario.empty()) return false;
         special->scenario = special->scenario == "persistence" ? "nonsmooth-fold" : "persistence";
         return true;
       }},
      {"the criticality is exchanged",
       [](AnswerBranch& branch) {
         AnswerSpecial* special = first_of(branch, "PD");
         if (!special || special->criticality.empty()) return false;
         special->criticality = special->criticality == "supercritical" ? "subcritical" : "supercritical";
         return true;
       }},
      {"the branch is cut off, its reason kept",
       [](AnswerBranch& branch) {
         branch.points.resize(branch.points.size() / 3);
         return true;
       }},
      {"the branch is called closed halfway",
       [](AnswerBranch& branch) {
         if (branch.stop == "returned") return false;
         branch.points.resize(branch.points.size() / 2);
         branch.stop = "returned";
         branch.stop_value = branch.points.back().value;
         return true;
       }},
      {"a piece in the middle is missing",
       [](AnswerBranch& branch) {
         const std::ptrdiff_t count = static_cast<std::ptrdiff_t>(branch.points.size());
         if (count < 300) return false;  // of which half are further apart than neighbours may be
         branch.points.erase(branch.points.begin() + count / 4, branch.points.begin() + 3 * count / 4);
         return true;
       }},
      {"two points are exchanged",
       [](AnswerBranch& branch) {
         const std::size_t count = branch.points.size();
         std::swap(branch.points[7 * count / 10], branch.points[9 * count / 10]);
         return true;
       }},
      {"a point lies on another orbit",
       [](AnswerBranch& branch) {
         branch.points[9 * branch.points.size() / 10].states.front()[1] += 1e-3;
         return true;
       }},
      {"a grazing at the end is overrun",
       [](AnswerBranch& branch) {
         if (branch.stop != "grazing") return false;
         branch.special_points.pop_back();
         branch.stop = "reached_bound";
         return true;
       }},
  };
  std::vector<int> counts(mutations.size(), 0);
  for (std::uint64_t k = 0; k < 25; ++k) {
    const Case one = random_case(11, k);
    std::vector<Family> families = {followed(one)};
    REQUIRE(families[0].end != End::broken);
    for (const Located& point : families[0].points)
      if (point.kind == Kind::PD)
        if (const std::optional<Family> doubled = follow_doubled(families[0], point)) families.push_back(*doubled);
    for (const Family& family : families) {
      // Beyond the onset of sticking, or beyond its other doubling, the reference knows nothing of the branch.
      // In one that is hardly longer than a doubling's neighbourhood, points are not told apart.
      if (family.end == End::sticking || family.end == End::halved || family.samples.back().sigma < 0.2) continue;
      INFO(arguments(one) << " " << family.frame.impacts() << "/" << family.frame.periods);
      for (const Complaint& complaint : compare(family, answer_of(family, 1))) FAIL_CHECK(complaint.text);
      for (std::size_t m = 0; m < mutations.size(); ++m) {
        INFO(mutations[m].first);
        bool applied = false;
        const std::vector<Complaint> complaints = mutated(family, mutations[m].second, applied);
        if (!applied) continue;
        ++counts[m];
        CHECK_FALSE(complaints.empty());
      }
    }
  }
  for (std::size_t m = 0; m < mutations.size(); ++m) {
    INFO(mutations[m].first);
    CHECK(counts[m] > 0);
  }
}

TEST_CASE("the checker of the random tester finds a doubled branch that is none") {
  int doubled_families = 0;
  for (std::uint64_t k = 0; k < 120 && doubled_families < 5; ++k) {
    const Case one = random_case(13, k);
    const Family family = followed(one);
    Answer right;
    right.branches.push_back(answer_of(family, 1));
    for (std::size_t i = 0; i < family.points.size(); ++i) {
      if (family.points[i].kind != Kind::PD) continue;
      const std::optional<Family> doubled = follow_doubled(family, family.points[i]);
      if (!doubled || doubled->end == End::halved || doubled->samples.size() < 50) continue;
      AnswerBranch child = answer_of(*doubled, static_cast<int>(right.branches.size()) + 1);
      child.parent = 1;
      child.parent_label = right.branches[0].special_points[i].label;
      right.branches.push_back(child);
    }
    if (right.branches.size() != 2 || family.end != End::bound) continue;
    ++doubled_families;
    INFO(arguments(one));
    for (const Complaint& complaint : check(one, right).complaints) FAIL_CHECK(complaint.kind << ": " << complaint.text);
    Answer wrong = right;
    wrong.branches.pop_back();
    CHECK_FALSE(check(one, wrong).complaints.empty());
    wrong = right;
    for (AnswerPoint& point : wrong.branches[1].points) point.impacts += 1;
    CHECK_FALSE(check(one, wrong).complaints.empty());
    // The parent's own orbits, as if doubled.
    wrong = right;
    wrong.branches[1].points.clear();
    for (AnswerPoint point : right.branches[0].points) {
      const std::vector<State> once = point.states;
      point.states.insert(point.states.end(), once.begin(), once.end());
      point.impacts *= 2;
      wrong.branches[1].points.push_back(point);
    }
    CHECK_FALSE(check(one, wrong).complaints.empty());
    // It begins far from its doubling.
    wrong = right;
    const std::ptrdiff_t most = 4 * static_cast<std::ptrdiff_t>(wrong.branches[1].points.size()) / 5;
    wrong.branches[1].points.erase(wrong.branches[1].points.begin(), wrong.branches[1].points.begin() + most);
    for (AnswerSpecial& special : wrong.branches[1].special_points)
      special.after_point = std::max(0, special.after_point - static_cast<int>(most));
    CHECK_FALSE(check(one, wrong).complaints.empty());
  }
  CHECK(doubled_families == 5);
}

TEST_CASE("the checker of the random tester finds a family that is missing in a skeleton") {
  for (std::uint64_t k = 0; k < 3; ++k) {
    const SkeletonCase one = random_skeleton(17, k);
    Answer right;
    std::vector<std::size_t> first;
    for (const Family& family : one_impact_families(one.frame, one.range, one.most_periods)) {
      if (family.samples.back().sigma > 0.5) first.push_back(right.branches.size());
      std::size_t middle = 0;
      while (family.samples[middle].sigma < 0.5 * family.samples.back().sigma) ++middle;
      const Values<double>& start = family.samples[middle].y;
      for (const int direction : {-1, 1}) {
        const Family half = follow(family.frame, start, one.range, direction);
        if (half.samples.size() > 3) right.branches.push_back(answer_of(half, static_cast<int>(right.branches.size()) + 1));
        if (half.end == End::closed) break;
      }
    }
    INFO(arguments(one));
    for (const Complaint& complaint : check_skeleton(one, right).complaints)
      if (complaint.kind != "family twice") FAIL_CHECK(complaint.kind << ": " << complaint.text);
    for (const std::size_t i : first) {
      Answer wrong = right;
      wrong.branches.erase(wrong.branches.begin() + static_cast<std::ptrdiff_t>(i));
      CHECK_FALSE(check_skeleton(one, wrong).complaints.empty());
    }
  }
}

TEST_CASE("continuation of random orbits agrees with closed forms and shooting in extended precision") {
  Plan plan;
  plan.program = GRAZE_PROGRAM;
  plan.data = GRAZE_DATA_DIR "/problems";
  plan.cases = std::stoull(variable("GRAZE_RANDOM_CASES", "300"));
  plan.seed = std::stoull(variable("GRAZE_RANDOM_SEED", "1"));
  plan.most_impacts = 6;
  std::ostringstream lines;
  const Summary summary = run(plan, lines);
  INFO(lines.str());
  CHECK(summary.cases == plan.cases);
  CHECK(summary.undecided * 50 <= summary.cases);
  CHECK(summary.failed == 0);
}

TEST_CASE("skeletons of random ranges contain every family of one-impact orbits") {
  Plan plan;
  plan.program = GRAZE_PROGRAM;
  plan.data = GRAZE_DATA_DIR "/problems";
  plan.skeletons = true;
  plan.cases = std::stoull(variable("GRAZE_RANDOM_SKELETONS", "6"));
  plan.seed = std::stoull(variable("GRAZE_RANDOM_SEED", "1"));
  plan.most_impacts = 6;
  plan.patience = 300.0;
  std::ostringstream lines;
  const Summary summary = run(plan, lines);
  INFO(lines.str());
  CHECK(summary.cases == plan.cases);
  CHECK(summary.failed == 0);
}
