#pragma once

#include <charconv>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/section.hpp"

namespace roadbalance {

/// The address of a device, "PATH?key=value&key=value", whose keys are taken one by one; finish() refuses
/// those that were not taken.
class AddressQuery {
 public:
  /// @param scheme  for errors, e.g. "sim"
  AddressQuery(const std::string& scheme, const std::string& address);

  const std::string& path() const { return path_; }
  std::optional<std::string> text(const std::string& key);
  /// @throws ConfigError if it is no number from low to high
  /// @param otherwise  what else is allowed, for the error, e.g. ", or max"
  template <typename Number>
  std::optional<Number> number(const std::string& key, Number low, Number high,
                               const std::string& otherwise = "") {
    const auto value = text(key);
    if (!value) return std::nullopt;
    Number number{};
    const auto [end, error] = std::from_chars(value->data(), value->data() + value->size(), number);
    if (error != std::errc() || end != value->data() + value->size() || !(number >= low && number <= high))
      fail(key + ": '" + *value + "' cannot be used; allowed: a number from " + std::to_string(low) + " to " +
           std::to_string(high) + otherwise);
    return number;
  }
  /// Bus seconds a wall second; 1 if not given, nothing for "max".
  std::optional<double> rate();

  /// @throws ConfigError "scheme:address: reason"
  [[noreturn]] void fail(const std::string& reason) const;
  /// @throws ConfigError naming a key that was not taken, and those that were
  void finish() const;

 private:
  const std::string whole_;
  std::string path_;
  std::map<std::string, std::string> value_;
  std::vector<std::string> asked_;
};

}  // namespace roadbalance
