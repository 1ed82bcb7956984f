// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/map/ranks.hpp>

#include <fmt/format.h>

#include <cstdlib>
#include <initializer_list>
#include <stdexcept>

#ifdef GRAZE_MPI_MODULE
#include <dlfcn.h>
#endif

namespace graze::apps {

namespace {

/// A number that a launcher sets in the environment of its processes; -1: no launcher.
int from_environment(std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (const char* text = std::getenv(name)) return std::atoi(text);
  return -1;
}

int launched_rank() { return from_environment({"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"}); }

#ifdef GRAZE_MPI_MODULE

/// The messenger; null without a launcher.
std::unique_ptr<Messenger> messenger() {
  if (launched_rank() < 0) return nullptr;
  // The module stays loaded, and its symbols are global: Open MPI loads components that need them.
  void* const module = ::dlopen(GRAZE_MPI_MODULE, RTLD_NOW | RTLD_GLOBAL);
  void* const make = module ? ::dlsym(module, "make_messenger") : nullptr;
  if (!make)
    throw std::invalid_argument(fmt::format(
        "a launcher started this process, but graze's module for MPI cannot be loaded ({}); install graze whole (cmake "
        "--install) and the MPI it was built with, or start it without the launcher",
        ::dlerror()));
  return std::unique_ptr<Messenger>(reinterpret_cast<MakeMessenger*>(make)());
}

#else

std::unique_ptr<Messenger> messenger() {
  if (from_environment({"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) > 1)
    throw std::invalid_argument("several ranks were started, but this graze was built without MPI (-DGRAZE_WITH_MPI=ON)");
  return nullptr;
}

#endif

}  // namespace

bool is_helper() { return launched_rank() > 0; }

bool Ranks::with_mpi() {
#ifdef GRAZE_MPI_MODULE
  return true;
#else
  return false;
#endif
}

Ranks::Ranks() : messenger_(messenger()) {}

void Ranks::abort(int code) {
  if (messenger_) messenger_->abort(code);
  std::_Exit(code);
}

}  // namespace graze::apps
