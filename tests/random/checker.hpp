// SPDX-License-Identifier: GPL-3.0-or-later
// The checker compares an answer of the program with the reference; it is a pure function of plain data. Requirements on a
// branch:
//
//     - every point is an orbit of the family, in the order of the family, in its range, within the largest step from the
//       point before in the coordinates of the events;
//     - every LP, PD and GR of the family is present: within 3e-12 relative and within its own error bar, between the stated
//       points, with the correct impacts (lost or gained), scenario and criticality; there are no others;
//     - the branch ends where the family ends, with the correct reason.
//
// The same applies to a doubled branch, with the doubled family of the reference and twice the impacts of its parent.
#pragma once

#include "cases.hpp"

namespace graze::reference {

struct Complaint {
  std::string kind;  ///< one of a few kinds, for counting
  std::string text;
};

/// Compares the branch from the start of the family.
std::vector<Complaint> compare(const Family& family, const AnswerBranch& branch);

struct Verdict {
  std::vector<Complaint> complaints;
  bool undecided = false;  ///< the reference has failed: the case proves nothing
  int families = 0;        ///< compared
  int unresolved = 0;      ///< branches whose family could not be determined
};

/// Checks the whole answer: the branch of the given start, the branches doubled on it, and every other branch against the
/// family of its first points. Families with more impacts than `most_impacts` are skipped.
Verdict check(const Case& one, const Answer& answer, int most_impacts = 16);

/// Checks the answer of a whole skeleton: every branch as above. Every family with one impact in up to `most_periods` periods
/// must be among them, complete and once.
Verdict check_skeleton(const SkeletonCase& one, const Answer& answer, int most_impacts = 16);

/// The correct answer about a family.
AnswerBranch answer_of(const Family& family, int id);

}  // namespace graze::reference
