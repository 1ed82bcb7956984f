// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/parse.hpp>

#include <graze/lib/system/parameters.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <unordered_map>

namespace graze::equations {

namespace {

enum class Kind { number, name, prime, symbol, equals, line_break, end };

struct Token {
  Kind kind = Kind::end;
  std::size_t offset = 0, length = 0;
  double value = 0.0;
};

/// The end right behind the last of the first `count` tokens that is not a line break; at `otherwise` if there is none.
Token end_behind(std::span<const Token> tokens, std::size_t count, std::size_t otherwise) {
  while (count > 0 && tokens[count - 1].kind == Kind::line_break) --count;
  return {Kind::end, count > 0 ? tokens[count - 1].offset + tokens[count - 1].length : otherwise, 0};
}

/// Longer tokens are shortened in messages.
constexpr std::size_t longest_shown = 40;

struct Character {
  char32_t code = 0;  ///< 0: not valid UTF-8
  std::size_t length = 1;
};

Character character_at(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned first = byte(at);
  if (first < 0x80U) return {first, 1};
  const std::size_t length = first >= 0xF0U ? 4 : first >= 0xE0U ? 3 : first >= 0xC2U ? 2 : 1;
  if (length == 1 || first > 0xF4U) return {0, 1};
  char32_t code = first & (0xFFU >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xC0U) != 0x80U) return {0, 1};
    code = (code << 6U) | (byte(at + i) & 0x3FU);
  }
  return {code, length};
}

bool is_letter(char32_t c) {
  if (c < 0x80) return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  // Latin with accents (without the signs of multiplication and division), Greek, Cyrillic, subscript digits.
  return (c >= 0xC0 && c <= 0x24F && c != 0xD7 && c != 0xF7) || (c >= 0x370 && c <= 0x4FF) || (c >= 0x2080 && c <= 0x2089);
}
bool is_digit(char32_t c) { return c >= '0' && c <= '9'; }

/// The ASCII sign for a character often typed or pasted in its place.
std::string_view ascii_of(char32_t c) {
  switch (c) {
  case 0x2212:
  case 0x2013:
  case 0x2014:
    return "-";
  case 0xD7:
  case 0xB7:
  case 0x22C5:
    return "*";
  case 0xF7:
  case 0x2215:
    return "/";
  case 0x2019:
  case 0x2032:
    return "'";
  case 0xB2:
    return "^2";
  case 0xB3:
    return "^3";
  default:
    return {};
  }
}

class Reader {
 public:
  Reader(const Source& source, const Text& text) : source_(source), text_(text), places_(text) {}

  [[noreturn]] void refuse(std::size_t offset, std::size_t length, const std::string& message) const {
    throw EquationError(source_, places_(offset, length), message);
  }
  [[noreturn]] void refuse(const Token& token, const std::string& message) const { refuse(token.offset, token.length, message); }

  std::string_view view(const Token& token) const { return std::string_view(text_.text).substr(token.offset, token.length); }
  std::string shown(const Token& token) const {
    if (token.kind == Kind::end) return "the end";
    if (token.kind == Kind::line_break) return view(token) == ";" ? "';'" : "the end of the line";
    const std::string_view whole = view(token);
    if (characters(whole) <= longest_shown) return fmt::format("'{}'", whole);
    std::size_t cut = longest_shown;
    while (cut > 0 && (static_cast<unsigned char>(whole[cut]) & 0xC0U) == 0x80U) --cut;
    return fmt::format("'{}...'", whole.substr(0, cut));
  }
  Place place(const Token& first, const Token& last) const {
    return places_(first.offset, last.offset + last.length - first.offset);
  }

