#include "host/web/web_server.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

// The only source with Boost: it takes half a minute and a gigabyte to compile.

namespace roadbalance {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;
using Error = beast::error_code;
using HttpRequest = http::request<http::string_body>;

/// In every answer.  The page loads nothing from elsewhere and nothing inline, is shown in no frame, makes no
/// markup of text, and is not cached.
constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kSafetyHeaders{
    {{"Content-Security-Policy",
      "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
      "base-uri 'none'; form-action 'none'; frame-ancestors 'none'; require-trusted-types-for 'script'; "
      "trusted-types 'none'"},
     {"X-Content-Type-Options", "nosniff"},
     {"X-Frame-Options", "DENY"},
     {"Referrer-Policy", "no-referrer"},
     {"Cross-Origin-Opener-Policy", "same-origin"},
     {"Cross-Origin-Resource-Policy", "same-origin"},
     {"Permissions-Policy", "camera=(), geolocation=(), microphone=()"},
     {"Cache-Control", "no-store"}}};

constexpr const char* kFeedPath = "/feed";
constexpr const char* kTokenHeader = "X-Roadbalance-Token";

std::string_view view(beast::string_view text) {
  return {text.data(), text.size()};
}
beast::string_view text(std::string_view view) {
  return {view.data(), view.size()};
}

/// The value of a header that must be there once; empty otherwise.
std::string_view sole(const HttpRequest& request, http::field field) {
  return request.count(field) == 1 ? view(request[field]) : std::string_view();
}

/// An address as a browser names it.
std::string name_of(const asio::ip::address& address) {
  if (!address.is_v6()) return address.to_string();
  if (const auto v6 = address.to_v6(); v6.is_v4_mapped())
    return asio::ip::make_address_v4(asio::ip::v4_mapped, v6).to_string();
  return "[" + address.to_string() + "]";
}

/// A connection's place among those that are allowed at a time; counts it while it lives.
class Place {
 public:
  explicit Place(std::size_t& taken) : taken_(&taken) { ++*taken_; }
  Place(Place&& other) noexcept : taken_(std::exchange(other.taken_, nullptr)) {}
  Place& operator=(Place&&) = delete;
  ~Place() {
    if (taken_) --*taken_;
  }

 private:
  std::size_t* taken_;
};

/// Sends the feed to one page that watches.
class WebSocketSession : public std::enable_shared_from_this<WebSocketSession> {
 public:
  WebSocketSession(beast::tcp_stream stream, Place place, std::int64_t viewer)
      : place_(std::move(place)), socket_(std::move(stream)), viewer_(viewer) {}

  void accept(const HttpRequest& request, std::vector<std::weak_ptr<WebSocketSession>>& sessions) {
    beast::get_lowest_layer(socket_).expires_never();
    socket_.set_option(
        websocket::stream_base::timeout{WebServer::kRequestTime, 2 * WebServer::kRequestTime, true});
    socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& answer) {
      answer.set(http::field::sec_websocket_protocol, kFeedProtocol);
    }));
    socket_.read_message_max(WebServer::kMostBytesFromPage);
    socket_.binary(true);
    socket_.auto_fragment(false);
    socket_.async_accept(request, [self = shared_from_this(), &sessions](Error error) {
      if (error) return;
      sessions.push_back(self);
      self->read();
    });
  }

  /// Sends what is new, if the page has taken the frame before; closes if that takes too long.
  void offer(const std::function<Frame(std::uint64_t, std::int64_t)>& frame_since) {
    if (in_flight_.bytes) {
      if (WallClock::now() - sent_at_ > WebServer::kFrameTime) beast::get_lowest_layer(socket_).close();
      return;
    }
    in_flight_ = frame_since(revision_, viewer_);
    if (!in_flight_.bytes) return;
    sent_at_ = WallClock::now();
    socket_.async_write(asio::buffer(*in_flight_.bytes),
                        [self = shared_from_this()](Error error, std::size_t) {
                          if (error) return;
                          self->revision_ = std::exchange(self->in_flight_, {}).revision;
                        });
  }

 private:
  // A page must send nothing here; reading answers pings and notices that the page goes.
  void read() {
    socket_.async_read(from_page_, [self = shared_from_this()](Error error, std::size_t) {
      if (!error) beast::get_lowest_layer(self->socket_).close();
    });
  }

  Place place_;
  websocket::stream<beast::tcp_stream> socket_;
  beast::flat_buffer from_page_;
  Frame in_flight_;
  WallTime sent_at_{};
  std::uint64_t revision_ = 0;
  std::int64_t viewer_;
};

/// All connections share it.
struct Shared {
  const WebServerOptions options;
  std::vector<std::weak_ptr<WebSocketSession>> sessions{};
  std::size_t connections = 0;
};

/// The answer to a request.
struct Reply {
  http::status status;
  std::string_view type;     ///< MIME
  std::string_view content;  ///< unless there is a text
  std::string text{};        ///< made for this request
  bool hangs_up = false;

  std::string_view body() const { return text.empty() ? content : std::string_view(text); }
};

/// Decides on requests: whether they are admitted, and what answers them.  Touches no socket.
class Router {
 public:
  explicit Router(const WebServerOptions& options) : options_(options) {}

