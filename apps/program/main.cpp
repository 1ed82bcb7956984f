// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/program/program.hpp>

int main(int argc, char** argv) { return graze::apps::run_main(argc, argv); }
