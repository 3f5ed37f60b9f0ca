#include "host/analyser/analyser.hpp"

#include <chrono>
#include <functional>
#include <optional>
#include <thread>

#include "common/process/channel.hpp"
#include "common/process/parallel.hpp"
#include "common/record/folder.hpp"
#include "host/analyser/follow_record.hpp"
#include "host/analyser/live_view.hpp"
#include "host/analysis/drives/before_drive.hpp"
#include "host/recording/recorded_vehicle.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kMostAcks = 256;  // five a second of a node

}  // namespace

VehicleByCrc vehicle_files_of(const AnalyserOptions& options) {
  return options.vehicle.empty() ? VehicleByCrc() : vehicle_files_in(folder_of(options.vehicle));
}

void run_analyser(std::stop_token stop, const AnalyserOptions& wanted) {
  AnalyserOptions options = wanted;
  std::optional<VehicleConfig> vehicle;
  while (!(vehicle = recorded_vehicle(options.record))) {
    if (stop.stop_requested()) return;
    std::this_thread::sleep_for(kRecordPoll);
  }
  if (options.before.empty() && options.find_before)
    options.before = drive_before_weights(options.record, *vehicle).value_or("");

  Parallel processes;
  const std::stop_callback pass_on(stop, [&] { processes.request_stop(); });
  auto [acks_out, acks_in] = make_channel<Ack>(kMostAcks);
  processes.run(live_view, options.url, *vehicle, vehicle_files_of(options), std::cref(options.on_warning),
                std::move(acks_out));
  auto [before_out, before_in] = make_channel<BalancedDrive>(1);
  processes.run([&, before = std::move(before_in), acks = std::move(acks_in)](std::stop_token here) mutable {
    follow_record(here, options, *vehicle, std::move(before), std::move(acks));
    processes.request_stop();
  });
  if (!options.before.empty())
    processes.run(recall_before, options.before, std::move(before_out), std::cref(options.on_warning));
  processes.wait();
}

}  // namespace roadbalance
