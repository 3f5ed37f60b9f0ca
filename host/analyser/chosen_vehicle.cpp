#include "host/analyser/chosen_vehicle.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/bus/control_messages.hpp"
#include "common/config/section.hpp"
#include "common/record/file.hpp"
#include "common/record/folder.hpp"
#include "common/text/format.hpp"
#include "common/types/text_crc.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
constexpr auto kVehicleSilence = 3s;
constexpr auto kLook = 1s;  ///< a file is written after its nodes have taken it

}  // namespace

VehicleByCrc vehicle_files_in(const std::filesystem::path& folder) {
  return [folder](std::uint32_t wanted) -> std::optional<VehicleConfig> {
    for (const std::string& name : list_folder(folder)) {
      if (!name.ends_with(".toml")) continue;
      const auto text = read_text(folder / name, kernel_disk(), Links::kFollowed);
      if (!text || crc32c(*text) != wanted) continue;
      try {
        return VehicleConfig::parse(*text, name);
      } catch (const ConfigError&) {
        continue;
      }
    }
    return std::nullopt;
  };
}

ChosenVehicle::ChosenVehicle(const VehicleConfig& now, VehicleByCrc find,
                             std::function<void(const std::string&)> warn)
    : crc32c_(crc32c(now.text)), find_(std::move(find)), warn_(std::move(warn)) {}

void ChosenVehicle::take(const NodeSetup& setup, WallTime now) {
  if (heard_.size() >= kMostNodes && !heard_.contains(setup.node)) return;
  heard_[setup.node] = {now, setup.vehicle_crc32c};
}

std::optional<VehicleConfig> ChosenVehicle::changed(WallTime now) {
  std::erase_if(heard_, [now](const auto& heard) { return now - heard.second.at > kVehicleSilence; });
  if (!find_ || heard_.empty() || now - looked_at_ < kLook) return std::nullopt;
  looked_at_ = now;
  const std::uint32_t wanted = heard_.begin()->second.crc32c;
  const bool agree =
      std::ranges::all_of(heard_, [wanted](const auto& heard) { return heard.second.crc32c == wanted; });
  if (!agree || wanted == crc32c_) return std::nullopt;
  if (auto found = find_(wanted)) {
    crc32c_ = wanted;
    return found;
  }
  if (std::exchange(not_found_, wanted) != wanted)
    warn_(
        format("the nodes measure by a vehicle.toml of CRC %08x that is not beside the one of --vehicle: "
               "levels go by the last one that is known",
               wanted));
  return std::nullopt;
}

}  // namespace roadbalance