  std::vector<Token> tokens(std::string_view where) const {
    const std::string_view text = text_.text;
    if (text.size() > longest_text)
      refuse(0, 1, fmt::format("the text {} has {} bytes; at most {} are read", where, text.size(), longest_text));
    std::vector<Token> list;
    for (std::size_t at = 0; at < text.size();) {
      const Character c = character_at(text, at);
      if (c.code == ' ' || c.code == '\t' || c.code == '\r') {
        at += 1;
      } else if (c.code == '#') {
        at = std::min(text.find('\n', at), text.size());
      } else if (c.code == '\n' || c.code == ';') {
        list.push_back({Kind::line_break, at++, 1});
      } else if (is_digit(c.code) ||
                 (c.code == '.' && at + 1 < text.size() && is_digit(static_cast<unsigned char>(text[at + 1])))) {
        list.push_back(number(at));
        at += list.back().length;
      } else if (is_letter(c.code)) {
        std::size_t end = at;
        for (Character next = c; is_letter(next.code) || is_digit(next.code); next = character_at(text, end)) {
          end += next.length;
          if (end >= text.size()) break;
        }
        list.push_back({Kind::name, at, end - at});
        at = end;
      } else if (c.code == '\'') {
        list.push_back({Kind::prime, at++, 1});
      } else if (c.code == '=') {
        list.push_back({Kind::equals, at++, 1});
      } else if (c.code != 0 && c.code < 0x80 &&
                 std::string_view("+-*/^(),").find(static_cast<char>(c.code)) != std::string_view::npos) {
        list.push_back({Kind::symbol, at++, 1});
      } else if (c.code == 0 || c.code < 0x20) {
        refuse(at, 1, fmt::format("a byte {:#04x} that is no character {}", static_cast<unsigned char>(text[at]), where));
      } else {
        const std::string_view instead = ascii_of(c.code);
        refuse(at, c.length,
               fmt::format("unexpected '{}' {}{}", text.substr(at, c.length), where,
                           instead.empty() ? std::string() : fmt::format("; write {}", instead)));
      }
    }
    list.push_back(end_behind(list, list.size(), text.size()));
    return list;
  }

 private:
  Token number(std::size_t at) const {
    const char *begin = text_.text.data() + at, *end = text_.text.data() + text_.text.size();
    double value = 0.0;
    const auto [rest, error] = std::from_chars(begin, end, value);
    const auto length = static_cast<std::size_t>(rest - begin);
    if (error == std::errc::result_out_of_range || !std::isfinite(value))
      refuse(at, length,
             fmt::format("the number {} is too large or too small", std::string_view(begin, std::min(length, longest_shown))));
    if (rest != end && *rest == '.') refuse(at, length + 1, "a number with two decimal points");
    return {Kind::number, at, length, value};
  }

  const Source& source_;
  const Text& text_;
  Places places_;
};

struct Function {
  Operation operation;
  std::size_t arguments;
};

const std::map<std::string, Function, std::less<>>& functions() {
  static const std::map<std::string, Function, std::less<>> list = [] {
    std::map<std::string, Function, std::less<>> out;
    using enum Operation;
    for (const Operation one : {sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, exp, log, sqrt, abs, sign, step})
      out[function_name(one)] = {one, 1};
    for (const Operation two : {atan2, hypot, max, min}) out[function_name(two)] = {two, 2};
    out["spline"] = {spline, 2};
    out["clamp"] = {max, 3};
    out["deadzone"] = {max, 2};
    return out;
  }();
  return list;
}

enum Binding : int { sums = 10, products = 20, signs = 30, powers = 40 };

/// A Pratt parser over a stretch of tokens.
class Parser {
 public:
  Parser(Graph& graph, const Reader& reader, std::span<const Token> tokens, const Scope& scope, std::string_view where,
         std::vector<Hazard>* hazards)
      : graph_(graph), reader_(reader), tokens_(tokens), scope_(scope), where_(where), hazards_(hazards) {}

  Expression whole() {
    skip_breaks();
    if (peek().kind == Kind::end) reader_.refuse(peek(), fmt::format("nothing stands {}", where_));
    const Expression e = expression(0);
    skip_breaks();
    if (peek().kind != Kind::end) unexpected();
    return e;
  }

