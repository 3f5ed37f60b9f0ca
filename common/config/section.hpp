#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace roadbalance {

/// A configuration that cannot be used.  The text names file, line, key and what is allowed.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// " (did you mean KNOWN?)" of the first of `known` that `word` is but for its unit or a slip of the pen;
/// empty: of none.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& known);

/// Inclusive bounds of a number.
struct Range {
  double low;
  double high;
};
inline constexpr Range kPositive{1e-12, 1e12};
inline constexpr Range kNotNegative{0.0, 1e12};
inline constexpr Range kAnyNumber{-1e12, 1e12};

/// A table of a TOML file whose keys are taken one by one; finish() refuses those that were not taken.
///
/// Every getter throws ConfigError "file:line: key: reason; allowed: ..." for a missing key, a wrong
/// type or a value out of range.  Numbers may be written as integers.  No NaN, no infinity.
class Section {
 public:
  static constexpr std::size_t kMostBytes = 4 << 20;  ///< of a text

  /// @throws ConfigError if the text is not TOML, with file and line, or too long
  static Section parse_text(const std::string& text, const std::string& name_for_errors);
  /// @throws std::system_error if it cannot be read; else as parse_text
  static Section parse_file(const std::string& path);

  Section(Section&&) noexcept;
  Section& operator=(Section&&) noexcept;
  ~Section();

  double number(const std::string& key, Range range);
  double number_or(const std::string& key, Range range, double otherwise);
  std::int64_t integer(const std::string& key, std::int64_t low, std::int64_t high);
  std::int64_t integer_or(const std::string& key, std::int64_t low, std::int64_t high,
                          std::int64_t otherwise);
  bool boolean_or(const std::string& key, bool otherwise);
  std::string text(const std::string& key);
  std::string text_or(const std::string& key, const std::string& otherwise);
  /// A list of texts, at most 16.
  std::vector<std::string> texts_or(const std::string& key, std::vector<std::string> otherwise);
  /// One of `allowed`, returned as its index.
  std::size_t choice(const std::string& key, const std::vector<std::string>& allowed);
  std::size_t choice_or(const std::string& key, const std::vector<std::string>& allowed,
                        std::size_t otherwise);
  /// Exactly `size` numbers (any number, at least one, if size is 0).
  std::vector<double> numbers(const std::string& key, std::size_t size, Range range);
  std::vector<double> numbers_or(const std::string& key, std::size_t size, Range range,
                                 std::vector<double> otherwise);
  /// A number, or two in [ ] of which the first is not greater: bounds.
  Range bounds_or(const std::string& key, Range range, Range otherwise);
  /// A text, or a number as it would be written.
  std::string formula(const std::string& key);
  /// Exactly `size` of them in [ ].
  std::vector<std::string> formulas(const std::string& key, std::size_t size);

  bool has(const std::string& key) const;
  /// All keys of this table, in the order of the file.
  std::vector<std::string> keys() const;
  Section section(const std::string& key);
  std::optional<Section> section_if(const std::string& key);
  /// [[key]], at least `least` of them.
  std::vector<Section> sections(const std::string& key, std::size_t least = 0);

  /// Refuses every key of this table that no getter asked for, and lists those it did ask for.
  void finish() const;

  /// For checks across keys: throws ConfigError pointing at `key`.
  [[noreturn]] void fail(const std::string& key, const std::string& reason) const;

 private:
  struct State;
  explicit Section(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace roadbalance
