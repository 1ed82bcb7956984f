// SPDX-License-Identifier: GPL-3.0-or-later
// Messenger: what carries messages between ranks (ranks.hpp). It is a module of its own, graze_mpi.so, which is loaded where a
// launcher has started this process: MPI's libraries would take as long to load as all the others together, in every command.
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
  virtual ~Messenger() = default;  ///< together with all other ranks
  virtual int rank() const = 0;
  virtual int count() const = 0;
  virtual void send(int to, const std::string& message) = 0;
  virtual std::optional<Message> receive() = 0;
  /// Ends all ranks.
  virtual void abort(int code) = 0;
};

/// The module's only function, `make_messenger`: one for this process, by `new`.
using MakeMessenger = Messenger*();

}  // namespace graze::apps
