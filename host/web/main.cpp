#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <fstream>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "common/bus/bus.hpp"
#include "common/bus/operation.hpp"
#include "common/bus/transfer_function_report.hpp"
#include "common/command_line/bus_url.hpp"
#include "common/command_line/manual.hpp"
#include "common/command_line/run_program.hpp"
#include "common/config/section.hpp"
#include "common/process/channel.hpp"
#include "common/process/parallel.hpp"
#include "common/process/stop_on_signal.hpp"
#include "common/types/clocks.hpp"
#include "host/web/feed.hpp"
#include "host/web/request_json.hpp"
#include "host/web/request_relay.hpp"
#include "host/web/topics.hpp"
#include "host/web/web_server.hpp"

namespace {

using namespace roadbalance;

struct Options {
  std::string url;
  std::string listen = "127.0.0.1";
  int port = 8080;
  std::vector<std::string> host;
  std::string token_file;
};

void warn(const std::string& sentence) {
  report("rb-web", sentence);
}

bool is_loopback(const std::string& address) {
  return address.starts_with("127.") || address == "::1";
}

std::string read_token(const std::string& path) {
  std::ifstream file(path);
  std::string token;
  if (!(file >> token)) throw std::runtime_error("--token-file " + path + ": cannot be read or is empty");
  const auto is_sendable = [](char c) {
    return ('0' <= c && c <= '9') || ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || c == '-' || c == '_';
  };
  if (!std::ranges::all_of(token, is_sendable))
    throw ConfigError("--token-file " + path +
                      ": the token has a character that a browser cannot send; allowed: A-Z a-z 0-9 - _");
  if (token.size() < kLeastToken)
    throw ConfigError("--token-file " + path + ": the token is shorter than " + std::to_string(kLeastToken) +
                      " characters");
  return token;
}

GuardRules rules_of(const Options& options) {
  GuardRules rules{options.host, {}, !is_loopback(options.listen)};
  if (rules.token_to_watch && options.token_file.empty())
    throw ConfigError("--listen " + options.listen +
                      ": others can reach this address, so --token-file must name a file with a secret");
  rules.token = options.token_file.empty() ? new_token() : read_token(options.token_file);
  if (!rules.token_to_watch) rules.host.push_back("localhost");
  return rules;
}

/// A browser sends the part behind the # to no server.
void print_address(const Options& options, std::uint16_t port, const GuardRules& rules) {
  const std::string name =
      options.listen.find(':') == std::string::npos ? options.listen : "[" + options.listen + "]";
  // A secret that comes from a file is not repeated.
  const std::string token = options.token_file.empty() ? rules.token : "...";
  std::printf("http://%s:%d/#token=%s\n", name.c_str(), port, token.c_str());
  std::fflush(stdout);
}

/// Process: bus -> messages that the page shows; requests of pages -> bus, until the recorder has answered.
/// Warns of programs on the bus that use another version of the wire.
///
/// A server that is behind costs messages, never the bus: each topic is sent again, or is a result of which
/// only the newest counts.
void listen_to_bus(std::stop_token stop, const std::string& url, Out<TopicMessage> messages,
                   In<Request> requests, const std::function<void(const std::string&)>& on_warning) {
  constexpr std::chrono::milliseconds kPatience{50};  // bounds the delay of a request
  Bus bus(url);
  RequestRelay relay;
  bus.subscribe(kAnswerChannel, [&relay](std::string_view, std::span<const std::uint8_t> bytes) {
    if (const auto answer = decode_answer(bytes)) relay.take(*answer);
  });
  for (std::size_t kind = 0; kind < page_messages().size(); ++kind) {
    const PageMessage& message = page_messages()[kind];
    bus.subscribe(message.channels, [&, kind](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto key = message.key(bytes))
        messages.try_send(
            {{kind, *key, message.viewer ? message.viewer(bytes) : 0}, {bytes.begin(), bytes.end()}});
    });
  }
  while (!stop.stop_requested()) {
    bus.handle(kPatience);
    const WallTime now = WallClock::now();
    while (const auto request = requests.receive_for(std::chrono::seconds(0))) relay.take(*request, now);
    for (const Request& request : relay.due(now)) (void)bus.publish(kRequestChannel, encode(request));
    for (const std::string& sentence : bus.other_versions()) on_warning(sentence);
  }
}

