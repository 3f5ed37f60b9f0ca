#include "common/bus/bus.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <thread>
#include <vector>

#include "common/bus/process_port.hpp"
#include "common/bus/read_ahead.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;

const int kPort = 20'000 + ::getpid() % 20'000;

std::string url() {
  return bus_url_on_port(kPort);
}

/// In the sockets of our port.
bool something_waits() {
  std::ifstream table("/proc/net/udp");
  for (std::string line; std::getline(table, line);) {
    unsigned port = 0, waiting = 0;
    if (std::sscanf(line.c_str(), " %*d: %*x:%x %*x:%*x %*x %*x:%x", &port, &waiting) == 2 &&
        port == static_cast<unsigned>(kPort) && waiting > 0)
      return true;
  }
  return false;
}

/// Expects all of so many messages that are sent while nobody handles any.
void expect_all_of(int messages, const Bus::Options& options) {
  Bus bus(url(), options);
  std::vector<int> received;
  bus.subscribe("RB_TEST", [&](std::string_view, std::span<const std::uint8_t> bytes) {
    received.push_back(bytes[0] + 256 * bytes[1]);
  });
  bus.handle(milliseconds(0));
  for (int k = 0; k < messages; ++k) {
    const std::vector<std::uint8_t> bytes{static_cast<std::uint8_t>(k % 256),
                                          static_cast<std::uint8_t>(k / 256)};
    ASSERT_TRUE(bus.publish("RB_TEST", bytes));
    // Who reads ahead has its time, however slow it is here.
    while (options.ahead_bytes > 0 && k % 500 == 0 && something_waits())
      std::this_thread::sleep_for(milliseconds(1));
  }
  while (received.size() < static_cast<std::size_t>(messages) && bus.handle(milliseconds(2000)) > 0) {
  }
  ASSERT_EQ(received.size(), static_cast<std::size_t>(messages));
  for (int k = 0; k < messages; ++k) ASSERT_EQ(received[static_cast<std::size_t>(k)], k);
}

TEST(Bus, KeepsMoreThanLcmsThirtyMessagesWhileNobodyReads) {
  expect_all_of(500, {});
}