 private:
  const Token& peek() const { return tokens_[at_]; }
  void skip_breaks() {
    while (peek().kind == Kind::line_break) ++at_;
  }
  /// Skips line breaks: the caller has already cut the block into equations.
  const Token& next() {
    skip_breaks();
    const Token& token = tokens_[at_];
    if (token.kind != Kind::end) ++at_;
    return token;
  }
  bool is_symbol(const Token& token, char c) const { return token.kind == Kind::symbol && reader_.view(token)[0] == c; }

  [[noreturn]] void unexpected() const {
    const Token& token = peek();
    if (is_symbol(token, ')')) reader_.refuse(token, fmt::format("')' without '(' {}", where_));
    if (token.kind == Kind::name || token.kind == Kind::number || is_symbol(token, '('))
      reader_.refuse(token, fmt::format("an operator is missing before {} {}", reader_.shown(token), where_));
    if (token.kind == Kind::prime)
      reader_.refuse(token,
                     fmt::format("' behind something that is no name {}; only a state or a definition has a rate", where_));
    reader_.refuse(token, fmt::format("unexpected {} {}", reader_.shown(token), where_));
  }

  struct Depth {
    explicit Depth(Parser& owner, const Token& token) : parser(owner) {
      if (++parser.depth_ > max_nesting)
        parser.reader_.refuse(token, fmt::format("more than {} parentheses, functions, signs and powers inside one another {}",
                                                 max_nesting, parser.where_));
    }
    ~Depth() { --parser.depth_; }
    Depth(const Depth&) = delete;
    Depth& operator=(const Depth&) = delete;
    Parser& parser;
  };

  Expression expression(int binding) {
    skip_breaks();
    const Depth depth(*this, peek());
    Expression left = prefix();
    for (;;) {
      skip_breaks();
      const Token& token = peek();
      if (token.kind != Kind::symbol) return left;
      const char sign = reader_.view(token)[0];
      const int own = sign == '+' || sign == '-' ? sums : sign == '*' || sign == '/' ? products : sign == '^' ? powers : -1;
      if (own <= binding) return left;
      ++at_;
      skip_breaks();
      const Token first = peek();
      // The exponent may have its own sign, and includes all powers to its right.
      const Expression right = expression(sign == '^' ? powers - 1 : own);
      left = combine(sign, left, right, first, token);
    }
  }

  Expression combine(char sign, Expression a, Expression b, const Token& right, const Token& symbol) {
    switch (sign) {
    case '+':
      return graph_.add(a, b);
    case '-':
      return graph_.subtract(a, b);
    case '*':
      return graph_.multiply(a, b);
    case '/':
      if (graph_.is_constant(b, 0.0)) reader_.refuse(right, fmt::format("a division by zero {}", where_));
      return note(graph_.divide(a, b), right, tokens_[at_ - 1]);
    default:
      return note(graph_.power(a, b), symbol, symbol);
    }
  }

  Expression note(Expression e, const Token& first, const Token& last) {
    using enum Operation;
    const Node& n = graph_.node(e);
    const Expression inner = n.operation == negate ? n.a : e;
    const Operation operation = graph_.node(inner).operation;
    const bool is_function = !function_name(operation).empty();
    if (hazards_ && (operation == divide || operation == power || operation == integer_power || is_function))
      hazards_->push_back({inner, reader_.place(first, last)});
    return e;
  }

  Expression prefix() {
    const Token& token = next();
    switch (token.kind) {
    case Kind::number:
      return graph_.constant(token.value);
    case Kind::name:
      skip_breaks_before_parenthesis();
      return is_symbol(peek(), '(') ? call(token) : name(token);
    case Kind::symbol:
      switch (reader_.view(token)[0]) {
      case '-':
        return graph_.negate(expression(signs));
      case '+':
        return expression(signs);
      case '(': {
        skip_breaks();
        if (is_symbol(peek(), ')')) reader_.refuse(peek(), fmt::format("nothing stands between ( and ) {}", where_));
        const Expression inner = expression(0);
        close(token);
        return inner;
      }
      default:
        break;
      }
      break;
    default:
      break;
    }
    if (token.kind == Kind::end) reader_.refuse(token, fmt::format("an operand is missing at the end {}", where_));
    reader_.refuse(token, fmt::format("an operand is missing before {} {}", reader_.shown(token), where_));
  }