PostAnswer take_view(std::string_view body, Bus& bus, Feed& feed) {
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(body.data()), body.size());
  const auto view = decode_view(bytes);
  if (!view || view->viewer == 0) return {400, "That is no view of this version: load the page again.\n"};
  if (!feed.expect(view->viewer, WallClock::now()))
    return {503, "Too many pages show plots: close one of them.\n"};
  if (!bus.publish(kViewChannel, bytes)) return {503, "The bus takes nothing at present.\n"};
  return {};
}

/// "/view": a page posts a view_t, which goes to the bus as it came; the analyser's answer goes to that page
/// alone.  The page repeats it each second, as on the bus.
///
/// 400: no view_t of this version, or one without a viewer; 503: too many pages ask, or it could not be sent.
/// @param bus   to send it on, of the server's own process
/// @param feed  outlives the result, as does the bus
Post view_post(Bus& bus, Feed& feed) {
  return {"/view", false,
          [&](std::string_view body, const std::string&) { return take_view(body, bus, feed); }};
}

PostAnswer take_request(std::string_view body, const std::string& from, Out<Request>& requests) {
  auto parsed = parse_request(body);
  if (const auto* fault = std::get_if<std::string>(&parsed)) return {400, *fault + "\n"};
  auto& request = std::get<Request>(parsed);
  request.who = "the page at " + from;
  if (!requests.try_send(request)) return {503, "Too much is asked at once.\n"};
  return {202, "Asked.\n"};
}

/// "/request": a person asks the recorder for something, in the JSON of parse_request().  The answer comes on
/// the feed: the recorder may take seconds.
///
/// 202: it was passed on; 400: no request, and why; 503: too much is asked at once.
/// @param requests  to the process on the bus; outlives the result
Post request_post(Out<Request>& requests) {
  return {"/request", true, [&requests](std::string_view body, const std::string& from) {
            return take_request(body, from, requests);
          }};
}

void serve(const Options& options, std::stop_token stop) {
  constexpr std::size_t kWaitingMessages = 4096;
  constexpr std::size_t kWaitingRequests = 32;
  auto [messages_out, messages_in] = make_channel<TopicMessage>(kWaitingMessages);
  auto [requests_out, requests_in] = make_channel<Request>(kWaitingRequests);
  Feed feed;
  Bus bus(options.url);
  const GuardRules rules = rules_of(options);
  const auto refresh = [&feed, &messages = messages_in] {
    const WallTime now = WallClock::now();
    while (auto message = messages.receive_for(std::chrono::seconds(0))) feed.take(std::move(*message), now);
    feed.forget_silent(now);
  };
  WebServer server({.address = options.listen,
                    .port = static_cast<std::uint16_t>(options.port),
                    .rules = rules,
                    .assets = page_assets(),
                    .posts = {view_post(bus, feed), request_post(requests_out)},
                    .refresh = refresh,
                    .frame = [&feed](std::uint64_t revision, std::int64_t viewer) {
                      return feed.since(revision, WallClock::now(), viewer);
                    }});
  Parallel processes;
  const std::stop_callback pass_on(stop, [&] { processes.request_stop(); });
  processes.run([&server](std::stop_token stop_here) { server.run(stop_here); });
  processes.run(listen_to_bus, options.url, std::move(messages_out), std::move(requests_in), warn);
  print_address(options, server.port(), rules);
  processes.wait();
}

}  // namespace

int main(int argc, char** argv) {
  const StopOnSignal signals;
  Options options;
  CLI::App app("Shows in a browser what is on the bus: recorder, nodes, levels, balance.", "rb-web");
  add_bus_url(app, options.url);
  app.add_option("--port", options.port, "to listen on; 0: a free one")
      ->check(CLI::Range(0, 65'535))
      ->capture_default_str();
  app.add_option("--listen", options.listen, "address to listen on; one that others reach needs --token-file")
      ->check(CLI::ValidIPV4)
      ->capture_default_str();
  app.add_option("--host", options.host, "a name by which browsers may call this address");
  app.add_option("--token-file", options.token_file, "file with the secret that the page must show");
  add_version(app);
  add_manual(app);
  try {
    app.parse(argc, argv);
    serve(options, signals.token());
    return 0;
  } catch (const std::exception& error) {
    return report_failure(app, error);
  }
}
