#include "host/web/web_server.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <string>
#include <thread>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A WebSocket client that stands for a page.
class Page {
 public:
  explicit Page(std::uint16_t port) : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in there{};
    there.sin_family = AF_INET;
    there.sin_port = htons(port);
    there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(socket_, reinterpret_cast<const sockaddr*>(&there), sizeof there), 0);
    const std::string here = "127.0.0.1:" + std::to_string(port);
    const std::string request =
        "GET /feed HTTP/1.1\r\nHost: " + here + "\r\nOrigin: http://" + here +
        "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n";
    EXPECT_EQ(write(socket_, request.data(), request.size()), static_cast<ssize_t>(request.size()));
  }
  ~Page() { close(socket_); }
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;

  /// Bytes received; nothing if there were none in time; negative once the server has hung up.
  ssize_t take(milliseconds patience) {
    pollfd ready{socket_, POLLIN, 0};
    if (poll(&ready, 1, static_cast<int>(patience.count())) == 0) return 0;
    std::array<char, 1 << 16> bytes;
    const ssize_t count = read(socket_, bytes.data(), bytes.size());
    return count > 0 ? count : -1;
  }

 private:
  int socket_;
};

TEST(WebServer, APageThatDoesNotReadIsDroppedAndNobodyWaitsForIt) {
  // More than all buffers between server and page hold.
  const auto large = std::make_shared<const FrameBytes>(8 << 20);
  std::atomic<std::uint64_t> revision = 0;
  WebServer server({.rules = {{}, "", false},
                    .assets = {},
                    .refresh = [&] { ++revision; },
                    .frame =
                        [&](std::uint64_t, std::int64_t) {
                          return Frame{revision, large};
                        }});
  std::jthread running([&](std::stop_token stop) { server.run(stop); });

  Page stalled(server.port()), reading(server.port());
  std::uint64_t taken = 0;
  // Twice the time that a stalled page may take for a frame.
  const WallTime end = WallClock::now() + 2 * WebServer::kFrameTime;
  while (WallClock::now() < end) {
    const ssize_t count = reading.take(seconds(5));
    ASSERT_GT(count, 0) << "the page that reads was kept waiting";
    taken += static_cast<std::uint64_t>(count);
  }
  EXPECT_GT(taken, 4 * large->size());

  std::uint64_t left = 0;  // bytes in the buffers
  ssize_t count = 0;
  while ((count = stalled.take(seconds(5))) > 0) left += static_cast<std::uint64_t>(count);
  EXPECT_LT(count, 0) << "the page that stalled is still connected";
  EXPECT_LT(left, large->size());
}

}  // namespace
}  // namespace roadbalance
