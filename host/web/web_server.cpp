#include "host/web/web_server.hpp"

#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "host/web/place.hpp"
#include "host/web/safety_headers.hpp"

// The only place that knows Boost: half a minute and a gigabyte to compile.

namespace roadbalance {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;
using Error = beast::error_code;
using Request = http::request<http::string_body>;

constexpr const char* kFeedPath = "/feed";
constexpr const char* kTokenHeader = "X-Roadbalance-Token";

std::string_view view(beast::string_view text) {
  return {text.data(), text.size()};
}
beast::string_view text(std::string_view view) {
  return {view.data(), view.size()};
}

/// Of a header that must be there once; empty otherwise.
std::string_view sole(const Request& request, http::field field) {
  return request.count(field) == 1 ? view(request[field]) : std::string_view();
}

/// As a browser names it.
std::string name_of(const asio::ip::address& address) {
  if (!address.is_v6()) return address.to_string();
  if (const auto v6 = address.to_v6(); v6.is_v4_mapped())
    return asio::ip::make_address_v4(asio::ip::v4_mapped, v6).to_string();
  return "[" + address.to_string() + "]";
}

/// A page that watches.
class Watcher : public std::enable_shared_from_this<Watcher> {
 public:
  Watcher(beast::tcp_stream stream, Place place, std::int64_t viewer)
      : place_(std::move(place)), socket_(std::move(stream)), viewer_(viewer) {}

  void accept(const Request& request, std::vector<std::weak_ptr<Watcher>>& watchers) {
    beast::get_lowest_layer(socket_).expires_never();
    socket_.set_option(
        websocket::stream_base::timeout{WebServer::kRequestTime, 2 * WebServer::kRequestTime, true});
    socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& answer) {
      answer.set(http::field::sec_websocket_protocol, kFeedProtocol);
    }));
    socket_.read_message_max(WebServer::kMostBytesFromPage);
    socket_.binary(true);
    socket_.auto_fragment(false);
    socket_.async_accept(request, [self = shared_from_this(), &watchers](Error error) {
      if (error) return;
      watchers.push_back(self);
      self->read();
    });
  }

  /// Sends what is new, if it has taken what was sent before.
  void offer(const std::function<Frame(std::uint64_t, std::int64_t)>& frame_since) {
    if (under_way_.bytes) {
      if (WallClock::now() - sent_at_ > WebServer::kFrameTime) beast::get_lowest_layer(socket_).close();
      return;
    }
    under_way_ = frame_since(seen_, viewer_);
    if (!under_way_.bytes) return;
    sent_at_ = WallClock::now();
    socket_.async_write(asio::buffer(*under_way_.bytes),
                        [self = shared_from_this()](Error error, std::size_t) {
                          if (error) return;
                          self->seen_ = std::exchange(self->under_way_, {}).revision;
                        });
  }

 private:
  // The page has nothing to say here; reading answers pings and notices that it goes.
  void read() {
    socket_.async_read(from_page_, [self = shared_from_this()](Error error, std::size_t) {
      if (!error) beast::get_lowest_layer(self->socket_).close();
    });
  }

  Place place_;
  websocket::stream<beast::tcp_stream> socket_;
  beast::flat_buffer from_page_;
  Frame under_way_;
  WallTime sent_at_{};
  std::uint64_t seen_ = 0;
  std::int64_t viewer_;
};

/// What all connections know of the server.
struct Shared {
  const WebServerOptions options;
  std::vector<std::weak_ptr<Watcher>> watchers{};
  std::size_t connections = 0;
};

/// A connection that speaks HTTP.
class Visitor : public std::enable_shared_from_this<Visitor> {
 public:
  Visitor(Tcp::socket socket, Shared& shared)
      : shared_(shared), place_(shared.connections), stream_(std::move(socket)) {}

  void read() {
    parser_.emplace();
    parser_->header_limit(static_cast<std::uint32_t>(WebServer::kMostHeaderBytes));
    parser_->body_limit(WebServer::kMostBodyBytes);
    stream_.expires_after(WebServer::kRequestTime);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](Error error, std::size_t) { self->take(error); });
  }

 private:
  void take(Error error) {
    if (error == http::error::header_limit || error == http::error::buffer_overflow)
      return refuse(http::status::request_header_fields_too_large);
    if (error == http::error::body_limit) return refuse(http::status::payload_too_large);
    if (error.category() == http::make_error_code(http::error::bad_method).category() &&
        error != http::error::end_of_stream && error != http::error::partial_message)
      return refuse(http::status::bad_request);
    if (error) return;
    const Request& request = parser_->get();
    const bool is_websocket = websocket::is_upgrade(request);
    Error no_address;
    const Tcp::endpoint here = stream_.socket().local_endpoint(no_address);
    if (no_address) return;
    const auto post = std::ranges::find(shared_.options.posts, view(request.target()), &Post::path);
    const bool is_post = request.method() == http::verb::post && post != shared_.options.posts.end();
    const RequestHead head{.method = view(request.method_string()),
                           .target = view(request.target()),
                           .host = sole(request, http::field::host),
                           .origin = sole(request, http::field::origin),
                           .token = token_of(request, is_websocket),
                           .is_websocket = is_websocket,
                           .only_watches = is_post && !post->changes_state};
    if (request.count(http::field::origin) > 1) return refuse(http::status::bad_request);
    const Admission admission = admit(head, {name_of(here.address()), here.port()}, shared_.options.rules);
    if (admission != Admission::kAdmitted) return refuse(static_cast<http::status>(admission));
    if (is_websocket && head.target == kFeedPath) return watch();
    if (is_post) return answer(*post);
    serve(head);
  }

  void answer(const Post& post) {
    // What a page of somebody else's may send without being asked for leave first is of another type.
    if (post.changes_state && view(parser_->get()[http::field::content_type]) != "application/json")
      return refuse(http::status::unsupported_media_type);
    post_answer_ = post.take(parser_->get().body());
    answer(static_cast<http::status>(post_answer_.status), "text/plain; charset=utf-8", post_answer_.text);
  }

  static std::string_view token_of(const Request& request, bool is_websocket) {
    if (is_websocket) return token_of_protocols(sole(request, http::field::sec_websocket_protocol));
    const auto header = request.find(kTokenHeader);
    return header == request.end() ? std::string_view() : view(header->value());
  }

  void watch() {
    Error ignored;  // a page that stalls is noticed a little later then
    stream_.socket().set_option(asio::socket_base::send_buffer_size(WebServer::kSendBufferBytes), ignored);
    const std::int64_t viewer =
        viewer_of_protocols(sole(parser_->get(), http::field::sec_websocket_protocol));
    std::make_shared<Watcher>(std::move(stream_), std::move(place_), viewer)
        ->accept(parser_->get(), shared_.watchers);
  }

  void serve(const RequestHead& head) {
    const auto& assets = shared_.options.assets;
    const auto asset = std::ranges::find(assets, head.target, &Asset::path);
    if (asset == assets.end())
      return answer(http::status::not_found, "text/plain", "There is no such page.\n");
    if (head.method == "POST") return refuse(http::status::method_not_allowed);
    answer(http::status::ok, asset->type, asset->content);
  }

  // And hangs up: whoever is refused may be in the middle of saying more.
  void refuse(http::status status) {
    hang_up_ = true;
    answer(status, "text/plain", {});
  }

  void answer(http::status status, std::string_view type, std::string_view content) {
    const Request& request = parser_->get();
    answer_.emplace(status, 11);
    for (const auto& [name, value] : kSafetyHeaders) answer_->set(text(name), text(value));
    answer_->set(http::field::content_type, text(type));
    if (status == http::status::method_not_allowed) answer_->set(http::field::allow, "GET, HEAD");
    answer_->body() = {const_cast<char*>(content.data()), content.size(), false};
    answer_->content_length(content.size());
    answer_->keep_alive(!hang_up_ && request.keep_alive());
    serializer_.emplace(*answer_);
    const auto written = [self = shared_from_this()](Error error, std::size_t) { self->written(error); };
    stream_.expires_after(WebServer::kRequestTime);
    if (request.method() == http::verb::head)
      http::async_write_header(stream_, *serializer_, written);
    else
      http::async_write(stream_, *serializer_, written);
  }

  void written(Error error) {
    if (error) return;
    if (answer_->keep_alive()) return read();
    Error ignored;
    stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
  }

  Shared& shared_;
  Place place_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{WebServer::kMostHeaderBytes + WebServer::kMostBodyBytes};
  std::optional<http::request_parser<http::string_body>> parser_;
  using Answer = http::response<http::buffer_body>;
  std::optional<Answer> answer_;
  std::optional<http::response_serializer<http::buffer_body>> serializer_;
  PostAnswer post_answer_;
  bool hang_up_ = false;
};

}  // namespace

struct WebServer::State {
  explicit State(WebServerOptions options) : shared{std::move(options)} {}

  void accept() {
    acceptor.async_accept([this](Error error, Tcp::socket socket) {
      if (!error && shared.connections < kMostConnections)
        std::make_shared<Visitor>(std::move(socket), shared)->read();
      accept();
    });
  }

  void tick() {
    timer.expires_after(std::chrono::milliseconds(1000 / kPerSecond));
    timer.async_wait([this](Error) {
      shared.options.refresh();
      std::erase_if(shared.watchers, [this](const auto& watcher) {
        const auto here = watcher.lock();
        if (here) here->offer(shared.options.frame);
        return !here;
      });
      tick();
    });
  }

  Shared shared;  // outlives the connections, which end with io
  asio::io_context io{1};
  Tcp::acceptor acceptor{io};
  asio::steady_timer timer{io};
};

WebServer::WebServer(WebServerOptions options) {
  const std::string name = options.address + " port " + std::to_string(options.port);
  const auto check = [&name](Error error, const char* what) {
    if (error) throw std::system_error(error.value(), std::generic_category(), what + name);
  };
  Error error;
  const Tcp::endpoint endpoint(asio::ip::make_address(options.address, error), options.port);
  check(error, "listen on ");
  auto state = std::make_unique<State>(std::move(options));
  Tcp::acceptor& acceptor = state->acceptor;
  check(acceptor.open(endpoint.protocol(), error), "open ");
  check(acceptor.set_option(Tcp::acceptor::reuse_address(true), error), "listen on ");
  check(acceptor.bind(endpoint, error), "listen on ");
  check(acceptor.listen(asio::socket_base::max_listen_connections, error), "listen on ");
  state_ = std::move(state);
}

WebServer::~WebServer() = default;

std::uint16_t WebServer::port() const {
  return state_->acceptor.local_endpoint().port();
}

void WebServer::run(std::stop_token stop) {
  const std::stop_callback on_stop(stop, [this] { state_->io.stop(); });
  state_->accept();
  state_->tick();
  state_->io.run();
}

}  // namespace roadbalance
