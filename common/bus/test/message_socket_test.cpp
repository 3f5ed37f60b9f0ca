#include "common/bus/message_socket.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <limits>
#include <string>

#include "common/bus/bus.hpp"
#include "common/bus/process_port.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;

/// A bus that listens, and a socket that sends it whatever it likes.
class Listening : public ::testing::Test {
 protected:
  Listening()
      : port_(process_port(2)),
        bus_(bus_url_on_port(port_), {.hears_all = true}),
        sender_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    bus_.subscribe(".*", [this](std::string_view channel, std::span<const std::uint8_t> bytes) {
      heard_.emplace_back(channel);
      sizes_.push_back(bytes.size());
    });
    const unsigned char ttl = 0;
    ::setsockopt(sender_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
  }
  ~Listening() override { ::close(sender_); }

  void send(const std::string& datagram) const {
    sockaddr_in group{};
    group.sin_family = AF_INET;
    group.sin_port = htons(static_cast<std::uint16_t>(port_));
    group.sin_addr.s_addr = inet_addr("239.255.76.67");
    ASSERT_EQ(::sendto(sender_, datagram.data(), datagram.size(), 0,
                       reinterpret_cast<const sockaddr*>(&group), sizeof group),
              static_cast<ssize_t>(datagram.size()));
  }

  /// Datagrams keep their order: when a good one behind them has come, all before it have been judged.
  void hear_all() {
    ASSERT_TRUE(bus_.publish("LAST", std::vector<std::uint8_t>{1}));
    while (heard_.empty() || heard_.back() != "LAST") ASSERT_GT(bus_.handle(milliseconds(2000)), 0);
  }

  const int port_;
  Bus bus_;
  const int sender_;
  std::vector<std::string> heard_;
  std::vector<std::size_t> sizes_;
};

const std::string kShort("LC02\0\0\0\1", 8);
const std::string kLong("LC03\0\0\0\1", 8);
std::string word(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
  return bytes;
}

TEST_F(Listening, AMessageOfOnePacketPasses) {
  send(kShort + std::string("RB_TEST\0data", 12));
  send(kShort + std::string(63, 'C') + std::string(1, '\0'));  // the longest name, no data
  hear_all();
  EXPECT_EQ(heard_, (std::vector<std::string>{"RB_TEST", std::string(63, 'C'), "LAST"}));
  EXPECT_EQ(sizes_, (std::vector<std::size_t>{4, 0, 1}));
  EXPECT_EQ(bus_.dropped(), 0);
}

// Each of the first two ends a process that listens with LCM 1.3.1.
TEST_F(Listening, WhatEndsAnLcmReceiverStaysOutside) {
  const std::string first_of_two("\0\0\0\2", 4);
  // At 2^32 - 16 of 100 bytes: offset + length wraps to less than the size.
  send(kLong + word(100) + word(0xFFFFFFF0) + first_of_two + std::string("A\0", 2) + std::string(32, 'x'));
  // A header cut short by one byte: the length of the fragment becomes 2^32 - 2.
  send(kLong + word(100) + word(60) + first_of_two.substr(0, 3));
  send(kLong + word(8) + word(0) + std::string("\0\0\0\1", 4) + std::string("RB_TEST\0deadbeef", 16));
  hear_all();
  EXPECT_EQ(heard_, std::vector<std::string>{"LAST"});
  EXPECT_EQ(bus_.dropped(), 3);
}

TEST_F(Listening, WhatIsNoMessageStaysOutsideAndIsCounted) {
  send("");
  send("L");
  send("LC02");
  send(kShort);
  send(kShort + "RB_TEST");  // a name without an end
  send(kShort + std::string(64, 'C') + std::string(1, '\0'));
  send(std::string("LC04\0\0\0\1RB_TEST\0data", 20));
  send(kShort + std::string("RB_TEST\0", 8) + std::string(MessageSocket::kLargestDatagram, 'x'));
  hear_all();
  EXPECT_EQ(heard_, std::vector<std::string>{"LAST"});
  EXPECT_EQ(bus_.dropped(), 8);
}

