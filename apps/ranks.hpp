// SPDX-License-Identifier: GPL-3.0-or-later
// Ranks: the processes that mpirun (or srun) has started to work at one thing, and messages between them. This program alone is
// rank 0 of 1; so it is too where graze was built without MPI.
//
// Only the thread that made it may use it. Messages are bytes; between two ranks they keep their order.
#pragma once

#include <optional>
#include <string>

namespace graze::apps {

/// Whether this process was started as a rank other than 0, as far as its environment says: such a one prints nothing.
bool is_helper();

class Ranks {
 public:
  /// @throws std::invalid_argument if several ranks were started and this graze was built without MPI.
  Ranks();
  ~Ranks();  ///< finish(), unless it was called
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  int rank() const { return rank_; }
  int count() const { return count_; }

  void send(int to, const std::string& message);

  struct Message {
    int from = 0;
    std::string text;
  };
  /// The next message, if one has come.
  std::optional<Message> receive();

  /// Together with all other ranks: no messages after this, each is alone.
  void finish();
  /// Ends all ranks at once, with this exit code.
  [[noreturn]] void abort(int code);

 private:
  int rank_ = 0, count_ = 1;
  bool active_ = false;
};

/// "Open MPI 4.1.4", or "" where graze was built without.
std::string mpi_version();

}  // namespace graze::apps
