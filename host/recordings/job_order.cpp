#include "host/recordings/job_order.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>

namespace roadbalance {
namespace {

constexpr std::size_t kMostRecordingName = 95, kMostOptions = 303;  // as common/wire/job_t holds them

std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

bool is_text(std::string_view) {
  return true;
}

bool is_time(std::string_view text) {
  constexpr double kMostSeconds = 1e8;  // three years
  const auto value = number(text);
  return value && std::abs(*value) <= kMostSeconds;
}

bool is_mark(std::string_view text) {
  constexpr std::size_t kMostDigits = 9;
  return text.size() <= kMostDigits && std::ranges::all_of(text, [](char c) { return '0' <= c && c <= '9'; });
}

bool is_rate(std::string_view text) {
  const auto value = number(text);
  return value && *value > 0.0 && *value <= 1e6;
}

bool is_yes(std::string_view text) {
  return text == "yes";
}

struct Key {
  std::string_view name;
  bool (*is_allowed)(std::string_view);
  std::string_view allowed;
};
constexpr std::array kKeys{
    Key{"before", is_text, "the name of a recording"},
    Key{"format", is_text, "the name of a format"},
    Key{"channels", is_text, "names of channels"},
    Key{"from", is_time, "seconds"},
    Key{"to", is_time, "seconds"},
    Key{"from-mark", is_mark, "the number of a mark"},
    Key{"to-mark", is_mark, "the number of a mark"},
    Key{"rate", is_rate, "samples a second"},
    Key{"complete", is_yes, "yes"},
};

/// Takes one option.  @return its fault; empty: none
std::string take(std::string_view word, JobOrder& order) {
  const auto equals = word.find('=');
  const std::string name(word.substr(0, equals));
  const auto* key = std::ranges::find(kKeys, name, &Key::name);
  if (equals == std::string_view::npos || key == kKeys.end())
    return "\"" + std::string(word) + "\" says nothing of a job";
  const std::string value(word.substr(equals + 1));
  if (value.empty() || !key->is_allowed(value))
    return name + " \"" + value + "\": allowed: " + std::string(key->allowed);
  if (!order.option.emplace(name, value).second) return name + " is said twice";
  return "";
}

}  // namespace

std::variant<JobOrder, std::string> parse_job_order(std::string_view text) {
  const auto slash = text.find('/');
  JobOrder order{.recording = std::string(text.substr(0, slash))};
  if (slash != std::string_view::npos) order.options = text.substr(slash + 1);
  if (order.recording.size() > kMostRecordingName || order.options.size() > kMostOptions)
    return "it is too long";
  if (slash != std::string_view::npos && order.options.empty()) return "nothing follows the slash";
  for (std::string_view rest = order.options; !rest.empty();) {
    const auto end = std::min(rest.find('/'), rest.size());
    if (std::string why = take(rest.substr(0, end), order); !why.empty()) return why;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return order;
}

double number_in(const JobOrder& order, const std::string& key, double otherwise) {
  const auto found = order.option.find(key);
  return found == order.option.end() ? otherwise : number(found->second).value_or(otherwise);
}

}  // namespace roadbalance
