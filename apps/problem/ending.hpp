// SPDX-License-Identifier: GPL-3.0-or-later
// Why a motion ended, in words. If an expression of the problem's file is at fault, the text names its place there.
#pragma once

#include <graze/apps/problem/problem.hpp>

#include <graze/lib/system/termination.hpp>

#include <string>

namespace graze::apps {

/// Why a motion from `state` at forcing phase 0 (or just after a return) could not be carried through the next period: a
/// sentence with the line of the file. Empty if no expression of the file is at fault.
std::string singularity_text(const Problem& problem, Termination reason, const Vector& state);

/// singularity_text(), or the sentence of the termination if that is empty.
std::string ending_text(const Problem& problem, Termination reason, const Vector& state);

}  // namespace graze::apps
