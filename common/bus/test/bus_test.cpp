#include "common/bus/bus.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <stdexcept>
#include <vector>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;

std::string url() {
  return bus_url_on_port(20'000 + ::getpid() % 20'000);
}

TEST(Bus, QueuesMoreThanLcmsThirtyMessagesWhileNobodyReads) {
  Bus bus(url());
  std::vector<int> received;
  bus.subscribe("RB_TEST", [&](std::string_view, std::span<const std::uint8_t> bytes) {
    received.push_back(bytes[0] + 256 * bytes[1]);
  });
  constexpr int kMessages = 500;
  for (int k = 0; k < kMessages; ++k) {
    const std::vector<std::uint8_t> bytes{static_cast<std::uint8_t>(k % 256),
                                          static_cast<std::uint8_t>(k / 256)};
    ASSERT_TRUE(bus.publish("RB_TEST", bytes));
  }
  while (received.size() < kMessages && bus.handle(milliseconds(2000)) > 0) {
  }
  ASSERT_EQ(received.size(), static_cast<std::size_t>(kMessages));
  for (int k = 0; k < kMessages; ++k) EXPECT_EQ(received[static_cast<std::size_t>(k)], k);
}

TEST(Bus, APatternIsOfTheWholeChannelName) {
  Bus bus(url());
  std::vector<std::string> channels;
  bus.subscribe("RB_ACK_1", [&](std::string_view channel, auto) { channels.emplace_back(channel); });
  const std::vector<std::uint8_t> byte{1};
  ASSERT_TRUE(bus.publish("RB_ACK_12", byte));
  ASSERT_TRUE(bus.publish("RB_ACK_1", byte));
  while (channels.empty() && bus.handle(milliseconds(2000)) > 0) {
  }
  bus.handle(milliseconds(0));
  EXPECT_EQ(channels, std::vector<std::string>{"RB_ACK_1"});
}

TEST(Bus, AHandlersExceptionReachesTheCaller) {
  Bus bus(url());
  bus.subscribe("RB_TEST", [](std::string_view, auto) { throw std::runtime_error("the handler's"); });
  ASSERT_TRUE(bus.publish("RB_TEST", std::vector<std::uint8_t>{1}));
  EXPECT_THROW(bus.handle(milliseconds(2000)), std::runtime_error);
}

TEST(Bus, NamesTheAddressItCannotOpenAndTheRemedy) {
  try {
    Bus bus("nonsense://1.2.3.4:5");
    FAIL() << "opened";
  } catch (const std::runtime_error& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("nonsense://1.2.3.4:5"), std::string::npos) << text;
    EXPECT_NE(text.find("ip route add"), std::string::npos) << text;
  }
}

TEST(Bus, ItsDefaultAddressSetsTheReceiveBufferThatLcmDoesNot) {
  EXPECT_NE(default_bus_url().find("recv_buf_size=4194304"), std::string::npos);
  EXPECT_NE(default_bus_url().find("ttl=0"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance
