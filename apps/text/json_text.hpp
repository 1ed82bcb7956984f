// SPDX-License-Identifier: GPL-3.0-or-later
// JsonText: JSON written straight into a text, on one line and without blanks (as Json::dump() does). For items of long lists:
// building a Json tree for each item would take longer than computing its values.
#pragma once

#include <graze/apps/text/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <complex>
#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

namespace graze::apps {

class JsonText {
 public:
  explicit JsonText(std::string& out) : out_(out) {}

  void begin_object() { open('{'); }
  void end_object() { close('}'); }
  void begin_list() { open('['); }
  void end_list() { close(']'); }

  /// Begins a member; the next value written is its value.
  void key(std::string_view name) {
    separate();
    quoted(name);
    out_ += ':';
    first_ = true;
  }
  /// A number (null if it is not finite), a truth value, a text, or a list of values; complex: [re, im]; nullopt: null.
  template <class T> void value(const T& what) {
    if constexpr (std::convertible_to<T, std::string_view>) {
      separate();
      quoted(what);
    } else if constexpr (std::is_arithmetic_v<T>) {
      separate();
      scalar(what);
    } else if constexpr (std::is_same_v<T, std::complex<double>>) {
      begin_list();
      value(what.real());
      value(what.imag());
      end_list();
    } else {
      begin_list();
      for (const auto& item : what) value(item);
      end_list();
    }
  }
  template <class T> void value(const std::optional<T>& what) {
    if (what) return value(*what);
    separate();
    out_ += "null";
  }
  template <class T> void member(std::string_view name, const T& what) {
    key(name);
    value(what);
  }

 private:
  void separate() {
    if (!first_) out_ += ',';
    first_ = false;
  }
  void open(char bracket) {
    separate();
    out_ += bracket;
    first_ = true;
  }
  void close(char bracket) {
    out_ += bracket;
    first_ = false;
  }
  void quoted(std::string_view text) {
    const auto is_plain = [](char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\'; };
    if (!std::all_of(text.begin(), text.end(), is_plain)) {
      out_ += flat(text);
      return;
    }
    out_ += '"';
    out_ += text;
    out_ += '"';
  }
  void scalar(bool truth) { out_ += truth ? "true" : "false"; }
  void scalar(std::integral auto number) { digits_of(number); }
  void scalar(double number) {
    if (!std::isfinite(number)) {
      out_ += "null";
      return;
    }
    if (digits_of(number, std::chars_format::general).find_first_of(".e") == std::string_view::npos)
      out_ += ".0";  // so that it is read back as a double
  }
  std::string_view digits_of(auto number, auto... format) {
    constexpr std::size_t most = 24;  // digits of a double
    const std::size_t size = out_.size();
    out_.resize(size + most);
    const char* const end = std::to_chars(out_.data() + size, out_.data() + size + most, number, format...).ptr;
    out_.resize(static_cast<std::size_t>(end - out_.data()));
    return std::string_view(out_).substr(size);
  }

  std::string& out_;
  bool first_ = true;  ///< no comma is needed before the next value
};

/// The Json tree of the text that write(JsonText&) writes.
template <class Write> Json tree_of(const Write& write) {
  std::string text;
  JsonText json(text);
  write(json);
  return Json::parse(text);
}

}  // namespace graze::apps
