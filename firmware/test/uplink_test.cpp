#include "firmware/uplink.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/process/parallel.hpp"
#include "common/test/bus_url.hpp"
#include "firmware/test/little_recorder.hpp"
#include "firmware/test/sealed_epoch.hpp"

namespace roadbalance {
namespace {

constexpr std::int32_t kNode = 3;

// The recorder has given credit and asks for repairs, so that there is always something to send.
TEST(Uplink, OpensABusThatFailsAgainAndSpendsNothingWhileThereIsNone) {
  const std::string url = test::bus_url();
  Ring ring;
  for (const SealedBlock& block : test::blocks_of(test::marked_scans(0, 60'000, test::kRate_hz), {})) {
    *ring.claim() = block;
    ring.commit();
  }
  const std::int64_t end = ring.next() - 1;
  Backlog backlog(ring);
  const auto preview = std::make_unique<PreviewSlot>();
  AcquireLink acquire;
  acquire.state = NodeState::kEnded;
  VehicleChange vehicle("", false);
  NodeLink link(kNode, test::kEpoch, backlog, *preview, acquire, vehicle);

  int opened = 0, acks = 0;
  std::int64_t sent_before = 0, sent_after = 0;
  const auto open = [&] {
    if (++opened == 2 || opened == 3) throw std::runtime_error("there is no bus");
    auto bus = open_node_bus(url, kNode, link);
    sent_after = link.sender().blocks_sent();
    if (opened == 1)
      bus->subscribe(ack_channel(kNode), [&](std::string_view, std::span<const std::uint8_t>) {
        if (++acks < 3) return;
        sent_before = link.sender().blocks_sent();
        throw std::runtime_error("there is no bus");  // handle() throws it
      });
    return bus;
  };
  std::vector<std::string> warned;
  test::LittleRecorder owner(url, kNode);
  Parallel processes;
  processes.run([&](std::stop_token stop) { owner.run(stop); });
  processes.run([&](std::stop_token stop) {
    uplink(stop, open, link, [&](const std::string& sentence) { warned.push_back(sentence); });
  });
  processes.wait();

  EXPECT_EQ(opened, 4);
  EXPECT_GT(sent_before, 0);
  EXPECT_LT(sent_before, end);
  EXPECT_EQ(sent_after, sent_before);
  EXPECT_EQ(static_cast<std::int64_t>(owner.blocks.size()), end) << "all came in the end";
  EXPECT_EQ(owner.last.blocks_unsent, 0);
  EXPECT_EQ(warned, std::vector<std::string>{"there is no bus; sampling goes on, the bus is tried again"});
}

}  // namespace
}  // namespace roadbalance
