// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/ranks.hpp>

#include <cstdlib>
#include <stdexcept>

#ifdef GRAZE_WITH_MPI
#define OMPI_SKIP_MPICXX 1
#include <mpi.h>
#endif

namespace graze::apps {

namespace {

/// A number that a launcher puts into the environment of its processes; -1: none did.
int from_environment(std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (const char* text = std::getenv(name)) return std::atoi(text);
  return -1;
}

int launched_rank() { return from_environment({"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"}); }

}  // namespace

bool is_helper() { return launched_rank() > 0; }

#ifdef GRAZE_WITH_MPI

namespace {
constexpr int tag = 0;
}

// MPI is begun only under a launcher: without one it would cost time for nothing.
Ranks::Ranks() {
  if (launched_rank() < 0) return;
  int provided = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &count_);
  active_ = true;
}

Ranks::~Ranks() { finish(); }

void Ranks::send(int to, const std::string& message) {
  MPI_Send(message.data(), static_cast<int>(message.size()), MPI_CHAR, to, tag, MPI_COMM_WORLD);
}

std::optional<Ranks::Message> Ranks::receive() {
  if (!active_) return std::nullopt;
  int there = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, tag, MPI_COMM_WORLD, &there, &status);
  if (there == 0) return std::nullopt;
  int size = 0;
  MPI_Get_count(&status, MPI_CHAR, &size);
  Message message{status.MPI_SOURCE, std::string(static_cast<std::size_t>(size), '\0')};
  MPI_Recv(message.text.data(), size, MPI_CHAR, status.MPI_SOURCE, tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return message;
}

void Ranks::finish() {
  if (active_) MPI_Finalize();
  active_ = false;
  count_ = 1;
}

void Ranks::abort(int code) {
  if (active_) MPI_Abort(MPI_COMM_WORLD, code);
  std::_Exit(code);
}

std::string mpi_version() {
  char text[MPI_MAX_LIBRARY_VERSION_STRING] = {};
  int size = 0;
  MPI_Get_library_version(text, &size);
  std::string version(text, static_cast<std::size_t>(size));
  return version.substr(0, version.find(','));
}

#else

Ranks::Ranks() {
  if (from_environment({"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) > 1)
    throw std::invalid_argument("several ranks were started, but this graze was built without MPI (-DGRAZE_WITH_MPI=ON)");
}
Ranks::~Ranks() = default;
void Ranks::send(int, const std::string&) { throw std::logic_error("there is no other rank to send to"); }
std::optional<Ranks::Message> Ranks::receive() { return std::nullopt; }
void Ranks::finish() {}
void Ranks::abort(int code) { std::_Exit(code); }
std::string mpi_version() { return {}; }

#endif

}  // namespace graze::apps
