// SPDX-License-Identifier: GPL-3.0-or-later
// Ranks: the processes that mpirun (or srun) has started to work at one thing, and messages between them. This program alone is
// rank 0 of 1; so it is too where graze was built without MPI.
//
// Only the thread that made it may use it. Messages are bytes; between two ranks they keep their order.
#pragma once

#include <graze/apps/map/messenger.hpp>

#include <memory>
#include <optional>
#include <string>

namespace graze::apps {

/// Whether this process was started as a rank other than 0, as far as its environment says: such a one prints nothing.
bool is_helper();

class Ranks {
 public:
  /// Whether graze was built with MPI.
  static bool with_mpi();

  /// @throws std::invalid_argument if several ranks were started and this graze was built without MPI, or its module cannot be
  /// loaded.
  Ranks();

  int rank() const { return messenger_ ? messenger_->rank() : 0; }
  int count() const { return messenger_ ? messenger_->count() : 1; }

  /// `to`: another rank.
  void send(int to, const std::string& message) { messenger_->send(to, message); }
  /// The next message, if one has come.
  std::optional<Message> receive() { return messenger_ ? messenger_->receive() : std::nullopt; }

  /// Together with all other ranks: no messages after this, each is alone.
  void finish() { messenger_.reset(); }
  /// Ends all ranks at once, with this exit code.
  [[noreturn]] void abort(int code);

 private:
  std::unique_ptr<Messenger> messenger_;  ///< null: this process is alone, or done with the others
};

}  // namespace graze::apps