  void skip_breaks_before_parenthesis() {
    std::size_t ahead = at_;
    while (tokens_[ahead].kind == Kind::line_break) ++ahead;
    if (is_symbol(tokens_[ahead], '(')) at_ = ahead;
  }

  void close(const Token& open) {
    skip_breaks();
    if (is_symbol(peek(), ')')) {
      ++at_;
      return;
    }
    if (peek().kind == Kind::end || is_symbol(peek(), ',')) reader_.refuse(open, fmt::format("'(' is not closed {}", where_));
    unexpected();
  }

  Expression name(const Token& token) {
    const std::string_view text = reader_.view(token);
    const bool primed = peek().kind == Kind::prime;
    if (primed) ++at_;
    if (text == "t" || text == "pi") {
      if (primed) reader_.refuse(token, fmt::format("{}' {}: only a state or a definition has a rate", text, where_));
      if (text == "pi") return graph_.pi();
      if (const std::string refused = scope_.refusal ? scope_.refusal(text) : std::string(); !refused.empty())
        reader_.refuse(token, fmt::format("{} {}", refused, where_));
      return graph_.time();
    }
    if (functions().contains(text))
      reader_.refuse(token, fmt::format("the function {} needs its arguments in parentheses {}", text, where_));
    const std::optional<Expression> found = scope_.find(text);
    if (!found) {
      if (const std::string refused = scope_.refusal ? scope_.refusal(text) : std::string(); !refused.empty())
        reader_.refuse(token, fmt::format("{} {}", refused, where_));
      std::vector<std::string> candidates = scope_.names;
      candidates.insert(candidates.end(), {"t", "pi"});
      unknown("name", token, candidates);
    }
    if (!primed) return *found;
    if (!scope_.rates) reader_.refuse(token, fmt::format("a rate such as {}' cannot be used {}", text, where_));
    const Expression rate = graph_.rate(*found);
    if (hazards_) hazards_->push_back({rate, reader_.place(token, token)});
    return rate;
  }

  [[noreturn]] void unknown(std::string_view kind, const Token& token, const std::vector<std::string>& candidates) const {
    reader_.refuse(token, fmt::format("unknown {} {} {}{}", kind, reader_.shown(token), where_,
                                      suggestion(reader_.view(token), candidates)));
  }

