#include "tools/doctor/bus_loop.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <random>
#include <thread>

#include "common/bus/bus.hpp"
#include "common/types/block.hpp"
#include "tools/doctor/bus_interface.hpp"

namespace roadbalance {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr const char* kLoopChannel = "RB_DOCTOR";
constexpr std::size_t kLoopBytes = kMaxBlockBytes;  ///< one Ethernet frame
constexpr std::size_t kMostName = 64;
constexpr std::size_t kMostAnswering = 32;

/// The whole message.  It goes from program to program of one version, and is checked by its length and kind.
struct LoopMessage {
  std::int64_t run = 0;
  std::int32_t number = 0;
  std::int32_t answered_by = 0;  ///< 0: a question, else a number that its program has drawn
  std::array<char, kMostName> name{};

  std::array<std::uint8_t, kLoopBytes> bytes() const {
    std::array<std::uint8_t, kLoopBytes> bytes{};
    std::memcpy(bytes.data(), this, sizeof *this);
    return bytes;
  }
  static std::optional<LoopMessage> of(std::span<const std::uint8_t> bytes) {
    if (bytes.size() != kLoopBytes) return std::nullopt;
    LoopMessage message;
    std::memcpy(&message, bytes.data(), sizeof message);
    message.name.back() = '\0';
    return message;
  }
};

std::int64_t random_run() {
  std::random_device device;
  return (static_cast<std::int64_t>(device()) << 31) ^ static_cast<std::int64_t>(device());
}

std::string milliseconds_of(double ms) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.2f ms", ms);
  return text.data();
}

std::string share_of(std::int64_t came, std::int64_t sent) {
  return (came == sent ? "all " : std::to_string(came) + " of ") + std::to_string(sent);
}

std::string times_of(const BusLoop::Way& way) {
  return milliseconds_of(way.within_ms(0.5)) + " in the median, " + milliseconds_of(way.within_ms(1.0)) +
         " at worst" + (way.late > 0 ? ", " + std::to_string(way.late) + " out of order" : "");
}

Finding own_way(const BusLoop& loop) {
  const auto& way = loop.own();
  if (way.came() == 0)
    return {"loopback", Finding::kIll,
            "A message sent over LCM does not come back on this machine; a firewall may block it.",
            multicast_remedy()};
  const std::string sentence = "Of messages sent over LCM to this machine " +
                               share_of(way.came(), loop.sent()) + " came, after " + times_of(way) + ".";
  if (way.came() == loop.sent()) return {"loopback", Finding::kWell, sentence, ""};
  return {"loopback", Finding::kNote, sentence + "  What is lost is sent again; the link carries less.",
          "top  # says what loads this machine"};
}

Finding way_to(const BusLoop::Way& way, std::int64_t sent) {
  const std::string sentence = "Of messages to " + way.name + " and back " + share_of(way.came(), sent) +
                               " came, after " + times_of(way) + ".";
  if (way.came() == sent) return {"way_to_" + way.name, Finding::kWell, sentence, ""};
  return {"way_to_" + way.name, Finding::kNote,
          sentence + "  What is lost is sent again; the link carries less.",
          "ip -s link  # says which interface drops frames; a cable carries more than radio"};
}

}  // namespace

double BusLoop::Way::within_ms(double share) const {
  if (back_ms.empty()) return 0.0;
  std::vector<double> sorted = back_ms;
  std::sort(sorted.begin(), sorted.end());
  const auto at = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size()))) - 1;
  return sorted[std::min(at, sorted.size() - 1)];
}

BusLoop::BusLoop(const std::string& url) : run_(random_run()), sender_(url), receiver_(url) {
  receiver_.subscribe(kLoopChannel,
                      [this](std::string_view, std::span<const std::uint8_t> bytes) { take(bytes); });
}

void BusLoop::run(int messages, milliseconds pause) {
  sent_at_.reserve(sent_at_.size() + static_cast<std::size_t>(messages));
  auto next = Clock::now();
  for (int k = 0; k < messages; ++k) {
    sent_at_.push_back(Clock::now());
    sender_.publish(kLoopChannel,
                    LoopMessage{.run = run_, .number = static_cast<std::int32_t>(sent_++)}.bytes());
    next = std::max(next, Clock::now()) + milliseconds(1);  // what a stall has held up is no burst afterwards
    // handle() waits whole milliseconds: often, or the times would be its own.
    while (receiver_.handle(milliseconds(0)), Clock::now() < next)
      std::this_thread::sleep_for(std::chrono::microseconds(50));
  }
  for (const auto end = Clock::now() + pause; Clock::now() < end;) receiver_.handle(milliseconds(10));
}

void BusLoop::take(std::span<const std::uint8_t> bytes) {
  const auto message = LoopMessage::of(bytes);
  if (!message || message->run != run_ || message->number < 0 || message->number >= std::ssize(sent_at_))
    return;
  const std::int32_t by = message->answered_by;
  if (by != 0 && !answers_.contains(by) && answers_.size() == kMostAnswering) return;
  Way& way = by != 0 ? answers_[by] : own_;
  if (!way.numbers.insert(message->number).second) return;
  way.name = message->name.data();
  way.late += message->number < *way.numbers.rbegin() ? 1 : 0;
  way.back_ms.push_back(std::chrono::duration<double, std::milli>(
                            Clock::now() - sent_at_[static_cast<std::size_t>(message->number)])
                            .count());
}

std::int64_t answer_loops(const std::string& url, const std::stop_token& stop) {
  Bus bus(url);
  std::random_device device;
  const auto who = static_cast<std::int32_t>(device() >> 1) | 1;
  std::int64_t answered = 0;
  bus.subscribe(kLoopChannel, [&](std::string_view, std::span<const std::uint8_t> bytes) {
    auto message = LoopMessage::of(bytes);
    if (!message || message->answered_by != 0) return;
    message->answered_by = who;
    gethostname(message->name.data(), message->name.size() - 1);
    if (bus.publish(kLoopChannel, message->bytes())) ++answered;
  });
  while (!stop.stop_requested()) bus.handle(milliseconds(100));
  return answered;
}

std::vector<Finding> loop_findings(const BusLoop& loop, const std::string& url) {
  std::vector<Finding> findings{own_way(loop)};
  for (const auto& [who, way] : loop.answers()) findings.push_back(way_to(way, loop.sent()));
  if (url.empty()) return findings;
  if (stays_on_machine(url))
    findings.push_back({"ttl", Finding::kNote, "What is sent to " + url + " stays on this machine.",
                        "rb doctor --url '" + url.substr(0, url.find('?')) + "?ttl=1'"});
  else if (loop.answers().empty())
    findings.push_back({"ways", Finding::kNote, "No other machine answered.",
                        "rb doctor --answer --url '" + url + "'  # on each of them, beside this"});
  return findings;
}

}  // namespace roadbalance
