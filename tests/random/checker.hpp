// SPDX-License-Identifier: GPL-3.0-or-later
// The checker: an answer of the program against the reference, a pure function on plain data. It demands of a branch that
//
//     every point of it is an orbit of the family, in the order of the family, in its range, no further from the one before than
//         a step in the events' coordinates may be;
//     every LP, PD and GR of the family is there: within 3e-12 relative and within its own error bar, between the points where it
//         is said to be, with the right impacts, lost or gained, scenario and criticality; and there is no other;
//     it ends where the family ends, and says why;
//
// and of a doubled branch the same, against the doubled family of the reference, and twice the impacts of its parent.
#pragma once

#include "cases.hpp"

namespace graze::reference {

struct Complaint {
  std::string kind;  ///< one of few, to count by
  std::string text;
};

/// The branch from the family's start on.
std::vector<Complaint> compare(const Family& family, const AnswerBranch& branch);

struct Verdict {
  std::vector<Complaint> complaints;
  bool undecided = false;  ///< the reference has given up: the case says nothing
  int families = 0;        ///< compared
  int unresolved = 0;      ///< branches whose family could not be told
};

/// The whole answer: the branch of the case's start, the branches doubled on it, and every other branch against the family of its
/// first points. Families with more impacts than `most_impacts` are left out.
Verdict check(const Case& one, const Answer& answer, int most_impacts = 16);

/// The answer of a whole skeleton: every branch as above, and every family with one impact in up to `most_periods` periods is
/// among them, whole and once.
Verdict check_skeleton(const SkeletonCase& one, const Answer& answer, int most_impacts = 16);

/// The right answer about a family.
AnswerBranch answer_of(const Family& family, int id);

}  // namespace graze::reference
