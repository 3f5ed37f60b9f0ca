#include "host/web/request_json.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

namespace roadbalance {
namespace {

using Json = nlohmann::json;

constexpr std::array<std::pair<std::string_view, Operation>, 12> kNames{{{"start", Operation::kStart},
                                                                         {"stop", Operation::kStop},
                                                                         {"mark", Operation::kMark},
                                                                         {"range", Operation::kRange},
                                                                         {"filter", Operation::kFilter},
                                                                         {"zero", Operation::kZero},
                                                                         {"vehicle", Operation::kVehicle},
                                                                         {"job", Operation::kJob},
                                                                         {"cancel", Operation::kCancel},
                                                                         {"scale", Operation::kScale},
                                                                         {"reading", Operation::kReading},
                                                                         {"datum", Operation::kDatum}}};

[[noreturn]] void refuse(const std::string& why) {
  throw std::invalid_argument(why);
}

std::int64_t whole_number(const Json& json, const std::string& key) {
  if (!json.is_number_integer()) refuse(key + " is no whole number");
  if (json.is_number_unsigned() && json.get<std::uint64_t>() >= static_cast<std::uint64_t>(kRequestLimit))
    refuse(key + " is too large");
  return json.get<std::int64_t>();
}

Operation operation_of(const Json& json) {
  const std::string name = json.is_string() ? json.get<std::string>() : "";
  for (const auto& [known, operation] : kNames)
    if (known == name) return operation;
  refuse(
      "operation is none of start, stop, mark, range, filter, zero, vehicle, job, cancel, scale, reading, "
      "datum");
}

void take_values(const Json& json, Request& request) {
  if (!json.is_array() || json.size() > request.value.size())
    refuse("value is no array of one or two numbers");
  for (std::size_t k = 0; k < json.size(); ++k) {
    if (!json[k].is_number()) refuse("value is no array of one or two numbers");
    request.value[k] = json[k].get<double>();
  }
}

void take(const std::string& key, const Json& json, Request& request) {
  if (key == "asker") {
    request.asker = whole_number(json, key);
  } else if (key == "request") {
    request.request = whole_number(json, key);
  } else if (key == "operation") {
    request.operation = operation_of(json);
  } else if (key == "node" || key == "channel") {
    const std::int64_t number = whole_number(json, key);
    if (number < -1 || number > 9999) refuse(key + " is out of bounds");
    (key == "node" ? request.node : request.channel) = static_cast<std::int32_t>(number);
  } else if (key == "value") {
    take_values(json, request);
  } else if (key == "text") {
    if (!json.is_string() || json.get_ref<const std::string&>().size() > kMostRequestText)
      refuse("text is no text of at most " + std::to_string(kMostRequestText) + " bytes");
    request.text = json.get<std::string>();
  } else {
    refuse("unknown key");  // the key may be anything: it is not repeated
  }
}

}  // namespace

std::variant<Request, std::string> parse_request(std::string_view body) {
  const auto no_nesting = [](int depth, Json::parse_event_t, const Json&) {
    if (depth > 3) refuse("too deep");
    return true;
  };
  try {
    const Json json = Json::parse(body, no_nesting, false);
    if (!json.is_object()) refuse("no JSON object");
    for (const char* key : {"asker", "request", "operation"})
      if (!json.contains(key)) refuse(std::string(key) + " is missing");
    Request request;
    for (const auto& [key, value] : json.items()) take(key, value, request);
    // The decoder of the bus is the only judge of what may be sent.
    const auto heard = decode_request(encode(request));
    if (!heard) refuse("a number cannot be");
    if (heard->text != request.text) refuse("text has control characters");
    return request;
  } catch (const std::exception& error) {
    return std::string(error.what());
  }
}

std::string_view name_of(Operation operation) {
  for (const auto& [name, known] : kNames)
    if (known == operation) return name;
  return {};
}

}  // namespace roadbalance
