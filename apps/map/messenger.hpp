// SPDX-License-Identifier: GPL-3.0-or-later
// Messenger: the transport of messages between ranks (ranks.hpp). It is a separate module, graze_mpi.so, loaded only if a
// launcher has started this process: loading MPI's libraries takes as long as loading all others together, and would slow down
// every command.
#pragma once

#include <optional>
#include <string>

namespace graze::apps {

struct Message {
  int from = 0;
  std::string text;
};

class Messenger {
 public:
  virtual ~Messenger() = default;  ///< collective: together with all other ranks
  virtual int rank() const = 0;
  virtual int count() const = 0;
  virtual void send(int to, const std::string& message) = 0;
  virtual std::optional<Message> receive() = 0;
  /// Ends all ranks.
  virtual void abort(int code) = 0;
};

/// The module's only function, `make_messenger`: creates the messenger of this process with `new`.
using MakeMessenger = Messenger*();

}  // namespace graze::apps
