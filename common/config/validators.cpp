#include "common/config/validators.hpp"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

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

std::string refusal(const std::string& text, const std::string& allowed) {
  return "'" + text + "' cannot be used; allowed: " + allowed;
}

CLI::Validator validator(std::function<bool(const std::string&)> accepts, const std::string& allowed) {
  return {[accepts = std::move(accepts), allowed](std::string& text) {
            return accepts(text) ? "" : refusal(text, allowed);
          },
          ""};
}

std::string plain(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", number);
  return text;
}

CLI::Validator number_within(double low, double high, const std::string& unit) {
  return validator([=](const std::string& text) { return within(text, low, high); },
                   plain(low) + " .. " + plain(high) + unit);
}

}  // namespace

CLI::Validator number_within(double low, double high) {
  return number_within(low, high, "");
}

CLI::Validator seconds_or_zero() {
  return number_within(0.0, 1e9, " s");
}

CLI::Validator drive_length() {
  return number_within(1.0, 1e6, " s");
}

CLI::Validator seed_number() {
  return validator([](const std::string& text) { return parsed<std::int64_t>(text).value_or(-1) >= 0; },
                   "a whole number from 0 on, below 2^63");
}

CLI::Validator one_of(std::vector<std::pair<std::string, int>> words) {
  return {[words = std::move(words)](std::string& text) {
            std::string allowed;
            for (const auto& [word, number] : words) {
              if (text == word) {
                text = std::to_string(number);
                return std::string();
              }
              allowed += (allowed.empty() ? "" : ", ") + word;
            }
            return refusal(text, allowed);
          },
          ""};
}

CLI::Validator rate_of_time() {
  return validator([](const std::string& text) { return text == "max" || within(text, 1e-3, 1e6); },
                   "0.001 .. 1000000 times real time, or max");
}

}  // namespace roadbalance
