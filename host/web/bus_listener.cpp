#include "host/web/bus_listener.hpp"

#include <chrono>
#include <span>
#include <string_view>

#include "common/bus/bus.hpp"
#include "host/web/request_relay.hpp"

namespace roadbalance {

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

}  // namespace roadbalance
