#include "tools/views/twin_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

const ChannelConfig& config_of(const RecordedTwin& twin, std::size_t c) {
  const TwinChannels::One& one = twin.channels.channel[c];
  return twin.vehicle.node[static_cast<std::size_t>(one.node)].channel[static_cast<std::size_t>(one.channel)];
}

const char* why(TwinState state) {
  switch (state) {
    case TwinState::kPredicted:
      return "told";
    case TwinState::kSettling:
      return "too short to settle";
    case TwinState::kNoSpeed:
      return "no wheel's angle is known";
    case TwinState::kTooSlow:
      return "too slow";
  }
  return "";
}

/// Accelerations that the model does not speak of.
std::vector<std::string> not_modelled(const RecordedTwin& twin) {
  std::vector<std::string> names;
  for (std::size_t n = 0; n < twin.vehicle.node.size(); ++n)
    for (std::size_t c = 0; c < twin.vehicle.node[n].channel.size(); ++c) {
      const bool modelled = std::ranges::any_of(twin.channels.channel, [&](const TwinChannels::One& one) {
        return one.node == static_cast<int>(n) && one.channel == static_cast<int>(c);
      });
      if (!modelled) names.push_back(twin.vehicle.node[n].channel[c].name);
    }
  return names;
}

std::string percent(double share) {
  char text[16];
  std::snprintf(text, sizeof text, "%.1f", 100.0 * share);
  return std::isfinite(share) ? text : "-";
}

std::string line(const std::string& name, const TwinAccount& account, int seconds) {
  char text[200];
  if (account.state != TwinState::kPredicted)
    std::snprintf(text, sizeof text, "%-24s not predicted: %s", name.c_str(), why(account.state));
  else
    std::snprintf(text, sizeof text, "%-24s %8.3f  %8.3f  %8.3f   %6s  %6s    %6s  %6s   %5d", name.c_str(),
                  account.all.measured, account.all.predicted, account.all.residual,
                  percent(account.all.share()).c_str(), percent(account.coherent_all).c_str(),
                  percent(account.hop.share()).c_str(), percent(account.coherent_hop).c_str(), seconds);
  return text;
}

Json figures_json(const TwinFigures& figures, double coherent) {
  return {{"measured_m_s2", figures.measured},
          {"predicted_m_s2", figures.predicted},
          {"residual_m_s2", figures.residual},
          {"explained", figures.share()},
          {"explainable", coherent}};
}

}  // namespace

std::vector<std::string> twin_lines(const RecordedTwin& twin) {
  const auto balanced = std::ranges::count(twin.car.balance, true);
  std::vector<std::string> lines{
      std::string("car: springs, dampers and tyres ") +
          (twin.car.identified ? "as this drive tells them" : "as vehicle.toml has them") +
          ", unbalance of " + std::to_string(balanced) + " wheels known",
      "channel                  measured predicted residual  explained, at most   10-25 Hz, at most  seconds",
      "                            m/s^2     m/s^2     m/s^2        %       %         %       %"};
  for (std::size_t c = 0; c < twin.total.size(); ++c)
    lines.push_back(line(config_of(twin, c).name, twin.total[c], twin.seconds[c]));
  if (const auto names = not_modelled(twin); !names.empty()) {
    std::string all = "not modelled:";
    for (const std::string& name : names) all += " " + name;
    lines.push_back(all);
  }
  return lines;
}

Json twin_json(const RecordedTwin& twin) {
  Json channels = Json::array();
  for (std::size_t c = 0; c < twin.total.size(); ++c) {
    const TwinAccount& account = twin.total[c];
    const TwinChannels::One& one = twin.channels.channel[c];
    Json json{{"node", twin.vehicle.node[static_cast<std::size_t>(one.node)].name},
              {"channel", config_of(twin, c).name},
              {"seconds", twin.seconds[c]},
              {"state", why(account.state)}};
    if (account.state == TwinState::kPredicted) {
      json["all"] = figures_json(account.all, account.coherent_all);
      json["hop_10_25_hz"] = figures_json(account.hop, account.coherent_hop);
    }
    channels.push_back(json);
  }
  return {{"identified", twin.car.identified},
          {"balance_known", twin.car.balance},
          {"behind_s", twin.behind_s},
          {"settling_s", twin.settling_s},
          {"channels", channels},
          {"not_modelled", not_modelled(twin)},
          {"damaged_bytes", twin.defects.damaged_bytes},
          {"blocks_refused", twin.defects.refused_blocks},
          {"blocks_missing", twin.defects.missing_blocks}};
}

}  // namespace roadbalance
