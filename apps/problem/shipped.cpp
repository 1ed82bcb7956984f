// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/problem/shipped.hpp>
#include <graze/lib/system/parameters.hpp>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace graze::apps {

namespace fs = std::filesystem;

fs::path shipped(const std::string& name) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed = program.parent_path() / GRAZE_INSTALLED_DATA / name;
  if (!error && fs::exists(installed, error)) return installed.lexically_normal();
  const fs::path source = fs::path(GRAZE_SOURCE_DATA) / name;
  return fs::exists(source, error) ? source : fs::path();
}

std::vector<std::string> shipped_models() {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(shipped("models"), error))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string shipped_model(const std::string& name) {
  const std::vector<std::string> names = shipped_models();
  if (std::find(names.begin(), names.end(), name) == names.end()) throw std::invalid_argument(unknown_name("model", name, names));
  std::ifstream stream(shipped("models") / (name + ".toml"), std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace graze::apps
