#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace roadbalance {

/// One word of a DBC file.
struct DbcToken {
  enum class Kind {
    kName,    ///< a C identifier
    kNumber,  ///< with sign, point and exponent if it has them
    kText,    ///< what stands between quotes, as it stands there
    kMark,    ///< one character, such as ':'
    kEnd,
  };
  Kind kind = Kind::kEnd;
  std::string_view text;
  int line = 0;
  bool begins_line = false;  ///< nothing but blanks before it on its line
  bool at_margin = false;    ///< nothing at all before it on its line

  /// For an error: `"BO_"`, `the end of the file`.
  std::string shown() const;
};

/// The words of a DBC file one after the other; the text outlives them.
///
/// Every demand that is not met throws ConfigError "name:line: expected ..., found ...".
class DbcTokens {
 public:
  /// @throws ConfigError for a character or an open quotation that DBC does not have
  DbcTokens(std::string_view text, std::string name);

  /// The next but `ahead`; the end from there on.
  const DbcToken& peek(std::size_t ahead = 0) const;
  DbcToken take();

  bool next_is(char mark) const;
  bool next_is(std::string_view name) const;
  /// Takes it if it is next.
  bool take_if(char mark);

  void expect(char mark, const char* where);
  std::string_view name(const char* what);
  std::string_view quoted(const char* what);
  double number(const char* what);
  std::int64_t integer(const char* what, std::int64_t low, std::int64_t high);

  [[noreturn]] void fail(int line, const std::string& reason) const;
  /// "expected ..., found" the next word.
  [[noreturn]] void fail_expected(const std::string& what) const;

 private:
  std::string name_;
  std::vector<DbcToken> tokens_;  // the last is the end
  std::size_t next_ = 0;
};

}  // namespace roadbalance