  /// @param here  the address that the request reached
  /// @param from  and the one that it came from
  /// @return nothing: the connection is to become a WebSocket that takes the feed
  std::optional<Reply> route(const HttpRequest& request, const OwnAddress& here,
                             const std::string& from) const {
    const bool is_websocket = websocket::is_upgrade(request);
    const auto post = std::ranges::find(options_.posts, view(request.target()), &Post::path);
    const bool is_post = request.method() == http::verb::post && post != options_.posts.end();
    const RequestHead head{.method = view(request.method_string()),
                           .target = view(request.target()),
                           .host = sole(request, http::field::host),
                           .origin = sole(request, http::field::origin),
                           .token = token_of(request, is_websocket),
                           .is_websocket = is_websocket,
                           .only_watches = is_post && !post->changes_state};
    if (request.count(http::field::origin) > 1) return refusal(http::status::bad_request);
    const Admission admission = admit(head, here, options_.rules);
    if (admission != Admission::kAdmitted) return refusal(static_cast<http::status>(admission));
    if (is_websocket && head.target == kFeedPath) return std::nullopt;
    return is_post ? posted(*post, request, from) : asset(head);
  }

  /// Hangs up: the client may be in the middle of sending more.
  static Reply refusal(http::status status) {
    return {.status = status, .type = "text/plain", .content = {}, .hangs_up = true};
  }

 private:
  static std::string_view token_of(const HttpRequest& request, bool is_websocket) {
    if (is_websocket) return token_of_protocols(sole(request, http::field::sec_websocket_protocol));
    const auto header = request.find(kTokenHeader);
    return header == request.end() ? std::string_view() : view(header->value());
  }

  static Reply posted(const Post& post, const HttpRequest& request, const std::string& from) {
    // A foreign page may send other types without being asked for permission first (CORS).
    if (post.changes_state && view(request[http::field::content_type]) != "application/json")
      return refusal(http::status::unsupported_media_type);
    PostAnswer answer = post.take(request.body(), from);
    return {.status = static_cast<http::status>(answer.status),
            .type = "text/plain; charset=utf-8",
            .content = {},
            .text = std::move(answer.text)};
  }

  Reply asset(const RequestHead& head) const {
    const auto found = std::ranges::find(options_.assets, head.target, &Asset::path);
    if (found == options_.assets.end())
      return {.status = http::status::not_found, .type = "text/plain", .content = "There is no such page.\n"};
    if (head.method == "POST") return refusal(http::status::method_not_allowed);
    return {.status = http::status::ok, .type = found->type, .content = found->content};
  }

  const WebServerOptions& options_;
};

/// One connection: reads its requests in turn, within their limits, and sends each its answer; or hands its
/// socket to a WebSocketSession.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(Tcp::socket socket, Shared& shared)
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
      return send(Router::refusal(http::status::request_header_fields_too_large));
    if (error == http::error::body_limit) return send(Router::refusal(http::status::payload_too_large));
    if (error.category() == http::make_error_code(http::error::bad_method).category() &&
        error != http::error::end_of_stream && error != http::error::partial_message)
      return send(Router::refusal(http::status::bad_request));
    if (error) return;
    Error no_address;
    const Tcp::endpoint here = stream_.socket().local_endpoint(no_address);
    const Tcp::endpoint from = stream_.socket().remote_endpoint(no_address);
    if (no_address) return;
    auto reply = Router(shared_.options)
                     .route(parser_->get(), {name_of(here.address()), here.port()}, name_of(from.address()));
    if (!reply) return become_websocket();
    send(*std::move(reply));
  }

  void become_websocket() {
    Error ignored;  // a page that stalls is noticed a little later then
    stream_.socket().set_option(asio::socket_base::send_buffer_size(WebServer::kSendBufferBytes), ignored);
    const std::int64_t viewer =
        viewer_of_protocols(sole(parser_->get(), http::field::sec_websocket_protocol));
    std::make_shared<WebSocketSession>(std::move(stream_), std::move(place_), viewer)
        ->accept(parser_->get(), shared_.sessions);
  }

  void send(Reply reply) {
    reply_ = std::move(reply);
    const std::string_view body = reply_.body();
    const HttpRequest& request = parser_->get();
    answer_.emplace(reply_.status, 11);
    for (const auto& [name, value] : kSafetyHeaders) answer_->set(text(name), text(value));
    answer_->set(http::field::content_type, text(reply_.type));
    if (reply_.status == http::status::method_not_allowed) answer_->set(http::field::allow, "GET, HEAD");
    answer_->body() = {const_cast<char*>(body.data()), body.size(), false};
    answer_->content_length(body.size());
    answer_->keep_alive(!reply_.hangs_up && request.keep_alive());
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
  Reply reply_{};  ///< holds the text while it is sent
  using Answer = http::response<http::buffer_body>;
  std::optional<Answer> answer_;
  std::optional<http::response_serializer<http::buffer_body>> serializer_;
};

}  // namespace

struct WebServer::State {
  explicit State(WebServerOptions options) : shared{std::move(options)} {}

  void accept() {
    acceptor.async_accept([this](Error error, Tcp::socket socket) {
      if (!error && shared.connections < kMostConnections)
        std::make_shared<HttpConnection>(std::move(socket), shared)->read();
      accept();
    });
  }

  void tick() {
    timer.expires_after(std::chrono::milliseconds(1000 / kPerSecond));
    timer.async_wait([this](Error) {
      shared.options.refresh();
      std::erase_if(shared.sessions, [this](const auto& session) {
        const auto here = session.lock();
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
