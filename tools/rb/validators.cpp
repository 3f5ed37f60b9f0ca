#include "tools/rb/validators.hpp"

#include <charconv>
#include <cstdint>
#include <optional>

namespace roadbalance {
namespace {

template <typename Number>
std::optional<Number> parsed(const std::string& text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

bool within(const std::string& text, double low, double high) {
  const auto number = parsed<double>(text);
  return number && *number >= low && *number <= high;
}

CLI::Validator validator(bool (*accepts)(const std::string&), const std::string& allowed) {
  return {[accepts, allowed](std::string& text) {
            return accepts(text) ? "" : "'" + text + "' cannot be used; allowed: " + allowed;
          },
          ""};
}

}  // namespace

CLI::Validator seconds_or_zero() {
  return validator([](const std::string& text) { return within(text, 0.0, 1e9); }, "0 .. 1000000000 s");
}

CLI::Validator drive_length() {
  return validator([](const std::string& text) { return within(text, 1.0, 1e6); }, "1 .. 1000000 s");
}

CLI::Validator seed_number() {
  return validator([](const std::string& text) { return parsed<std::int64_t>(text).value_or(-1) >= 0; },
                   "a whole number from 0 on, below 2^63");
}

CLI::Validator rate_of_time() {
  return validator([](const std::string& text) { return text == "max" || within(text, 1e-3, 1e6); },
                   "0.001 .. 1000000 times real time, or max");
}

}  // namespace roadbalance
