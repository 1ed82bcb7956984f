// SPDX-License-Identifier: GPL-3.0-or-later
// TomlSection: one table of a TOML file, read key by key. Every mistake is a std::invalid_argument with one sentence: file,
// line, given value, allowed values. Included only by readers of files, because TOML's own header is large.
#pragma once

#include <graze/lib/equations/source.hpp>
#include <graze/lib/numerics/vector.hpp>

#include <toml++/toml.h>

#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace graze::apps {

/// Text in UTF-8 as a table; `file` is the name used in messages. @throws equations::EquationError for text that is not TOML.
toml::table parse_toml(std::string_view text, const std::string& file);

/// A node's characters on its first line.
equations::Place place_of(const toml::source_region& source);

/// "file:line".
std::string toml_position(const std::string& file, const toml::source_region& source);

/// "unknown key 'q' in [[stops]]; did you mean 'p'?", or "...; known are ..." if no known key is near. `note` stands before the
/// semicolon.
std::string unknown_key(std::string_view key, std::string_view where, const std::vector<std::string>& known,
                        const std::string& note = {});

/// @throws equations::EquationError for a section of the file that is not among the known ones.
void check_sections(const toml::table& root, const equations::Source& source, const std::vector<std::string>& known);

/// The reader looks up the keys that are allowed; finish() complains about all others.
class TomlSection {
 public:
  /// The table [name] of a file; it may be missing.
  TomlSection(const std::string& file, const toml::table& root, std::string name);
  /// An existing table, such as one of an array [[name]].
  TomlSection(const std::string& file, std::string name, const toml::table& table);

  bool present() const { return table_ != nullptr; }
  bool has(std::string_view key) const { return table_ && table_->contains(key); }

  std::optional<std::string> text(const std::string& key);
  std::optional<double> number(const std::string& key);
  std::optional<int> count(const std::string& key, int least, int most = std::numeric_limits<int>::max());
  std::optional<Vector> state(const std::string& key);
  /// Numbers in square brackets, any number of them.
  std::optional<std::vector<double>> numbers(const std::string& key);
  /// Pairs of numbers in square brackets; empty if the key is missing.
  std::vector<Vector> states(const std::string& key);
  /// A table within this one; it may be missing.
  TomlSection table(const std::string& key);
  /// The tables of an array ([[key]] in the file); empty if the key is missing.
  std::vector<TomlSection> tables(const std::string& key);
  std::vector<std::string> keys() const;

  /// `contact`: the law of the model, if the keys are its parameters. @throws for keys that were never looked up.
  void finish(const std::string& contact = {}) const;

  /// Position of a key, or of the section if the key is missing.
  std::string where(std::string_view key = {}) const;
  /// The error that a key is missing, with the value that it should hold.
  std::invalid_argument lacks(const std::string& key, const std::string& wanted) const;

 private:
  const toml::node* find(const std::string& key);
  std::invalid_argument wrong_type(const std::string& key, const toml::node& node, const std::string& wanted) const;

  std::string file_, name_;
  const toml::table* table_ = nullptr;
  std::vector<std::string> known_;
};

}  // namespace graze::apps
