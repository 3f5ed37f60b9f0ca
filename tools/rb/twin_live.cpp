#include "tools/rb/twin_live.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/clock/clocks.hpp"
#include "common/process/stop_on_signal.hpp"
#include "host/analyser/in_sequence.hpp"
#include "host/twin/live_twin.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/readout.hpp"
#include "tools/rb/twin_table.hpp"

namespace roadbalance {
namespace {

/// What the bus brings, to the twin.
class Listener {
 public:
  Listener(const LiveTwinOptions& options, const VehicleConfig& vehicle)
      : options_(options),
        bus_(options.url, {.ahead_bytes = kAhead}),
        twin_(vehicle, [this](const TwinSecond& s) { tell(s); }) {
    now_.vehicle = vehicle;
    now_.channels = twin_.channels();
    now_.seconds.assign(now_.channels.channel.size(), 0);
    bus_.subscribe("RB_BLOCK_.*", [this](std::string_view, auto bytes) {
      if (accept(bytes, *block_) == Refusal::kNone)
        sequence_.add(*block_, [this](const SealedBlock& block) { twin_.consume(block); });
    });
    bus_.subscribe("RB_CLOCK_.*", [this](std::string_view, auto bytes) {
      if (const auto fit = decode_clock_fit(bytes)) twin_.consume(*fit);
    });
    bus_.subscribe(kIdentificationChannel, [this](std::string_view, auto bytes) {
      if (const auto identification = decode_identification(bytes)) twin_.take(*identification);
    });
    bus_.subscribe(kBalanceChannel, [this](std::string_view, auto bytes) {
      if (const auto balance = decode_balance(bytes)) twin_.take(*balance);
    });
  }

  void listen() {
    bus_.handle(std::chrono::milliseconds(100));
    for (const std::string& sentence : bus_.other_versions())
      std::fprintf(stderr, "rb twin: %s\n", sentence.c_str());
    if (const std::string why = twin_.no_common_time(); why != said_) {
      if (!why.empty()) std::fprintf(stderr, "rb twin: %s\n", why.c_str());
      said_ = why;
    }
    if (const auto missing = sequence_.missing(); missing > missed_) {
      std::fprintf(stderr, "rb twin: %lld blocks have not come by themselves\n",
                   static_cast<long long>(missing - missed_));
      missed_ = missing;
    }
  }

  bool told_any() const {
    return std::ranges::any_of(now_.seconds, [](int seconds) { return seconds > 0; });
  }

 private:
  void tell(const TwinSecond& second) {
    now_.total.clear();
    now_.car = twin_.car();
    for (std::size_t c = 0; c < second.channel.size(); ++c) {
      now_.total.push_back(second.channel[c].account);
      now_.seconds[c] += now_.total.back().state == TwinState::kTold;
    }
    if (options_.json) {
      nlohmann::ordered_json json{{"time_s", 1e-9 * static_cast<double>(second.time_ns)},
                                  {"speed_m_s", second.speed_m_s}};
      json.update(twin_json(now_));
      std::printf("%s\n", json.dump().c_str());
      std::fflush(stdout);
    } else {
      screen_.draw(twin_lines(now_), true);
    }
  }

  /// A drive that is played faster than it can be predicted waits: some seconds of four nodes at 10 kHz.
  static constexpr std::size_t kAhead = 64 << 20;

  const LiveTwinOptions& options_;
  Bus bus_;
  Screen screen_;
  InSequence sequence_{InSequence::From::kFirstHeard};
  std::int64_t missed_ = 0;
  RecordedTwin now_{};
  LiveTwin twin_;
  std::string said_;
  std::unique_ptr<SealedBlock> block_ = std::make_unique<SealedBlock>();
};

}  // namespace

int show_live_twin(const LiveTwinOptions& options) {
  const StopOnSignal signals;
  Listener listener(options, VehicleConfig::read_file(options.vehicle));
  const WallTime begin = WallClock::now();
  const auto over = [&] {
    return options.seconds > 0.0 &&
           std::chrono::duration<double>(WallClock::now() - begin).count() > options.seconds;
  };
  while (!signals.token().stop_requested() && !over()) listener.listen();
  if (listener.told_any()) return kDone;
  std::fprintf(stderr, "rb twin: no channel was predicted: no drive on the bus, or too short\n");
  return kAnswerIsNo;
}

}  // namespace roadbalance
