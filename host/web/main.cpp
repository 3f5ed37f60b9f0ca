#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <fstream>
#include <string>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/command_line/bus_url.hpp"
#include "common/command_line/manual.hpp"
#include "common/config/section.hpp"
#include "common/process/channel.hpp"
#include "common/process/parallel.hpp"
#include "common/process/stop_on_signal.hpp"
#include "host/web/bus_listener.hpp"
#include "host/web/feed.hpp"
#include "host/web/request_post.hpp"
#include "host/web/view_post.hpp"
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

int fail(const std::exception& error, int code) {
  std::fprintf(stderr, "rb-web: %s\n", error.what());
  return code;
}

void warn(const std::string& sentence) {
  std::fprintf(stderr, "rb-web: %s\n", sentence.c_str());
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

/// Behind the # a browser tells it to nobody.
void say_where(const Options& options, std::uint16_t port, const GuardRules& rules) {
  const std::string name =
      options.listen.find(':') == std::string::npos ? options.listen : "[" + options.listen + "]";
  // A secret that comes from a file is not repeated.
  const std::string token = options.token_file.empty() ? rules.token : "...";
  std::printf("http://%s:%d/#token=%s\n", name.c_str(), port, token.c_str());
  std::fflush(stdout);
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
  say_where(options, server.port(), rules);
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
  add_manual(app);
  try {
    app.parse(argc, argv);
    serve(options, signals.token());
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const ConfigError& error) {
    return fail(error, 2);
  } catch (const std::exception& error) {
    return fail(error, 4);
  }
}
