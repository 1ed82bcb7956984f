// SPDX-License-Identifier: GPL-3.0-or-later
// Ranks: the processes that mpirun (or srun) has started for one task, and the messages between them. Without a launcher, or if
// graze was built without MPI, this process is rank 0 of 1.
//
// Only the thread that created the object may use it. Messages are bytes; messages between two ranks keep their order.
#pragma once

#include <graze/apps/map/messenger.hpp>

#include <memory>
#include <optional>
#include <string>

namespace graze::apps {

/// Whether the environment says that this process is a rank other than 0. Such a rank prints nothing.
bool is_helper();

class Ranks {
 public:
  /// Whether graze was built with MPI.
  static bool with_mpi();

  /// @throws std::invalid_argument if several ranks were started and this graze was built without MPI, or if its module cannot
  /// be loaded.
  Ranks();

  int rank() const { return messenger_ ? messenger_->rank() : 0; }
  int count() const { return messenger_ ? messenger_->count() : 1; }

  /// `to`: another rank.
  void send(int to, const std::string& message) { messenger_->send(to, message); }
  /// The next message, if one has arrived.
  std::optional<Message> receive() { return messenger_ ? messenger_->receive() : std::nullopt; }

  /// Collective: no messages after this; each rank is alone.
  void finish() { messenger_.reset(); }
  /// Ends all ranks at once, with this exit code.
  [[noreturn]] void abort(int code);

 private:
  std::unique_ptr<Messenger> messenger_;  ///< null: this process is alone, or has finished with the others
};

}  // namespace graze::apps
