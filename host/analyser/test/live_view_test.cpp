#include "host/analyser/live_view.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <string>
#include <thread>

#include "common/bus/bus.hpp"
#include "common/bus/results.hpp"
#include "common/bus/transfer_function_report.hpp"
#include "common/test/bus_url.hpp"
#include "host/analyser/test/noise_drive.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
using test::car, test::kFront, test::kRear;

TEST(LiveView, TellsATransferFunctionToWhoAsksForItOnTheBus) {
  const std::string url = test::bus_url();
  std::jthread process([&](const std::stop_token& stop) {
    live_view(
        stop, url, car(), {}, [](const auto&) {}, make_channel<Ack>(1).first);
  });
  Bus bus(url);
  std::optional<TransferFunctionPart> received;
  bool levels = false;
  bool too_short = false;
  bus.subscribe(kTransferFunctionChannel, [&](std::string_view, std::span<const std::uint8_t> bytes) {
    const auto part = decode_transfer_function(bytes);
    ASSERT_TRUE(part);
    if (part->state == SpectralState::kComputed) received = part;
    too_short = too_short || part->state == SpectralState::kTooShort;
  });
  bus.subscribe(kLevelChannel, [&](std::string_view, std::span<const std::uint8_t> bytes) {
    levels = levels || decode_level(bytes);
  });
  const View view{.viewer = 9,
                  .segment = 1024,
                  .pair = {{{car().node[0].id, kFront.channel}, {car().node[1].id, kRear.channel}}}};
  test::NoiseDrive drive;
  // Not a limit of the product's: a test that hears nothing has to end.
  for (const auto end = WallClock::now() + 60s; !received && WallClock::now() < end;) {
    bus.publish(kViewChannel, encode(view));
    for (const int node : {0, 1}) {
      const SealedBlock block = drive.next(node);
      bus.publish(block_channel(block.header.node, block.kind), block.bytes());
    }
    bus.handle(5ms);
  }
  ASSERT_TRUE(received);
  EXPECT_EQ(received->viewer, 9);
  EXPECT_EQ(received->pair.output.channel, kRear.channel);
  EXPECT_FALSE(received->bin.empty());
  EXPECT_TRUE(too_short) << "what is not there yet is said";
  EXPECT_TRUE(levels);
}

}  // namespace
}  // namespace roadbalance
