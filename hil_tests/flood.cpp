#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <thread>

#include "common/types/clocks.hpp"
#include "hil_tests/malformer.hpp"
#include "hil_tests/throw_errno.hpp"

namespace roadbalance::test {
namespace {

constexpr const char* kGroup = "239.255.76.67";
constexpr std::chrono::seconds kPatience{30};  // for the first real datagram
constexpr double kMostRefused = 0.01;          // of all, for a flood that counts
constexpr double kLeastRate = 0.99;            // of the rate asked

/// Hears the bus as it is and sends it anything; has nothing of LCM.
class RawBus {
 public:
  explicit RawBus(int port) : port_(htons(static_cast<std::uint16_t>(port))) {
    if (receiver_ < 0 || sender_ < 0) throw_errno("socket");
    const int yes = 1;
    ::setsockopt(receiver_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    const sockaddr_in any{.sin_family = AF_INET, .sin_port = port_, .sin_addr = {}, .sin_zero = {}};
    if (::bind(receiver_, reinterpret_cast<const sockaddr*>(&any), sizeof any) != 0)
      throw_errno("bind port " + std::to_string(port));
    ip_mreq group{};
    group.imr_multiaddr.s_addr = inet_addr(kGroup);
    if (::setsockopt(receiver_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0)
      throw_errno("join the bus");
    const unsigned char ttl = 0;
    ::setsockopt(sender_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
  }
  ~RawBus() {
    ::close(receiver_);
    ::close(sender_);
  }
  RawBus(const RawBus&) = delete;
  RawBus& operator=(const RawBus&) = delete;

  bool send(const Datagram& datagram) const {
    sockaddr_in group{.sin_family = AF_INET, .sin_port = port_, .sin_addr = {}, .sin_zero = {}};
    group.sin_addr.s_addr = inet_addr(kGroup);
    return ::sendto(sender_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&group),
                    sizeof group) >= 0;
  }

  /// Datagrams since the last call, our own among them; not longer than `bytes`.
  std::size_t receive(std::span<std::uint8_t> bytes) const {
    const ssize_t size = ::recv(receiver_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    return size > 0 ? static_cast<std::size_t>(size) : 0;
  }

 private:
  in_port_t port_;
  int receiver_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  int sender_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
};

struct Options {
  int port = 7667;
  double seconds = 3;
  double per_second = 10'000;
  double listen_s = 0.5;
  std::uint32_t seed = 1;
};

/// True if the bus got what was asked.
bool flood(const Options& options) {
  const RawBus bus(options.port);
  Malformer malformer(options.seed);
  std::array<std::uint8_t, 2000> received;
  // Real ones first, while there is nothing else on the bus.
  const auto end = WallClock::now() + std::chrono::duration<double>(options.listen_s);
  for (const auto last = end + kPatience; WallClock::now() < (malformer.has_stock() ? end : last);
       std::this_thread::sleep_for(std::chrono::milliseconds(1)))
    while (const std::size_t size = bus.receive(received)) malformer.show(std::span(received).first(size));
  if (!malformer.has_stock()) throw std::runtime_error("no real datagram came: nothing to alter");

  std::array<long long, Malformer::kKinds> sent{};
  long long total = 0, refused = 0;  // malformed ones
  double elapsed_s = 0;
  const auto since = [](WallTime begin) {
    return std::chrono::duration<double>(WallClock::now() - begin).count();
  };
  const auto begin = WallClock::now();
  while (elapsed_s < options.seconds) {
    elapsed_s = since(begin);
    while (static_cast<double>(total) < elapsed_s * options.per_second) {
      const auto kind = malformer.any_kind();
      const bool is_sent = bus.send(malformer.make(kind));
      sent[kind] += is_sent ? 1 : 0;
      if (kind == Malformer::kReplayed) continue;  // nothing is wrong with it
      ++total;
      refused += is_sent ? 0 : 1;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  for (std::size_t kind = 0; kind < sent.size(); ++kind)
    std::printf("%s: %lld\n", Malformer::kName[kind], sent[kind]);
  elapsed_s = since(begin);
  std::printf("%lld malformed datagrams in %.1f s, %lld not sent by this computer\n", total - refused,
              elapsed_s, refused);
  if (static_cast<double>(refused) > kMostRefused * static_cast<double>(total)) {
    std::fprintf(stderr, "rb-flood: this computer refused to send more than %g %% of the datagrams\n",
                 100.0 * kMostRefused);
    return false;
  }
  const double per_second = static_cast<double>(total - refused) / elapsed_s;
  if (per_second >= kLeastRate * options.per_second) return true;
  std::fprintf(stderr, "rb-flood: only %.0f datagrams a second, %.0f were asked for\n", per_second,
               options.per_second);
  return false;
}

}  // namespace
}  // namespace roadbalance::test

int main(int argc, char** argv) {
  CLI::App app("rb-flood: sends a bus on this computer datagrams that no program of ours would send");
  roadbalance::test::Options options;
  app.add_option("--bus-port", options.port, "of the bus")
      ->check(CLI::Range(1, 65535))
      ->capture_default_str();
  app.add_option("--seconds", options.seconds)->check(CLI::Range(0.1, 1e6))->capture_default_str();
  app.add_option("--per-second", options.per_second)->check(CLI::Range(1.0, 1e6))->capture_default_str();
  app.add_option("--listen", options.listen_s, "seconds of real datagrams to begin with")
      ->capture_default_str();
  app.add_option("--seed", options.seed)->capture_default_str();
  std::array<char, 160> exit_codes{};
  std::snprintf(
      exit_codes.data(), exit_codes.size(),
      "Exit codes: 0 sent as asked, 1 this computer refused more than %g %% or was slower than %g %% "
      "of the rate, 4 it failed.",
      100.0 * roadbalance::test::kMostRefused, 100.0 * roadbalance::test::kLeastRate);
  app.footer(exit_codes.data());
  CLI11_PARSE(app, argc, argv);
  try {
    return roadbalance::test::flood(options) ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rb-flood: %s\n", error.what());
    return 4;
  }
}