TEST(Bus, ReadingAheadKeepsMoreThanTheSocketHolds) {
  expect_all_of(20'000, {.ahead_bytes = 64 << 20});
}

// Memory holds what was asked for and what one call brings; the socket holds the rest.
TEST(Bus, ReadingAheadKeepsNoMoreThanItMay) {
  constexpr std::size_t kMessage = 1000, kAhead = HeldMessages::kRoom, kOneCall = 16 * 1024;
  Bus bus(url(), {.ahead_bytes = kAhead});
  std::size_t heard = 0;
  bus.subscribe("RB_TEST", [&heard](std::string_view, auto) { ++heard; });
  bus.handle(milliseconds(0));
  for (int k = 0; k < 20'000; ++k) ASSERT_TRUE(bus.publish("RB_TEST", std::vector<std::uint8_t>(kMessage)));
  while (bus.handle(milliseconds(200)) > 0) {
  }
  // The kernel doubles what is asked for, for what it keeps beside each message.
  EXPECT_LE(heard * kMessage, kAhead + kOneCall + 2 * static_cast<std::size_t>(kReceiveBufferBytes));
  EXPECT_GT(heard * kMessage, kAhead);
}

TEST(Bus, WhatComesBehindAMessageWhoseHandlerThrowsIsNotLost) {
  Bus bus(url());
  std::vector<int> received;
  bus.subscribe("RB_TEST", [&](std::string_view, std::span<const std::uint8_t> bytes) {
    received.push_back(bytes[0]);
    if (bytes[0] == 0) throw std::runtime_error("the handler's");
  });
  for (const char* k : {"\0", "\1", "\2"})
    ASSERT_TRUE(bus.publish("RB_TEST", std::vector<std::uint8_t>{static_cast<std::uint8_t>(*k)}));
  EXPECT_THROW(bus.handle(milliseconds(2000)), std::runtime_error);
  while (received.size() < 3 && bus.handle(milliseconds(2000)) > 0) {
  }
  EXPECT_EQ(received, (std::vector<int>{0, 1, 2}));
}

TEST(Bus, WaitsForAMessageThatSomebodyWants) {
  Bus bus(url(), {.hears_all = true});
  int wanted = 0;
  bus.subscribe("RB_TEST", [&](std::string_view, auto) { ++wanted; });
  const std::jthread sender([to = url()] {
    Bus other(to);
    for (int k = 0; k < 5; ++k) other.publish("RB_OTHER", std::vector<std::uint8_t>{1});
    std::this_thread::sleep_for(milliseconds(50));
    other.publish("RB_TEST", std::vector<std::uint8_t>{1});
  });
  EXPECT_EQ(bus.handle(milliseconds(20'000)), 1);
  EXPECT_EQ(wanted, 1);
}

TEST(Bus, RefusesAPatternThatIsNoBeginning) {
  Bus bus(url());
  EXPECT_THROW(bus.subscribe("RB_(A|B)", {}), std::invalid_argument);
  EXPECT_THROW(bus.subscribe("RB_.*_SCAN", {}), std::invalid_argument);
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

/// Puts something that cannot be received from in the place of every socket on this port.
void break_sockets_on(int port) {
  for (int descriptor = 3; descriptor < 256; ++descriptor) {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
        ntohs(address.sin_port) != port)
      continue;
    const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    ASSERT_EQ(::dup2(nothing, descriptor), descriptor);
    ::close(nothing);
  }
}

TEST(Bus, AFailureToReceiveIsNotSilence) {
  const int port = process_port(5);
  for (const std::size_t ahead : {0, 1 << 20}) {
    Bus bus(bus_url_on_port(port), {.ahead_bytes = ahead});
    bus.subscribe("A", [](std::string_view, auto) {});
    break_sockets_on(port);
    const std::string text = failure_of([&] {
      for (int k = 0; k < 10; ++k) bus.handle(milliseconds(1000));
    });
    EXPECT_NE(text.find("receive from LCM bus " + bus_url_on_port(port)), std::string::npos)
        << "10 times nothing came: " << text;
  }
}

std::int64_t receive_buffer_of(const std::string& options) {
  Bus bus("udpm://239.255.76.67:" + std::to_string(process_port(6)) + options);
  EXPECT_EQ(bus.receive_buffer(), 0) << "nothing is received yet";
  bus.subscribe("A", [](std::string_view, auto) {});
  return bus.receive_buffer();
}

// Without asking there would be net.core.rmem_default, counted as twice what is asked for.
TEST(Bus, AnAddressThatSaysNothingOfTheReceiveBufferGetsTheRecorders) {
  const std::int64_t asked = receive_buffer_of("?ttl=0&recv_buf_size=4194304");
  for (const char* unasked : {"", "?ttl=0", "?ttl=1"})
    EXPECT_EQ(receive_buffer_of(unasked), asked) << unasked;
  EXPECT_EQ(receive_buffer_of("?ttl=0&recv_buf_size=20000"), 20'000) << "who says it gets it";
  EXPECT_NE(receive_buffer_of("?ttl=0&recv_buf_size=0"), asked) << "0 leaves it to the kernel";
}

TEST(Bus, WithoutALineInTheEnvironmentItsAddressStaysOnThisMachine) {
  ::unsetenv(kBusUrlVariable);
  EXPECT_EQ(default_bus_url(), "udpm://239.255.76.67:7667?ttl=0");
  ::setenv(kBusUrlVariable, "", 1);  // as LCM takes it
  EXPECT_EQ(default_bus_url(), "udpm://239.255.76.67:7667?ttl=0");
  ::unsetenv(kBusUrlVariable);
}

TEST(Bus, NamesTheEnvironmentsLineThatIsNoAddress) {
  ::setenv(kBusUrlVariable, "nonsense://1.2.3.4:5", 1);
  const std::string text = failure_of([] { Bus bus(default_bus_url()); });
  EXPECT_NE(text.find("nonsense://1.2.3.4:5 of LCM_DEFAULT_URL: not an LCM address"), std::string::npos)
      << text;
  const std::string typed = failure_of([] { Bus bus("other://1.2.3.4:5"); });
  EXPECT_EQ(typed.find(kBusUrlVariable), std::string::npos) << typed;
  ::setenv(kBusUrlVariable, "udpm://239.255.76.67:7667?ttl=far", 1);
  const std::string unread = failure_of([] { Bus(default_bus_url()).subscribe("A", [](auto, auto) {}); });
  EXPECT_NE(unread.find("LCM_DEFAULT_URL"), std::string::npos) << unread;
  ::unsetenv(kBusUrlVariable);
}

}  // namespace
}  // namespace roadbalance
