// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/map/ranks.hpp>
#include <graze/apps/program/program.hpp>

#include <chrono>
#include <iostream>
#include <thread>

namespace {

/// Discards all output.
class NullBuffer : public std::streambuf {
  int overflow(int character) override { return character; }
  std::streamsize xsputn(const char*, std::streamsize size) override { return size; }
};

}  // namespace

int main(int argc, char** argv) {
  graze::apps::watch_interrupts();
  const std::vector<std::string> arguments(argv + (argc > 0 ? 1 : 0), argv + argc);
  if (!graze::apps::is_helper()) return graze::apps::run_program(arguments, std::cout, std::cerr);
  // Of several processes under mpirun, only one prints.
  NullBuffer nowhere;
  std::ostream silent(&nowhere);
  const int code = graze::apps::run_program(arguments, silent, silent);
  // A failure here also stops the rank that prints. The launcher would then end that rank because of this one's exit code: give
  // it time to print first.
  if (code != 0) std::this_thread::sleep_for(std::chrono::seconds(2));
  return code;
}
