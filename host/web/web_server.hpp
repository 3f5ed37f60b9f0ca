#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "host/web/feed.hpp"
#include "host/web/guard.hpp"

namespace roadbalance {

/// A file of the page.  No other is served, whatever the path.
struct Asset {
  std::string_view path;  ///< "/page.js"
  std::string_view type;  ///< "text/javascript"
  std::string_view content;
};
/// The assets that the build embeds in the program.
std::span<const Asset> page_assets();

struct PostAnswer {
  std::uint16_t status = 200;
  std::string text{};  ///< plain
};
/// Handles POST requests of pages to one path.
struct Post {
  std::string_view path;  ///< "/view"
  /// It changes more than the view of its own page: so it needs the session's token even where watching needs
  /// none, and the type application/json.
  bool changes_state;
  /// Called in the server's thread: it must not block.
  /// @param from  address of the page's computer
  std::function<PostAnswer(std::string_view body, const std::string& from)> take;
};

struct WebServerOptions {
  std::string address = "127.0.0.1";  ///< to listen on, in numbers
  std::uint16_t port = 0;             ///< 0: a free one
  GuardRules rules{};                 ///< of admission
  std::span<const Asset> assets{};
  std::vector<Post> posts{};
  /// Both are called in the server's thread, WebServer::kPerSecond times a second: first refresh, then frame
  /// for each page, which returns the news since the page's revision.
  std::function<void()> refresh{};
  std::function<Frame(std::uint64_t revision, std::int64_t viewer)> frame{};
};

/// HTTP and WebSocket ("/feed") on one port: a client that is slow, sends too much or is one too many is
/// dropped, and never waited for.
class WebServer {
 public:
  static constexpr int kPerSecond = 20;  ///< frames to a page, at most
  static constexpr std::size_t kMostConnections = 64;
  static constexpr std::size_t kMostHeaderBytes = 8192;
  static constexpr std::size_t kMostBodyBytes = 16384;
  static constexpr std::size_t kMostBytesFromPage = 1024;  ///< on the feed, where a page sends nothing
  static constexpr int kSendBufferBytes = 128 << 10;       ///< in the kernel, for a page that does not read
  static constexpr std::chrono::seconds kRequestTime{10};  ///< to send a request, and to take its answer
  static constexpr std::chrono::seconds kFrameTime{5};     ///< to take a frame

  /// @throws std::system_error naming the address if it cannot listen there
  explicit WebServer(WebServerOptions options);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  std::uint16_t port() const;
  /// Process: ends when stop is requested.
  void run(std::stop_token stop);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roadbalance
