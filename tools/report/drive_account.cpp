#include "tools/report/drive_account.hpp"

#include <memory>
#include <stdexcept>

#include "host/analysis/orders/orders_of_record.hpp"
#include "host/recording/read_recording.hpp"
#include "tools/views/orders_json.hpp"
#include "tools/views/record_levels.hpp"
#include "tools/views/recorded_spectra.hpp"
#include "tools/views/signal_survey.hpp"
#include "tools/views/verification_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

/// Every channel on its own, so that one out of its range cuts no other's segments.
class AllSpectra {
 public:
  explicit AllSpectra(const VehicleConfig& vehicle) : vehicle_(vehicle) {
    for (std::size_t n = 0; n < vehicle.node.size(); ++n)
      for (std::size_t c = 0; c < vehicle.node[n].channel.size(); ++c) {
        const ChannelPlace place{static_cast<int>(n), static_cast<int>(c)};
        places_.push_back(place);
        spectra_.push_back(std::make_unique<JointSpectra>(
            vehicle, std::vector{place},
            JointSpectra::Settings{.segment = segment_samples(kSegment_s, vehicle.node[n].rate_hz)}));
      }
  }

  void consume(const SealedBlock& block) {
    for (std::size_t k = 0; k < places_.size(); ++k)
      if (vehicle_.node[static_cast<std::size_t>(places_[k].node)].id == block.header.node)
        spectra_[k]->consume(block);
  }

  std::vector<DriveAccount::Spectrum> result() const {
    std::vector<DriveAccount::Spectrum> all;
    for (std::size_t k = 0; k < places_.size(); ++k) {
      const NodeConfig& node = vehicle_.node[static_cast<std::size_t>(places_[k].node)];
      const CrossSpectra& of = spectra_[k]->spectra();
      all.push_back({.node = &node,
                     .channel = &node.channel[static_cast<std::size_t>(places_[k].channel)],
                     .averages = of.averages(),
                     .independent = of.averages() > 0 ? of.independent_averages() : 0.0,
                     .step_hz = of.step_hz(),
                     .enbw_hz = of.enbw_hz(),
                     .density = of.averages() > 0 ? of.density(0) : std::vector<double>{},
                     .refusal = spectra_[k]->refusal()});
    }
    return all;
  }

 private:
  const VehicleConfig& vehicle_;
  std::vector<ChannelPlace> places_;
  std::vector<std::unique_ptr<JointSpectra>> spectra_;
};

void put_signals_and_levels(const std::filesystem::path& folder, const VehicleConfig& vehicle,
                            DriveAccount& account) {
  RecordLevels levels;
  AllSpectra spectra(vehicle);
  SignalSurvey signals;
  read_recording(
      folder, [&](const VehicleConfig& recorded) { levels.begin(recorded); },
      [&](const SealedBlock& block) {
        levels.consume(block);
        spectra.consume(block);
        signals.add(block);
      },
      [&](const ClockFit& fit) { levels.consume(fit); });
  account.levels = levels.json();
  account.spectrum = spectra.result();
  account.signals = signals_json(signals, &vehicle);
}

void put_orders(const std::filesystem::path& folder, DriveAccount& account) {
  WantedOrders wanted;
  wanted.order = kAccountOrders;
  const RecordOrders found = orders_of_record(folder, wanted);
  account.orders = Json::array();
  for (const auto& rotor : found.rotor) account.orders.push_back(rotor_json(found, *rotor, false));
}

}  // namespace

DriveAccount account_of(const std::filesystem::path& folder, const std::optional<VehicleConfig>& vehicle,
                        const Verification& proof) {
  DriveAccount account{.levels = {}, .orders = {}, .signals = {}, .proof = verification_json(proof)};
  if (!vehicle) {
    account.missing.push_back("levels, spectra and orders: the vehicle is not known");
    return account;
  }
  try {
    put_signals_and_levels(folder, *vehicle, account);
  } catch (const std::exception& error) {
    account.missing.push_back(std::string("levels and spectra: ") + error.what());
  }
  try {
    put_orders(folder, account);
  } catch (const std::exception& error) {
    account.missing.push_back(std::string("orders: ") + error.what());
  }
  return account;
}

}  // namespace roadbalance
