#include "common/dbc/dbc_tokens.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <utility>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kLongestShown = 30;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // UTF-8's, which some editors put first

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool begins_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

std::size_t end_of_name(std::string_view text, std::size_t at) {
  while (at < text.size() && (begins_name(text[at]) || is_digit(text[at]))) ++at;
  return at;
}

/// The end of a number at `at`, or `at` if there is none.
std::size_t end_of_number(std::string_view text, std::size_t at) {
  const auto skip_digits = [&](std::size_t from) {
    while (from < text.size() && is_digit(text[from])) ++from;
    return from;
  };
  const std::size_t whole = at + (text[at] == '-' || text[at] == '+' ? 1 : 0);
  std::size_t end = skip_digits(whole);
  bool any = end > whole;
  if (end < text.size() && text[end] == '.') {
    const std::size_t after = skip_digits(end + 1);
    any = any || after > end + 1;
    end = after;
  }
  if (!any) return at;
  if (end < text.size() && (text[end] == 'e' || text[end] == 'E')) {
    std::size_t digits = end + 1;
    if (digits < text.size() && (text[digits] == '-' || text[digits] == '+')) ++digits;
    if (const std::size_t after = skip_digits(digits); after > digits) end = after;
  }
  return end;
}

/// For the quotation that opens at `at`: the place of the closing mark; a backslash takes the next character
/// along.
std::size_t closing_quote(std::string_view text, std::size_t at) {
  for (++at; at < text.size() && text[at] != '"'; ++at)
    if (text[at] == '\\') ++at;
  return at;
}

/// Bytes of the file that would end a message or act on a terminal, as \x1B; bytes that may be UTF-8 stay.
std::string printable(std::string_view text) {
  std::string shown;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    std::array<char, 5> code{};
    if (byte < 0x20 || byte == 0x7F) std::snprintf(code.data(), code.size(), "\\x%02X", byte);
    shown += code[0] ? std::string(code.data()) : std::string(1, c);
  }
  return shown;
}

}  // namespace

std::string DbcToken::shown() const {
  if (kind == Kind::kEnd) return "the end of the file";
  const bool is_long = text.size() > kLongestShown;
  return "\"" + printable(text.substr(0, kLongestShown)) + (is_long ? "...\"" : "\"");
}

DbcTokens::DbcTokens(std::string_view text, std::string name) : name_(std::move(name)) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  int line = 1;
  bool begins_line = true;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (is_blank(c)) {
      if (c == '\n') {
        ++line;
        begins_line = true;
      }
      ++at;
      continue;
    }
    DbcToken token{.kind = DbcToken::Kind::kMark,
                   .text = text.substr(at, 1),
                   .line = line,
                   .begins_line = begins_line,
                   .at_margin = at == 0 || text[at - 1] == '\n'};
    std::size_t end = at + 1;
    if (c == '"') {
      const std::size_t close = closing_quote(text, at);
      if (close >= text.size()) fail(line, "expected a closing \" before the end of the file");
      token.kind = DbcToken::Kind::kText;
      token.text = text.substr(at + 1, close - at - 1);
      line += static_cast<int>(std::count(token.text.begin(), token.text.end(), '\n'));
      end = close + 1;
    } else if (begins_name(c)) {
      end = end_of_name(text, at);
      token.kind = DbcToken::Kind::kName;
      token.text = text.substr(at, end - at);
    } else if (const std::size_t after = end_of_number(text, at); after > at) {
      end = after;
      token.kind = DbcToken::Kind::kNumber;
      token.text = text.substr(at, end - at);
    }
    tokens_.push_back(token);
    begins_line = false;
    at = end;
  }
  tokens_.push_back(
      {.kind = DbcToken::Kind::kEnd, .text = {}, .line = line, .begins_line = true, .at_margin = true});
}

const DbcToken& DbcTokens::peek(std::size_t ahead) const {
  return tokens_[std::min(next_ + ahead, tokens_.size() - 1)];
}

DbcToken DbcTokens::take() {
  const DbcToken token = peek();
  if (token.kind != DbcToken::Kind::kEnd) ++next_;
  return token;
}

bool DbcTokens::next_is(char mark) const {
  return peek().kind == DbcToken::Kind::kMark && peek().text.front() == mark;
}

bool DbcTokens::next_is(std::string_view name) const {
  return peek().kind == DbcToken::Kind::kName && peek().text == name;
}

bool DbcTokens::take_if(char mark) {
  if (!next_is(mark)) return false;
  ++next_;
  return true;
}

void DbcTokens::expect(char mark, const char* where) {
  if (!take_if(mark)) fail_expected("\"" + std::string(1, mark) + "\" " + where);
}

std::string_view DbcTokens::name(const char* what) {
  if (peek().kind != DbcToken::Kind::kName) fail_expected(what);
  return take().text;
}

std::string_view DbcTokens::quoted(const char* what) {
  if (peek().kind != DbcToken::Kind::kText) fail_expected(std::string(what) + " in quotes,");
  return take().text;
}

double DbcTokens::number(const char* what) {
  if (peek().kind != DbcToken::Kind::kNumber) fail_expected(what);
  std::string_view digits = peek().text;
  if (digits.front() == '+') digits.remove_prefix(1);  // from_chars takes no plus
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size()) fail_expected(what);
  ++next_;
  return value;
}

std::int64_t DbcTokens::integer(const char* what, std::int64_t low, std::int64_t high) {
  const std::string allowed =
      std::string(what) + ", " + std::to_string(low) + " .. " + std::to_string(high) + ",";
  if (peek().kind != DbcToken::Kind::kNumber) fail_expected(allowed);
  const std::string_view digits = peek().text;
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || value < low || value > high)
    fail_expected(allowed);
  ++next_;
  return value;
}

void DbcTokens::fail(int line, const std::string& reason) const {
  throw ConfigError(name_ + ":" + std::to_string(line) + ": " + reason);
}

void DbcTokens::fail_expected(const std::string& what) const {
  fail(peek().line, "expected " + what + " found " + peek().shown());
}

}  // namespace roadbalance
