// SPDX-License-Identifier: GPL-3.0-or-later
// Contacts of mechanics, read from the text: stops with their laws, and dry friction. Internal.
//
// A contact has a rate that is linear in the velocities: gap' of a stop, the sliding speed of friction. Its gradient G in them is
// the direction of the contact's force. The response M^-1 G is the acceleration by a unit force, and G M^-1 G^T the compliance.
#pragma once

#include <graze/lib/equations/coordinates.hpp>

#include <optional>
#include <vector>

namespace graze::equations {

/// The states of a contact. A stop is apart if a force law that does not pull has ended, but the gap has not opened.
enum StopStatus : int { open = 0, closed = 1, apart = 2 };
enum FrictionStatus : int { forward = 0, backward = 1, stuck = 2 };

struct Contact {
  Text name;
  bool is_stop = true, rigid = false;
  int states = 2;  ///< number of its states
  std::size_t count = 0;
  Place where, law;                              ///< places of its gap or speed, and of its law
  Expression gap = {};                           ///< of a stop
  Expression rate = {};                          ///< gap' or the sliding speed
  Column direction;                              ///< gradient of the rate in the velocities
  Column response;                               ///< M^-1 direction
  Column share;                                  ///< response / (direction . response)
  Expression compliance = {};                    ///< direction . response: inverse of the effective mass at the stop
  Expression force = {};                         ///< of a stop with a force law
  bool begins_softly = false;                    ///< the force vanishes where the gap opens
  Expression restitution = {};                   ///< of a rigid stop
  std::optional<Expression> slip_force[2] = {};  ///< mu(u) N, forward and backward
  Expression limit = {};                         ///< static coefficient times N
  bool same_limit = false;                       ///< the limit of slow sliding equals the static limit
};

/// The stops and then the friction of the text. @throws EquationError
std::vector<Contact> read_contacts(const Coordinates& coordinates, const Square& inverse_mass);

}  // namespace graze::equations