  Expression call(const Token& token) {
    const std::string_view text = reader_.view(token);
    const auto found = functions().find(text);
    if (found == functions().end()) {
      if (scope_.find(text))
        reader_.refuse(token, fmt::format("'{}' is not a function; write {}*(...) for a product {}", text, text, where_));
      std::vector<std::string> candidates;
      for (const auto& [name, function] : functions()) candidates.push_back(name);
      unknown("function", token, candidates);
    }
    const Token open = next();
    if (text == "spline") return spline_call(token, open);
    std::vector<Expression> arguments;
    skip_breaks();
    if (is_symbol(peek(), ')')) {
      ++at_;
    } else {
      for (;;) {
        arguments.push_back(expression(0));
        skip_breaks();
        if (!is_symbol(peek(), ',')) break;
        ++at_;
      }
      close(open);
    }
    const std::size_t wanted = found->second.arguments;
    if (arguments.size() != wanted)
      reader_.refuse(token, fmt::format("{} takes {} argument{}, not {}, {}", text, wanted, wanted == 1 ? "" : "s",
                                        arguments.size(), where_));
    const auto max = [&](Expression a, Expression b) { return graph_.function(Operation::max, a, b); };
    const auto min = [&](Expression a, Expression b) { return graph_.function(Operation::min, a, b); };
    const Expression zero = graph_.constant(0.0);
    const auto number = [&](Expression e) {
      const Node& node = graph_.node(e);
      return node.operation == Operation::constant ? node.value : std::nan("");
    };
    if (text == "clamp" && number(arguments[1]) > number(arguments[2]))
      reader_.refuse(token, fmt::format("clamp(E, least, most) has the least {} above the most {}", number(arguments[1]),
                                        number(arguments[2])));
    if (text == "deadzone" && number(arguments[1]) < 0.0)
      reader_.refuse(token, fmt::format("deadzone(E, half) has the half width {}; allowed is >= 0", number(arguments[1])));
    if (text == "clamp") return max(arguments[1], min(arguments[2], arguments[0]));
    if (text == "deadzone")
      return graph_.add(max(graph_.subtract(arguments[0], arguments[1]), zero),
                        min(graph_.add(arguments[0], arguments[1]), zero));
    return note(graph_.function(found->second.operation, arguments[0], wanted == 2 ? arguments[1] : Expression{}), token, token);
  }

  /// spline(table, u): the first argument is the name of a table, with a prime for each derivative.
  Expression spline_call(const Token& function, const Token& open) {
    const Token& table = next();
    int order = 0;
    for (; peek().kind == Kind::prime; ++at_) ++order;
    if (table.kind != Kind::name)
      reader_.refuse(table.kind == Kind::end ? function : table,
                     fmt::format("spline takes the name of a table first {}", where_));
    const auto number = scope_.table ? scope_.table(reader_.view(table)) : std::nullopt;
    if (!number) unknown("table", table, scope_.tables);
    skip_breaks();
    if (!is_symbol(peek(), ','))
      reader_.refuse(function, fmt::format("spline takes 2 arguments, a table and an expression, {}", where_));
    ++at_;
    const Expression argument = expression(0);
    close(open);
    return graph_.spline(*number, argument, order);
  }

  Graph& graph_;
  const Reader& reader_;
  std::span<const Token> tokens_;
  const Scope& scope_;
  std::string_view where_;
  std::vector<Hazard>* hazards_;
  std::size_t at_ = 0, depth_ = 0;
};

}  // namespace

const std::vector<std::string>& reserved_names() {
  static const std::vector<std::string> list = [] {
    std::vector<std::string> out{"t", "pi"};
    for (const auto& [name, function] : functions()) out.push_back(name);
    return out;
  }();
  return list;
}

Scope scope_of(const std::map<std::string, Expression, std::less<>>& names,
               const std::map<std::string, std::size_t, std::less<>>& tables) {
  Scope out;
  out.find = [&names](std::string_view name) -> std::optional<Expression> {
    const auto found = names.find(name);
    return found == names.end() ? std::nullopt : std::optional(found->second);
  };
  out.table = [&tables](std::string_view name) -> std::optional<std::size_t> {
    const auto found = tables.find(name);
    return found == tables.end() ? std::nullopt : std::optional(found->second);
  };
  for (const auto& [name, expression] : names) out.names.push_back(name);
  for (const auto& [name, number] : tables) out.tables.push_back(name);
  return out;
}

std::string suggestion(std::string_view name, const std::vector<std::string>& candidates) {
  const std::string nearest = nearest_name(name, candidates);
  return nearest.empty() ? std::string() : fmt::format("; did you mean '{}'?", nearest);
}

std::string suggestion_or_list(std::string_view name, const std::vector<std::string>& candidates) {
  constexpr std::size_t most = 32;
  std::string near = suggestion(name, candidates);
  if (!near.empty() || candidates.empty() || candidates.size() > most) return near;
  return fmt::format("; choose one of {}", fmt::join(candidates, ", "));
}

