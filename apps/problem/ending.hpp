// SPDX-License-Identifier: GPL-3.0-or-later
// Why a motion ended, in words that name the place in the problem's file if an expression of it is at fault.
#pragma once

#include <graze/apps/problem/problem.hpp>

#include <graze/lib/system/termination.hpp>

#include <string>

namespace graze::apps {

/// The sentence with its line of the file for a motion that could not be carried on from `state` at forcing phase 0 (or behind a
/// return) through the next period; empty if no expression of the file is at fault.
std::string singularity_text(const Problem& problem, Termination reason, const Vector& state);

/// That, else the sentence of the termination.
std::string ending_text(const Problem& problem, Termination reason, const Vector& state);

}  // namespace graze::apps
