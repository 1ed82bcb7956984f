// SPDX-License-Identifier: GPL-3.0-or-later
// The random tester: its reference against the closed form, its checker against mutations of correct answers, and the program
// against both. More cases and other seeds: the program random_cases (main.cpp). For the last three test cases also the
// environment variables GRAZE_RANDOM_CASES, GRAZE_RANDOM_SKELETONS, GRAZE_RANDOM_SYSTEM_CASES, GRAZE_RANDOM_SEED.
#include "one_impact.hpp"
#include "runner.hpp"

#include <catch2/catch.hpp>

#include <cstdlib>
#include <functional>
#include <sstream>

using namespace graze::reference;

namespace {

Family followed(const Case& one) { return follow(one.frame, one.start, one.range(), one.direction()); }

/// Complaints about the correct answer after a mutation.
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

/// Changes the type of the first point of a type.
std::function<bool(AnswerBranch&)> called(const std::string& type, const std::string& other) {
  return [=](AnswerBranch& branch) {
    AnswerSpecial* special = first_of(branch, type);
    if (special) special->type = other;
    return special != nullptr;
  };
}

/// Moves the twelfth decimal of the first value, within an error bar that covers it. Ranges of parameters are up to 4 wide.
bool moved(AnswerBranch& branch, double by) {
  if (branch.special_points.empty()) return false;
  AnswerSpecial& special = branch.special_points.front();
  special.value += by * std::max(0.4, std::fabs(special.value));
  special.precision = 1e-10;
  special.interval = {special.value - special.precision, special.value + special.precision};
  return true;
}

const std::vector<std::pair<std::string, std::function<bool(AnswerBranch&)>>>& mutations() {
  static const std::vector<std::pair<std::string, std::function<bool(AnswerBranch&)>>> all = {
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
      {"a fold is called a doubling", called("LP", "PD")},
      {"a doubling is called a fold", called("PD", "LP")},
      {"a broken symmetry is called a fold", called("BP", "LP")},
      {"a Neimark-Sacker point is called a doubling", called("NS", "PD")},
      {"a multiplier is wrong",
       [](AnswerBranch& branch) {
         AnswerPoint& point = branch.points[branch.points.size() / 2];
         if (point.multipliers.empty()) return false;
         point.multipliers.front() += 1e-3 * (1.0 + std::abs(point.multipliers.front()));
         return true;
       }},
      {"stable and unstable are exchanged",
       [](AnswerBranch& branch) {
         AnswerPoint& point = branch.points[branch.points.size() / 2];
         if (!point.stable) return false;
         point.stable = !*point.stable;
         return true;
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
         if (count < 300) return false;  // half of them are then farther apart than allowed for neighbours
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
  return all;
}

/// Complaints about the correct answers of the families of random cases, and about every mutation of them. Returns how often
/// each mutation applies.
std::vector<int> mutate_all(Model model, std::uint64_t seed, std::uint64_t cases) {
  std::vector<int> counts(mutations().size(), 0);
  for (std::uint64_t k = 0; k < cases; ++k) {
    const Case one = random_case(seed, k, std::nullopt, model);
    std::vector<Family> families = {followed(one)};
    REQUIRE(families[0].end != End::broken);
    for (const Located& point : families[0].points)
      if (point.kind == Kind::PD || point.kind == Kind::BP)
        if (const std::optional<Family> doubled = follow_doubled(families[0], point)) families.push_back(*doubled);
    for (const Family& family : families) {
      // The reference has no orbits beyond the onset of sticking, or beyond another doubling. On a family hardly longer than
      // the neighbourhood of a doubling, points are not distinguished.
      if (family.end == End::sticking || family.end == End::halved || family.samples.back().sigma < 0.2) continue;
      INFO(arguments(one) << " " << family.frame.impacts() << "/" << family.frame.periods);
      for (const Complaint& complaint : compare(family, answer_of(family, 1))) FAIL_CHECK(complaint.text);
      for (std::size_t m = 0; m < mutations().size(); ++m) {
        INFO(mutations()[m].first);
        bool applied = false;
        const std::vector<Complaint> complaints = mutated(family, mutations()[m].second, applied);
        if (!applied) continue;
        ++counts[m];
        CHECK_FALSE(complaints.empty());
      }
    }
  }
  return counts;
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
      // Size of the three terms: a relative error of the parameter and the speed refers to it.
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
      // Beyond a supercritical doubling the doubled orbits are stable. Their multipliers confirm it; the verdict does not use
      // them.
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

TEST_CASE("the checker of the random tester accepts correct answers and rejects every mutation of them") {
  const std::vector<int> counts = mutate_all(Model::barrier, 11, 25);
  for (std::size_t m = 0; m < counts.size(); ++m) {
    INFO(mutations()[m].first);
    // Mutations of other models, and those of numbers that a correct answer here does not have.
    const std::string& of = mutations()[m].first;
    CHECK((counts[m] > 0) == (of.find("symmetry") == std::string::npos && of.find("Sacker") == std::string::npos));
  }
}

TEST_CASE("the checker of the random tester rejects every mutation of correct answers about two stops and two masses") {
  struct Some {
    Model model;
    std::uint64_t seed, cases;
  };
  std::vector<int> counts(mutations().size(), 0);
  // The last one has a Neimark-Sacker point.
  for (const Some& some : {Some{Model::equal_stops, 11, 12}, Some{Model::two_stops, 11, 6}, Some{Model::chain_first, 11, 3},
                           Some{Model::chain_second, 2, 1}}) {
    const std::vector<int> more = mutate_all(some.model, some.seed, some.cases);
    for (std::size_t m = 0; m < counts.size(); ++m) counts[m] += more[m];
  }
  for (std::size_t m = 0; m < counts.size(); ++m) {
    INFO(mutations()[m].first);
    CHECK(counts[m] > 0);
  }
}

TEST_CASE("the exponential of two masses agrees with their modes for proportional damping") {
  // C = 2 b K: each mode has frequency w and damping b w^2. With M^-1/2 K M^-1/2 = [a, f; f, d] its directions form a
  // rotation.
  for (std::uint64_t k = 0; k < 20; ++k) {
    const double part = static_cast<double>(k) / 20.0;
    Parameters<Quad> q{};
    q[ETA] = Quad(1);
    q[B] = Quad(0.01 + 0.15 * part);
    q[MASS] = Quad(0.2 + 1.7 * part);
    q[K] = Quad(3.0 - 2.7 * part);
    q[C] = Quad(2) * q[B] * q[K];
    const Linear<Quad> system = linear(Model::chain_first, q);
    const Quad a = Quad(1) + q[K], m = root(q[MASS]), f = -q[K] / m, d = q[K] / q[MASS];
    const Quad turn = arctangent(Quad(2) * f, a - d) / Quad(2), c = cosine(turn), s = sine(turn);
    const std::array<std::array<Quad, 2>, 2> modes = {{{c, s}, {-s, c}}};  // of M^1/2 q
    const Quad time = Quad(0.3) * Quad(static_cast<double>(k) + 1.0);
    Square<Quad> expected{};
    for (const auto& mode : modes) {
      const Quad square = a * mode[0] * mode[0] + Quad(2) * f * mode[0] * mode[1] + d * mode[1] * mode[1];
      // Like one mass with b w, in the time w t.
      const Quad w = root(square);
      Parameters<Quad> single{};
      single[B] = q[B] * w;
      const Transition<Quad> over = transition(single, w * time);
      const std::array<std::array<Quad, 2>, 2> block = {{{over.xx, over.xv / w}, {over.vx * w, over.vv}}};
      const std::array<Quad, 2> to = {mode[0], mode[1] / m}, from = {mode[0], mode[1] * m};
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j) expected[i][j] += to[i % 2] * block[i / 2][j / 2] * from[j % 2];
    }
    const Square<Quad> found = transition(system, time);
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j) CHECK(static_cast<double>(magnitude(found[i][j] - expected[i][j])) < 1e-28);
  }
}

TEST_CASE("one impact in each turn of two stops and two masses agrees with its closed form") {
  int folds = 0, breakings = 0;
  for (const Model model : {Model::equal_stops, Model::chain_first, Model::chain_second, Model::chain_between})
    for (std::uint64_t k = 0; k < 20; ++k) {
      const Case one = random_case(29, k, std::nullopt, model);
      if (one.frame.legs() != 1) continue;
      const Family family = followed(one);
      INFO(arguments(one));
      REQUIRE(family.end != End::broken);
      for (std::size_t i = 0; i < family.samples.size(); i += 10) {
        const Values<double>& y = family.samples[i].y;
        const SingleImpact<double> form = single_impact(one.frame, y.back());
        const double amplitude = impactless_amplitude(form.system, form.stop), x = std::fabs(form.alpha * y[1]);
        CHECK(std::fabs(form.mismatch(y[1])) < 1e-9 * (amplitude * amplitude + x * x + form.stop.wall * form.stop.wall));
      }
      for (const Located& point : family.points) {
        const SingleImpact<Quad> form = single_impact(one.frame, point.value);
        const Quad w = point.orbit[1];
        CHECK(static_cast<double>(magnitude(form.mismatch(w))) < 1e-20);
        CHECK(point.error < 1e-18);
        if (point.kind == Kind::BP) {
          ++breakings;
          // The half-period map has a multiplier +1. With the sign of the mirror image it is -1, and its square is 1.
          CHECK(static_cast<double>(magnitude(characteristic(monodromy(one.frame, point.orbit), Quad(-1)))) < 1e-18);
        }
        if (point.kind != Kind::LP) continue;
        ++folds;
        // Both roots of the quadratic are equal.
        const Quad fold = form.stop.wall * form.alpha / (form.alpha * form.alpha + form.slope * form.slope);
        CHECK(static_cast<double>(magnitude(w - fold)) < 1e-18 * (1.0 + static_cast<double>(magnitude(w))));
      }
    }
  CHECK(folds > 3);
  CHECK(breakings > 1);
}

TEST_CASE("the checker of the random tester rejects a wrong doubled branch") {
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
    // The parent's own orbits, in place of doubled ones.
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
  plan.cases = std::stoull(variable("GRAZE_RANDOM_CASES", "150"));
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

TEST_CASE("continuation of random orbits of two stops and two masses agrees with the reference") {
  // The first chain_second of seed 1 has a Neimark-Sacker point and a doubling within one step of its branch.
  for (const Model model :
       {Model::equal_stops, Model::two_stops, Model::chain_first, Model::chain_second, Model::chain_between}) {
    Plan plan;
    plan.model = model;
    plan.program = GRAZE_PROGRAM;
    plan.systems = GRAZE_RANDOM_SYSTEMS;
    plan.cases = std::stoull(variable("GRAZE_RANDOM_SYSTEM_CASES", "5"));
    plan.seed = std::stoull(variable("GRAZE_RANDOM_SEED", "1"));
    plan.most_impacts = 4;
    plan.limit = 2.0;
    std::ostringstream lines;
    const Summary summary = run(plan, lines);
    INFO(lines.str());
    CHECK(summary.cases == plan.cases);
    CHECK(summary.undecided * 5 <= summary.cases);
    CHECK(summary.failed == 0);
  }
}

TEST_CASE("random orbits of two stops and two masses that once failed are right") {
  struct Shown {
    Model model;
    std::uint64_t seed, index;
  };
  const std::vector<Shown> all = {
      // A pair of multipliers crosses the unit circle and becomes real within one step, which also contains a fold or a
      // doubling.
      {Model::chain_second, 3, 21},
      {Model::chain_second, 3, 68},
      {Model::chain_between, 11, 11},
      // At a fold the real multiplier that leaves the circle joins one outside: no Neimark-Sacker point.
      {Model::chain_between, 21, 97},
      // An impact is lost where a free maximum touches the other stop: the orbit could not be carried through.
      {Model::equal_stops, 11, 33},
      // Without its impact the orbit has half the period: the touch in the other turn was counted as an impact.
      {Model::chain_first, 21, 48},
      // Both stops are touched at once where an impact is gained.
      {Model::equal_stops, 21, 53},
      {Model::equal_stops, 21, 82},
      // The steps of the general integrator are larger than rounding.
      {Model::two_stops, 11, 41},
      {Model::chain_second, 11, 11},
      // Newton's last step at a branch point is not taken.
      {Model::equal_stops, 11, 41},
      // Folds of equal values, mirror images of each other (a fault of the checker itself).
      {Model::equal_stops, 21, 84},
  };
  for (const Shown& one : all) {
    Plan plan;
    plan.model = one.model;
    plan.program = GRAZE_PROGRAM;
    plan.systems = GRAZE_RANDOM_SYSTEMS;
    plan.seed = one.seed;
    plan.first = one.index;
    plan.cases = 1;
    plan.most_impacts = 6;
    plan.limit = 8.0;
    plan.patience = 300.0;
    std::ostringstream lines;
    const Summary summary = run(plan, lines);
    INFO(lines.str());
    CHECK(summary.families > 0);
    CHECK(summary.failed == 0);
  }
}

TEST_CASE("the scenario of a grazing is decided if the impact is lost in one of two turns that touch") {
  Plan plan;
  plan.model = Model::equal_stops;
  plan.program = GRAZE_PROGRAM;
  plan.systems = GRAZE_RANDOM_SYSTEMS;
  const Answer answer = answered(plan, "continue",
                                 " --set b=0.1468 --set xi=3.932 --set eta=2.128 --set r=0.846 --set k_r=0.524 --param r"
                                 " --from 0.846 --to 0.118 --settle 0 --start 0.6588081793893312,2.347522390725244");
  REQUIRE(answer.failure.empty());
  int met = 0;
  for (const AnswerBranch& branch : answer.branches)
    for (const AnswerSpecial& special : branch.special_points) {
      // The same grazing, of 3/1 orbits and of 5/2 orbits (by the reference: on the side of the orbits without the impact).
      if (special.type != "GR" || std::fabs(special.value - 0.26665591383452397) > 1e-12) continue;
      ++met;
      INFO(special.label << " of branch " << branch.id);
      CHECK(special.kind == "lost");
      CHECK(special.scenario == "nonsmooth-fold");
    }
  CHECK(met >= 2);
}
