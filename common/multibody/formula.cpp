#include "common/multibody/formula.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace roadbalance {
namespace {

constexpr std::size_t kMostCharacters = 300;
constexpr int kDeepest = 20;  ///< parentheses in parentheses

/// Those that are all letters a name could be made of.
constexpr std::string_view kWordsOfCpp[] = {
    "alignas",   "alignof",   "and",       "asm",      "auto",     "bitand",   "bitor",     "bool",
    "break",     "case",      "catch",     "char",     "class",    "compl",    "concept",   "const",
    "consteval", "constexpr", "constinit", "continue", "decltype", "default",  "delete",    "do",
    "double",    "else",      "enum",      "explicit", "export",   "extern",   "false",     "float",
    "for",       "friend",    "goto",      "if",       "inline",   "int",      "long",      "mutable",
    "namespace", "new",       "noexcept",  "not",      "nullptr",  "operator", "or",        "private",
    "protected", "public",    "register",  "requires", "return",   "short",    "signed",    "sizeof",
    "static",    "struct",    "switch",    "template", "this",     "throw",    "true",      "try",
    "typedef",   "typeid",    "typename",  "union",    "unsigned", "using",    "virtual",   "void",
    "volatile",  "while",     "xor",       "sin",      "cos",      "std",      "parameter", "geometry",
    "equations"};

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || c == '_';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// sum = product {(+|-) product}, product = factor {(*|/) factor}, factor = - factor | number | name |
/// sin (sum) | cos (sum) | (sum)
class Parser {
 public:
  explicit Parser(std::string_view text) : unread_(text) {}

  std::vector<Formula::Step> all() {
    sum(0);
    if (!unread_.empty()) fail("there is something behind its end: " + std::string(unread_.substr(0, 20)));
    return std::move(steps_);
  }

 private:
  using Kind = Formula::Kind;

  [[noreturn]] static void fail(const std::string& reason) {
    throw std::invalid_argument("is no formula: " + reason);
  }
  bool takes(char c) {
    skip_blanks();
    if (unread_.empty() || unread_[0] != c) return false;
    unread_.remove_prefix(1);
    skip_blanks();
    return true;
  }
  void skip_blanks() {
    while (!unread_.empty() && unread_[0] == ' ') unread_.remove_prefix(1);
  }
  void sum(int depth) {
    product(depth);
    for (;;) {
      const Kind kind = takes('+') ? Kind::kPlus : takes('-') ? Kind::kMinus : Kind::kNumber;
      if (kind == Kind::kNumber) return;
      product(depth);
      steps_.push_back({kind});
    }
  }
  void product(int depth) {
    factor(depth);
    for (;;) {
      const Kind kind = takes('*') ? Kind::kTimes : takes('/') ? Kind::kOver : Kind::kNumber;
      if (kind == Kind::kNumber) return;
      factor(depth);
      steps_.push_back({kind});
    }
  }
  void factor(int depth) {
    if (depth > kDeepest) fail("it is nested too deeply");
    skip_blanks();
    if (takes('-')) {
      factor(depth + 1);
      steps_.push_back({Kind::kNegated});
    } else if (takes('(')) {
      sum(depth + 1);
      if (!takes(')')) fail("a ) is missing");
    } else if (!unread_.empty() && is_letter(unread_[0])) {
      name(depth);
    } else {
      number();
    }
  }
  void name(int depth) {
    const auto end = std::ranges::find_if_not(unread_, [](char c) { return is_letter(c) || is_digit(c); });
    const std::string word(unread_.begin(), end);
    unread_.remove_prefix(word.size());
    if (word != "sin" && word != "cos") {
      if (!is_formula_name(word)) fail(word + " cannot be a name");
      steps_.push_back({Kind::kName, 0.0, word});
      skip_blanks();
      return;
    }
    if (!takes('(')) fail("a ( is missing behind " + word);
    sum(depth + 1);
    if (!takes(')')) fail("a ) is missing");
    steps_.push_back({word == "sin" ? Kind::kSine : Kind::kCosine});
  }
  void number() {
    double value = 0.0;
    const auto [end, error] = std::from_chars(unread_.data(), unread_.data() + unread_.size(), value);
    if (error != std::errc() || !is_sound(value))
      fail("a number or a name is missing at its end or before \"" + std::string(unread_.substr(0, 20)) +
           "\"");
    unread_.remove_prefix(static_cast<std::size_t>(end - unread_.data()));
    steps_.push_back({Kind::kNumber, value});
    skip_blanks();
  }
  static bool is_sound(double value) { return std::isfinite(value) && std::abs(value) <= 1e12; }

  std::string_view unread_;
  std::vector<Formula::Step> steps_;
};

}  // namespace

Formula::Formula(const std::string& text) : text_(text) {
  if (text.size() > kMostCharacters) throw std::invalid_argument("is too long; allowed: 300 characters");
  steps_ = Parser(text).all();
}

bool is_formula_name(const std::string& name) {
  return !name.empty() && name.size() <= 40 && !name.starts_with("tension_") &&
         !name.starts_with("length_") && name[0] != '_' && !is_digit(name[0]) &&
         std::ranges::all_of(name, [](char c) { return is_letter(c) || is_digit(c); }) &&
         std::ranges::find(kWordsOfCpp, name) == std::end(kWordsOfCpp);
}

}  // namespace roadbalance