// The greatest LCM message of one packet has a name of 63 and fills the datagram.
TEST_F(Listening, TheLargestDatagramPasses) {
  const std::string head = kShort + std::string("RB_TEST\0", 8);
  send(head + std::string(MessageSocket::kLargestDatagram - head.size(), 'x'));
  send(head + std::string(MessageSocket::kLargestDatagram - head.size() + 1, 'x'));
  hear_all();
  EXPECT_EQ(sizes_, (std::vector<std::size_t>{MessageSocket::kLargestDatagram - head.size(), 1}));
  EXPECT_EQ(bus_.dropped(), 1);
}

// Less than the least that a kernel gives to all (net.core.rmem_max, 212 992).
TEST(MessageSocket, TellsWhatTheKernelGivesIt) {
  BusAddress bus;
  bus.port = static_cast<std::uint16_t>(process_port(3));
  bus.receive_buffer = 100'000;
  EXPECT_EQ(MessageSocket(bus, Runs::kCut).receive_buffer(), 100'000);
  bus.receive_buffer = std::numeric_limits<int>::max() / 4;
  const std::int64_t most = MessageSocket(bus, Runs::kCut).receive_buffer();
  EXPECT_GT(most, 100'000);
  EXPECT_LT(most, bus.receive_buffer) << "the kernel gives what its setting allows";
}

TEST(MessageSocket, WhatNobodyWantsStaysInTheKernel) {
  const std::string url = bus_url_on_port(process_port(3));
  Bus all(url, {.hears_all = true}), some(url);
  std::vector<std::string> heard;
  bool last = false;
  all.subscribe("LAST", [&](std::string_view, auto) { last = true; });
  for (const char* channels : {"RB_ACK_1", "RB_BLOCK_.*", "LAST", "A"})
    some.subscribe(channels, [&](std::string_view channel, auto) { heard.emplace_back(channel); });
  ASSERT_EQ(some.handle(milliseconds(0)), 0);  // listens from now on
  Bus sender(url);
  const std::vector<std::string> sent{"RB_ACK_1",  "RB_ACK_12", "RB_ACK_", "RB_BLOCK_1_SCAN",
                                      "RB_BLOCK_", "RB_BLOCK",  "A",       "RB_HEARTBEAT_1",
                                      "AA",        "B",         "LAST"};
  for (const std::string& channel : sent) ASSERT_TRUE(sender.publish(channel, {}));
  while (heard.empty() || heard.back() != "LAST") ASSERT_GT(some.handle(milliseconds(2000)), 0);
  EXPECT_EQ(heard, (std::vector<std::string>{"RB_ACK_1", "RB_BLOCK_1_SCAN", "RB_BLOCK_", "A", "LAST"}));
  EXPECT_EQ(some.dropped(), 6);
  while (!last) ASSERT_GT(all.handle(milliseconds(2000)), 0);
  EXPECT_EQ(all.dropped(), 0);
}

// A filter has 4096 instructions at most, and 100 names of 63 characters are more than a socket of Debian's
// kernel may hold.
TEST(MessageSocket, HoweverManyNamesAreWantedAreHeard) {
  for (const int names : {100, 300}) {
    const auto name = [](int k) { return std::to_string(100 + k) + std::string(60, 'C'); };
    const std::string url = bus_url_on_port(process_port(4));
    Bus bus(url), sender(url);
    std::vector<std::string> heard;
    for (int k = 0; k < names; ++k)
      bus.subscribe(name(k), [&](std::string_view channel, auto) { heard.emplace_back(channel); });
    ASSERT_EQ(bus.handle(milliseconds(0)), 0);
    for (const int k : {-1, 0, names / 2, names, names - 1}) ASSERT_TRUE(sender.publish(name(k), {}));
    while (heard.empty() || heard.back() != name(names - 1)) ASSERT_GT(bus.handle(milliseconds(2000)), 0);
    EXPECT_EQ(heard, (std::vector<std::string>{name(0), name(names / 2), name(names - 1)}));
  }
}

}  // namespace
}  // namespace roadbalance