bool has_names(const Source& source, const Text& text, std::string_view where) {
  const Reader reader(source, text);
  const std::vector<std::string>& reserved = reserved_names();
  const std::vector<Token> tokens = reader.tokens(where);
  return std::any_of(tokens.begin(), tokens.end(), [&](const Token& token) {
    return token.kind == Kind::name && std::find(reserved.begin(), reserved.end(), reader.view(token)) == reserved.end();
  });
}

bool is_name(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const Character c = character_at(text, at);
    if (!is_letter(c.code) && (at == 0 || !is_digit(c.code))) return false;
    at += c.length;
  }
  return !text.empty();
}

std::optional<Place> known_place(const Graph& graph, const std::vector<Hazard>& hazards, Expression node) {
  const auto first = [&](const auto& matches) -> std::optional<Place> {
    const auto found = std::find_if(hazards.begin(), hazards.end(), matches);
    return found != hazards.end() ? std::optional(found->place) : std::nullopt;
  };
  for (std::optional<Expression> at = node; at; at = graph.origin(*at))
    if (const auto place = first([&](const Hazard& one) { return one.node == *at; })) return place;
  for (std::optional<Expression> at = node; at; at = graph.origin(*at))
    if (const auto divisor = divisor_of(graph, *at))
      if (const auto place = first([&](const Hazard& one) { return divisor_of(graph, one.node) == divisor; })) return place;
  return std::nullopt;
}

Expression parse_expression(Graph& graph, const Source& source, const Text& text, const Scope& scope, std::string_view where,
                            std::vector<Hazard>* hazards) {
  const Reader reader(source, text);
  const std::vector<Token> tokens = reader.tokens(where);
  for (const Token& token : tokens)
    if (token.kind == Kind::line_break && reader.view(token) == ";")
      reader.refuse(token, fmt::format("unexpected ';' {}", where));
  return Parser(graph, reader, tokens, scope, where, hazards).whole();
}

std::vector<Assignment> parse_block(Graph& graph, const Source& source, const Text& text, const Scope& scope,
                                    const std::function<std::string(std::string_view)>& where_of, std::string_view where_of_block,
                                    std::vector<Hazard>* hazards) {
  const Reader reader(source, text);
  const std::vector<Token> tokens = reader.tokens(where_of_block);
  std::vector<Assignment> list;
  const auto kind = [&](std::size_t i) { return tokens[std::min(i, tokens.size() - 1)].kind; };
  /// name = or name' =
  const auto begins = [&](std::size_t i) {
    return kind(i) == Kind::name && (kind(i + 1) == Kind::equals || (kind(i + 1) == Kind::prime && kind(i + 2) == Kind::equals));
  };
  for (std::size_t at = 0; kind(at) != Kind::end;) {
    if (kind(at) == Kind::line_break) {
      ++at;
      continue;
    }
    if (!begins(at))
      reader.refuse(tokens[at], fmt::format("an equation \"name = expression\" was expected at {} {}", reader.shown(tokens[at]),
                                            where_of_block));
    Assignment one;
    const Token& name = tokens[at];
    one.name = reader.view(name);
    one.primed = kind(at + 1) == Kind::prime;
    one.place = reader.place(name, name);
    at += one.primed ? 3 : 2;
    // The equation ends at a ;, at a line break before the next assignment, or at a line break that no operator or parenthesis
    // continues.
    std::size_t end = at, depth = 0;
    for (; kind(end) != Kind::end; ++end) {
      const std::string_view sign = reader.view(tokens[end]);
      if (kind(end) == Kind::equals)
        reader.refuse(tokens[end], fmt::format("a second '=' {}; is a line break or ; missing?", where_of(one.name)));
      if (kind(end) == Kind::symbol && sign == "(") ++depth;
      if (kind(end) == Kind::symbol && sign == ")" && depth > 0) --depth;
      if (kind(end) != Kind::line_break) continue;
      if (sign == ";" || begins(end + 1)) break;
      const auto bridges = [&](std::size_t i, std::string_view signs) {
        return kind(i) == Kind::symbol && signs.find(reader.view(tokens[i])[0]) != std::string_view::npos;
      };
      const bool open = end == at || bridges(end - 1, "+-*/^,(") || bridges(end + 1, "+-*/^,)");
      if (depth == 0 && !open && kind(end + 1) != Kind::line_break) break;
    }
    std::vector<Token> stretch(tokens.begin() + static_cast<std::ptrdiff_t>(at),
                               tokens.begin() + static_cast<std::ptrdiff_t>(end));
    const Token last = end > at ? tokens[end - 1] : tokens[at - 1];
    stretch.push_back(end_behind(tokens, end, 0));
    one.equation = end > at ? reader.place(tokens[at], last) : one.place;
    const std::string where = where_of(one.name);
    one.value = Parser(graph, reader, stretch, scope, where, hazards).whole();
    list.push_back(std::move(one));
    at = end;
  }
  return list;
}

std::vector<Expression> parse_definitions(Graph& graph, const Source& source, std::span<const Definition> definitions,
                                          const Scope& scope, std::string_view kind, std::vector<Hazard>* hazards) {
  const auto where = [&](std::size_t i) { return fmt::format("in the {} {}", kind, definitions[i].name.text); };
  std::unordered_map<std::string, std::size_t> number;
  for (std::size_t i = 0; i < definitions.size(); ++i) number.emplace(definitions[i].name.text, i);
  // The definitions that each definition names, to read them in an order in which all of these are known.
  struct Use {
    std::size_t of;
    Place place;
  };
  std::vector<std::vector<Use>> uses(definitions.size());
  for (std::size_t i = 0; i < definitions.size(); ++i) {
    const Reader reader(source, definitions[i].value);
    for (const Token& token : reader.tokens(where(i)))
      if (token.kind == Kind::name)
        if (const auto found = number.find(std::string(reader.view(token))); found != number.end())
          uses[i].push_back({found->second, reader.place(token, token)});
  }
  std::vector<std::optional<Expression>> value(definitions.size());
  Scope inner = scope;
  inner.find = [&](std::string_view name) -> std::optional<Expression> {
    if (const auto found = number.find(std::string(name)); found != number.end()) return value[found->second];
    return scope.find(name);
  };
  for (const Definition& one : definitions) inner.names.push_back(one.name.text);
  std::vector<char> on_path(definitions.size(), 0);
  struct Visit {
    std::size_t definition, next_use = 0;
  };
  for (std::size_t root = 0; root < definitions.size(); ++root) {
    std::vector<Visit> path;
    if (!value[root]) path.push_back({root});
    while (!path.empty()) {
      const std::size_t i = path.back().definition;
      on_path[i] = 1;
      if (path.back().next_use < uses[i].size()) {
        const Use& use = uses[i][path.back().next_use++];
        if (value[use.of]) continue;
        if (!on_path[use.of]) {
          path.push_back({use.of});
          continue;
        }
        std::vector<std::string> chain;
        for (const Visit& visit : path)
          if (visit.definition == use.of || !chain.empty()) chain.push_back(definitions[visit.definition].name.text);
        chain.push_back(definitions[use.of].name.text);
        constexpr std::size_t longest_chain = 12;
        if (chain.size() > longest_chain) {
          chain.erase(chain.begin() + longest_chain / 2, chain.end() - longest_chain / 2);
          chain.insert(chain.begin() + longest_chain / 2, "...");
        }
        throw EquationError(
            source, use.place,
            fmt::format("the {} {} depends on itself: {}", kind, definitions[use.of].name.text, fmt::join(chain, " -> ")));
      }
      value[i] = parse_expression(graph, source, definitions[i].value, inner, where(i), hazards);
      on_path[i] = 0;
      path.pop_back();
    }
  }
  std::vector<Expression> out;
  for (const auto& one : value) out.push_back(*one);
  return out;
}

}  // namespace graze::equations
