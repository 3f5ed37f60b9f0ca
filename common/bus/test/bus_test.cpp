#include "common/bus/bus.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
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

std::string failure_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(Bus, NamesTheAddressThatIsNoneAndDoesNotBlameTheNetwork) {
  const std::string text = failure_of([] { Bus bus("nonsense://1.2.3.4:5"); });
  EXPECT_NE(text.find("nonsense://1.2.3.4:5"), std::string::npos) << text;
  EXPECT_EQ(text.find("route"), std::string::npos) << text;
}

TEST(Bus, SaysThatAPortIsTakenAndDoesNotBlameTheNetwork) {
  const int port = 20'000 + (::getpid() + 7777) % 20'000;
  const int taken = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  ASSERT_EQ(::bind(taken, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  const std::string text = failure_of([&] {
    Bus bus(bus_url_on_port(port));
    bus.subscribe("RB_TEST", [](std::string_view, auto) {});
  });
  ::close(taken);
  EXPECT_NE(text.find(std::to_string(port)), std::string::npos) << text;
  EXPECT_NE(text.find("in use"), std::string::npos) << text;
  EXPECT_EQ(text.find("route"), std::string::npos) << text;
}

// A replayed log is a bus that ends: the only one that can be made to fail.
TEST(Bus, AFailureToReceiveIsNotSilence) {
  const auto log = std::filesystem::temp_directory_path() / ("rb-bus-" + std::to_string(::getpid()) + ".lcm");
  // Sync word, number, time, lengths of name and data (big endian), name, data.
  const std::string event =
      std::string("\xED\xA1\xDA\x01", 4) + std::string(16, '\0') + std::string("\0\0\0\1\0\0\0\1", 8) + "AB";
  std::ofstream(log, std::ios::binary) << event << event;
  Bus bus("file://" + log.string() + "?speed=0");
  int events = 0;
  bus.subscribe("A", [&](std::string_view, auto) { ++events; });
  const std::string text = failure_of([&] {
    for (int k = 0; k < 10; ++k) bus.handle(milliseconds(1000));
  });
  std::filesystem::remove(log);
  EXPECT_GT(events, 0);
  EXPECT_NE(text.find(log.string()), std::string::npos) << "10 times nothing came: " << text;
}

TEST(Bus, ItsDefaultAddressSetsTheReceiveBufferThatLcmDoesNot) {
  EXPECT_NE(default_bus_url().find("recv_buf_size=4194304"), std::string::npos);
  EXPECT_NE(default_bus_url().find("ttl=0"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance
