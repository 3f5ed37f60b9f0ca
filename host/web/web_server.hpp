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

/// A file of the page.  No other is served, whatever a path says.
struct Asset {
  std::string_view path;  ///< "/page.js"
  std::string_view type;  ///< "text/javascript"
  std::string_view content;
};
/// Those that the build has put into the program.
std::span<const Asset> page_assets();

struct PostAnswer {
  std::uint16_t status = 200;
  std::string text{};  ///< plain
};
/// What a page may say, by POST to a path.
struct Post {
  std::string_view path;  ///< "/view"
  /// It changes more than what is shown to this page, so it needs the session's token even where watching
  /// needs none, and comes as application/json.
  bool changes_state;
  /// In the server's own thread: it may not wait.
  std::function<PostAnswer(std::string_view body)> take;
};

struct WebServerOptions {
  std::string address = "127.0.0.1";  ///< to listen on, a number
  std::uint16_t port = 0;             ///< 0: a free one
  GuardRules rules{};                 ///< who may speak to it
  std::span<const Asset> assets{};
  std::vector<Post> posts{};
  /// Both in the server's own thread, WebServer::kPerSecond times a second: first refresh, then frame for
  /// each page, with the revision it has and the number it calls itself by: what is new since.
  std::function<void()> refresh{};
  std::function<Frame(std::uint64_t revision, std::int64_t viewer)> frame{};
};

/// HTTP and WebSocket ("/feed") on one port, without mathematics and without mercy: whoever is slow, long or
/// one too many is dropped, and never waited for.
class WebServer {
 public:
  static constexpr int kPerSecond = 20;  ///< frames to a page, at most
  static constexpr std::size_t kMostConnections = 64;
  static constexpr std::size_t kMostHeaderBytes = 8192;
  static constexpr std::size_t kMostBodyBytes = 16384;
  static constexpr std::size_t kMostBytesFromPage = 1024;  ///< on the feed, where it has nothing to say
  static constexpr int kSendBufferBytes = 128 << 10;  ///< wait in the kernel for a page that does not read
  static constexpr std::chrono::seconds kRequestTime{10};  ///< to say a request, and to take its answer
  static constexpr std::chrono::seconds kFrameTime{5};     ///< to take a frame

  /// @throws std::system_error naming the address if it cannot listen there
  explicit WebServer(WebServerOptions options);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  std::uint16_t port() const;
  /// Process: ends when told to stop.
  void run(std::stop_token stop);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roadbalance
