#include "host/analyser/follow_recordings.hpp"

#include <algorithm>
#include <atomic>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/control_messages.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/process/channel.hpp"
#include "common/process/parallel.hpp"
#include "common/types/clocks.hpp"
#include "host/analyser/live_view.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kPoll{50};
constexpr std::chrono::seconds kRecorderSilence{3};
// A node that goes on with its next epoch reports between two heartbeats that the one before has ended.
constexpr std::chrono::seconds kGone{2};
constexpr std::chrono::seconds kAgain{1};  // after what could not be read

/// The current recording, and whether any node is there to be recorded.
class Listener {
 public:
  explicit Listener(const std::string& url) : bus_(url) {
    bus_.subscribe(kRecorderChannel, [this](std::string_view, auto bytes) {
      const auto status = decode_recorder_status(bytes);
      if (status && status->operable && !status->name.empty()) name_ = status->name;
    });
    bus_.subscribe("RB_HEARTBEAT_.*", [this](std::string_view, auto bytes) {
      const auto beat = decode_heartbeat(bytes);
      if (!beat || (heard_.size() >= kMostNodes && !heard_.contains(beat->node))) return;
      heard_[beat->node] = {WallClock::now(), beat->is_over()};
    });
  }

  void listen() {
    bus_.handle(kPoll);
    const WallTime now = WallClock::now();
    const bool any_lives = std::ranges::any_of(heard_, [now](const auto& heard) {
      return !heard.second.is_over && now - heard.second.at < kRecorderSilence;
    });
    // Who has been recorded may have gone before this listened; before anything is recorded nodes may yet
    // come.
    const bool may_come = heard_.empty() && name_.empty();
    if (any_lives || may_come) lived_at_ = now;
  }

  /// Empty: nothing has been recorded yet.
  const std::string& name() const { return name_; }
  bool nodes_are_gone() const { return WallClock::now() - lived_at_ >= kGone; }

 private:
  struct Heard {
    WallTime at{};
    bool is_over = false;
  };
  Bus bus_;
  std::string name_;
  std::map<std::int32_t, Heard> heard_;
  WallTime lived_at_ = WallClock::now();
};

}  // namespace

void follow_recordings(std::stop_token stop, const std::filesystem::path& recordings,
                       const AnalyserOptions& options) {
  Listener listener(options.url);
  std::string fault;  // the last
  std::optional<VehicleConfig> vehicle;
  if (!options.vehicle.empty()) vehicle = VehicleConfig::read_file(options.vehicle.string());
  std::optional<Parallel> first_view;
  if (vehicle)
    first_view.emplace().run(live_view, options.url, *vehicle, vehicle_files_of(options),
                             std::cref(options.on_warning), make_channel<Ack>(1).first);
  while (!stop.stop_requested()) {
    listener.listen();
    if (first_view && first_view->stop_token().stop_requested()) first_view->wait();  // throws the reason
    if (listener.name().empty()) continue;
    first_view.reset();
    const std::string name = listener.name();
    std::atomic<bool> may_exit = false, is_over = false;
    AnalyserOptions one = options;
    one.record = recordings / name;
    one.find_before = true;
    one.may_exit = [&may_exit] { return may_exit.load(); };
    Parallel analyser;
    analyser.run([&](std::stop_token stop_here) {
      run_analyser(stop_here, one);
      is_over = true;
    });
    while (!stop.stop_requested() && !analyser.stop_token().stop_requested() && !is_over &&
           listener.name() == name) {
      listener.listen();
      may_exit = options.exit_at_end && listener.nodes_are_gone();
    }
    analyser.request_stop();
    try {
      analyser.wait();
    } catch (const std::system_error& error) {  // the disk went, and may come back
      if (options.exit_at_end) throw;
      if (std::exchange(fault, error.what()) != error.what()) options.on_warning(fault);
      for (const WallTime now = WallClock::now(); !stop.stop_requested() && WallClock::now() - now < kAgain;)
        listener.listen();
    }
    if (is_over && may_exit) return;
  }
}

}  // namespace roadbalance
