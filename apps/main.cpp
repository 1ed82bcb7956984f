// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/interrupt.hpp>
#include <graze/apps/program.hpp>

#include <iostream>

int main(int argc, char** argv) {
  graze::apps::watch_interrupts();
  return graze::apps::run_program(std::vector<std::string>(argv + (argc > 0 ? 1 : 0), argv + argc), std::cout, std::cerr);
}
