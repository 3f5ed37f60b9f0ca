#include "host/analyser/analyser.hpp"

#include <chrono>
#include <functional>
#include <optional>
#include <thread>

#include "common/process/parallel.hpp"
#include "host/analyser/follow_record.hpp"
#include "host/analyser/live_view.hpp"
#include "host/analyser/recorded_vehicle.hpp"

namespace roadbalance {

void run_analyser(std::stop_token stop, const AnalyserOptions& options) {
  std::optional<VehicleConfig> vehicle;
  while (!(vehicle = recorded_vehicle(options.record))) {
    if (stop.stop_requested()) return;
    std::this_thread::sleep_for(kRecordPoll);
  }

  Parallel processes;
  const std::stop_callback pass_on(stop, [&] { processes.request_stop(); });
  processes.run(live_view, options.url, *vehicle, std::cref(options.on_warning));
  processes.run([&](std::stop_token stop_here) {
    follow_record(stop_here, options, *vehicle);
    processes.request_stop();
  });
  processes.wait();
}

}  // namespace roadbalance
