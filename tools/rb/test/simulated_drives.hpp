#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "common/config/vehicle_config.hpp"
#include "common/record/record_writer.hpp"
#include "common/test/source.hpp"
#include "firmware/epoch_packer.hpp"
#include "sim/front_end.hpp"

namespace roadbalance::test {

/// The demo car at 500 scans a second.
inline std::string slow_car() {
  std::string text = read_source("sim/demo/vehicle.toml");
  text = replaced(text, "\nrate_hz = 2000", "\nrate_hz = 500");
  return replaced(text, "\ncutoff_hz = 200", "\ncutoff_hz = 60");
}

/// Records what each node of the simulated car samples, one after another; its epoch is first_epoch + its id.
/// @param scenario  as a `sim:` URI has it after the colon, without the rate
inline void record_scenario(const std::filesystem::path& folder, const VehicleConfig& vehicle,
                            const std::string& scenario, std::int64_t first_epoch = 0) {
  RecordWriter writer({.folder = folder});
  for (const NodeConfig& node : vehicle.node) {
    const auto device = sim::open_sim_front_end({scenario + "&rate=max", vehicle, node});
    pack_epoch(*device, vehicle, node, first_epoch + node.id,
               [&](const SealedBlock& block) { writer.append(block, 1000); });
  }
  writer.close();
}

/// A drive of the one car that is as its vehicle.toml describes it, on a road of its own.
struct SimulatedDrive {
  std::uint64_t seed;
  double speed_km_h = 120.0;
  double seconds = 40.0;
  const char* road_class = "A";
};

/// Unbalances of the demo's scenario, by wheel.
inline constexpr std::array kDrivenUnbalance_g{35.0, 20.0, 12.0, 14.0};
inline constexpr std::array kDrivenAngle_deg{217.0, 60.0, 305.0, 128.0};

/// The mass of one wheel is another than in kDrivenUnbalance_g.
struct OtherMass {
  std::size_t wheel;
  double mass_g;
};

/// Records it in `folder`.
inline void record_drive(const SimulatedDrive& drive, const std::filesystem::path& folder,
                         const std::string& vehicle_toml, const std::optional<OtherMass>& other = {}) {
  const VehicleConfig vehicle = VehicleConfig::parse(vehicle_toml, "vehicle.toml");
  const std::string demo = read_source("sim/demo/scenario.toml");
  std::string scenario = "[drive]\nramp_s = 6\nwander_km_h = 0.5\n[[drive.plateau]]\nspeed_km_h = " +
                         std::to_string(drive.speed_km_h) + "\nseconds = " + std::to_string(drive.seconds) +
                         "\n" + demo.substr(demo.find("[road]"));
  scenario = replaced(scenario, "class = \"A\"", std::string("class = \"") + drive.road_class + "\"");
  scenario = replaced(scenario, "parameters = 0.10", "parameters = 0.0");
  if (other) {
    const auto mass = [](double grams) { return "mass_g = " + std::to_string(grams).substr(0, 4); };
    scenario = replaced(scenario, mass(kDrivenUnbalance_g[other->wheel]), mass(other->mass_g));
  }
  const std::filesystem::path file = folder.string() + ".scenario.toml";
  std::ofstream(file) << scenario;
  record_scenario(folder, vehicle, file.string() + "?seed=" + std::to_string(drive.seed),
                  static_cast<std::int64_t>(1000 * drive.seed));
  std::filesystem::remove(file);
}

}  // namespace roadbalance::test
