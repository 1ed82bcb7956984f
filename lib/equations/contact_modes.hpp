// SPDX-License-Identifier: GPL-3.0-or-later
// The modes of mechanics: the combinations of the states of its contacts. Internal.
//
// A closed rigid stop and sticking friction are constraints: the accelerations follow from M with Lagrange multipliers
//     G M^-1 G^T lambda = -(G q'')_free,    q'' = q''_free + M^-1 G^T lambda,
// where the rows of G are the gradients of gap' and of the sliding speed in the velocities. States that a constraint determines
// from the others are replaced by functions of those, so that the motion does not drift off the constraint. A combination with
// dependent constraints is not a mode.
#pragma once

#include <graze/lib/equations/contacts.hpp>
#include <graze/lib/equations/pieces.hpp>
#include <graze/lib/equations/structure.hpp>

#include <map>
#include <optional>
#include <vector>

namespace graze::equations {

/// Largest number of modes from contacts.
inline constexpr std::size_t max_contact_modes = 256;

struct Combination {
  std::vector<int> status;  ///< of each contact: StopStatus or FrictionStatus
  std::size_t mode = 0;
  std::vector<std::size_t> constraints;  ///< numbers of the constraining contacts
  Column acceleration;                   ///< with multipliers, before any replacement
  Column multiplier;                     ///< of each constraint
  std::vector<Solution> solved;
  Replacement replacement;  ///< the same as a map

  /// The multiplier of this contact, which constrains.
  Expression multiplier_of(std::size_t contact) const;
};

struct ContactModes {
  std::vector<Contact> contacts;
  std::vector<Combination> combinations = {};              ///< in the order of the modes
  std::map<std::vector<int>, std::size_t> by_status = {};  ///< numbers of the combinations

  /// Null if the combination is not a mode.
  const Combination* find(const std::vector<int>& status) const;
};

/// All modes. `force`: on each coordinate, without contacts. @throws EquationError if there are too many.
ContactModes combine_contacts(const Coordinates& coordinates, const Square& inverse_mass, const Column& force,
                              std::vector<Contact> contacts);

/// The mode with its field. Its name lists the contacts that are not at rest: "free", "right", "left+right".
ModePiece make_mode(const Coordinates& coordinates, const std::vector<Contact>& contacts, const Combination& at);

}  // namespace graze::equations
