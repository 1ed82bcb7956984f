// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/input_file.hpp>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace graze::apps {

std::string read_whole(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw std::invalid_argument(file + ": no such file");
  if (std::filesystem::is_directory(file, error)) throw std::invalid_argument(file + ": is a folder, not a result");
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream.is_open() || stream.bad()) throw std::invalid_argument(file + ": cannot be read");
  return text;
}

}  // namespace graze::apps
