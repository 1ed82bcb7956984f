// SPDX-License-Identifier: GPL-3.0-or-later
// A table of contacts for many motions of one system with one set of parameters, made from the first of them.
#pragma once

#include <graze/lib/motion/propagator.hpp>

#include <memory>

namespace graze {

class ContactTable;

/// Carries some of these motions to measure how soon they settle and how fast they hit the barrier, and makes a table of contacts
/// at those speeds for all of them; null if a table does not apply or does not pay. It depends on nothing but these arguments.
/// @param starts  of all motions, at forcing phase 0, one per column.
std::shared_ptr<const ContactTable> probed_contacts(const SharedSystem& system, const Vector& p, const Matrix& starts,
                                                    const FlowOptions& flow = {});

}  // namespace graze
