#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance {

/// Contents of a complete account of a drive beside its balance: those of `rb levels`, `rb spectrum`,
/// `rb orders`, `rb info` and `rb verify` with --json, made by the same code.
struct DriveAccount {
  /// Spectrum of one channel, as `rb spectrum --channel NAME`.
  struct Spectrum {
    const NodeConfig* node = nullptr;  ///< of the vehicle handed to account_of()
    const ChannelConfig* channel = nullptr;
    int averages = 0;          ///< 0: no stretch was long enough
    double independent = 0.0;  ///< averages that would scatter as much, side by side
    double step_hz = 0.0, enbw_hz = 0.0;
    std::vector<double> density{};  ///< [bins]
    std::string refusal{};         ///< why there is none, as far as it is known
  };
  nlohmann::ordered_json levels;   ///< null: not known
  nlohmann::ordered_json orders;   ///< an object for each wheel and node; null: not known
  nlohmann::ordered_json signals;  ///< of the car's bus; null: not known
  nlohmann::ordered_json proof;
  std::vector<Spectrum> spectrum{};
  std::vector<std::string> missing{};  ///< which part is not known, and why
};

/// Orders whose vectors it contains.
inline const std::vector<double> kAccountOrders{1.0, 2.0, 3.0, 4.0};

/// Reads the recording once for levels, spectra and signals, and once for the orders; memory does not grow
/// with its length.  Never throws for what is in the folder: parts that cannot be determined are in
/// `missing`.
/// @param vehicle  as recorded_vehicle(); nothing: it is not known.  Must outlive the result.
DriveAccount account_of(const std::filesystem::path& folder, const std::optional<VehicleConfig>& vehicle,
                        const Verification& proof);

}  // namespace roadbalance
