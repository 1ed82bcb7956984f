// SPDX-License-Identifier: GPL-3.0-or-later
// The states that cover a nonperiodic attractor.
#pragma once

#include <graze/floquet/attractor/attractor.hpp>

#include <memory>
#include <vector>

namespace graze {

class ContactTable;

/// States at forcing phase 0 that cover the attractor, `count` or a few more in all; fewer if the motion cannot be continued.
/// They are those of one motion from its state. If it is chaotic, and one thread carries several motions at once, they come from
/// several motions separated by chaos, one after the other, each with a multiple of VisitedCells::window states.
/// @param table  of contacts at these parameters; may be null.
std::vector<Vector> attractor_states(const SharedSystem& system, const Vector& p, const Attractor& attractor, std::size_t count,
                                     const FlowOptions& flow, const std::shared_ptr<const ContactTable>& table);

}  // namespace graze
