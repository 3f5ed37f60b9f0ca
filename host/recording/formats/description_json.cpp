#include "host/recording/formats/description_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

Json vector_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Json channel_json(const ExportChannel& channel) {
  return {{"name", channel.name},
          {"unit", channel.unit},
          {"node", channel.node},
          {"scale", channel.scale},
          {"offset_counts", channel.offset_counts},
          {"mount", channel.mount},
          {"position_m", vector_json(channel.position_m)},
          {"direction", vector_json(channel.direction)},
          {"range", channel.range},
          {"delay_s", channel.delay_s},
          {"overload", channel.overload}};
}

}  // namespace

nlohmann::ordered_json description_of(const ExportTable& table) {
  Json groups = Json::array();
  for (const auto& group : table.group) {
    Json channels = Json::array();
    for (const auto& channel : group.channel) channels.push_back(channel_json(channel));
    groups.push_back({{"name", group.name},
                      {"rate_hz", group.rate_hz},
                      {"first_s", static_cast<double>(group.first_ns) * 1e-9},
                      {"rows", group.rows},
                      {"channels", channels}});
  }
  Json marks = Json::array();
  for (const auto& mark : table.mark)
    marks.push_back(
        {{"time_s", static_cast<double>(mark.time_ns) * 1e-9}, {"number", mark.number}, {"text", mark.text}});
  Json left_out = Json::array();
  for (const auto& part : table.left_out)
    left_out.push_back({{"node", part.node}, {"samples", part.samples}});
  return {{"program", table.program},
          {"vehicle", table.vehicle},
          {"start_utc_us", table.start_utc_us ? Json(*table.start_utc_us) : Json()},
          {"start_by_clock", table.start_by_clock},
          {"groups", groups},
          {"marks", marks},
          {"left_out", left_out}};
}

std::string as_text(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', true, Json::error_handler_t::replace);
}

std::string description_json(const ExportTable& table) {
  return as_text(description_of(table));
}

}  // namespace roadbalance
