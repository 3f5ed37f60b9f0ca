#include "sim/address.hpp"

#include <charconv>
#include <cmath>
#include <string_view>

#include "common/config/section.hpp"

namespace roadbalance::sim {
namespace {

template <typename Number>
Number parse_number(const std::string& address, std::string_view key, std::string_view value, Number low,
                    Number high) {
  Number number{};
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size() || !(number >= low && number <= high))
    throw ConfigError("sim:" + address + ": " + std::string(key) + ": '" + std::string(value) +
                      "' cannot be used; allowed: a number from " + std::to_string(low) + " to " +
                      std::to_string(high) + (key == "rate" ? ", or max" : ""));
  return number;
}

}  // namespace

Address Address::parse(const std::string& text) {
  Address address;
  const auto question = text.find('?');
  address.scenario_path = text.substr(0, question);
  std::string_view rest = question == std::string::npos ? "" : std::string_view(text).substr(question + 1);
  while (!rest.empty()) {
    const std::string_view pair = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), pair.size() + 1));
    const auto equals = pair.find('=');
    const std::string_view key = pair.substr(0, equals);
    const std::string_view value = equals == std::string_view::npos ? "" : pair.substr(equals + 1);
    if (key == "seed")
      address.seed = parse_number<std::uint64_t>(text, key, value, 0, INT64_MAX);
    else if (key == "rate" && value == "max")
      address.rate.reset();
    else if (key == "rate")
      address.rate = parse_number(text, key, value, 1e-3, 1e6);
    else if (key == "seconds")
      address.seconds = parse_number(text, key, value, 1.0, 1e6);
    else if (key == "start_ns")
      address.start_ns = parse_number<std::int64_t>(text, key, value, 0, INT64_MAX);
    else if (key == "from")
      address.from_s = parse_number(text, key, value, 0.0, 1e6);
    else if (key == "clock_offset_s")
      address.clock_offset_s = parse_number(text, key, value, -1e6, 1e6);
    else if (key == "clock_ppm")
      address.clock_ppm = parse_number(text, key, value, -500.0, 500.0);
    else if (key == "converter_ppm")
      address.converter_ppm = parse_number(text, key, value, -500.0, 500.0);
    else
      throw ConfigError(
          "sim:" + text + ": unknown key '" + std::string(key) +
          "'; allowed: seed, rate, seconds, start_ns, from, clock_offset_s, clock_ppm, converter_ppm");
  }
  const bool own_clock = address.clock_offset_s != 0.0 || address.clock_ppm != 0.0;
  if (own_clock && address.rate != 1.0)
    throw ConfigError("sim:" + text + ": " + (address.clock_ppm != 0.0 ? "clock_ppm" : "clock_offset_s") +
                      ": allowed only with rate=1: at any other rate all nodes have bus time in common");
  return address;
}

}  // namespace roadbalance::sim
