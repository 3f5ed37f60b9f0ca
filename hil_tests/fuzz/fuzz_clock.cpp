#include <algorithm>
#include <cmath>

#include "common/clock/clock_map.hpp"
#include "common/clock/clock_model.hpp"
#include "common/clock/datagram.hpp"
#include "common/types/block.hpp"
#include "common/types/crc32c.hpp"
#include "hil_tests/fuzz/byte_reader.hpp"
#include "hil_tests/fuzz/property.hpp"

// The clock's datagrams, and the model of a clock from exchanges that may have anything a decoder lets
// through.
namespace roadbalance {
namespace {

using fuzz::require;

fuzz::Reached datagrams("a datagram"), useful("a fit that tells time");

void check_datagram(std::span<const std::uint8_t> bytes) {
  const auto datagram = decode_clock_datagram(bytes);
  if (!datagram) return;
  datagrams.count();
  const auto again = encode(*datagram);
  require(std::equal(bytes.begin(), bytes.end(), again.begin(), again.end()),
          "encoding what was decoded gives the same bytes");
}

void check_mended(std::span<const std::uint8_t> bytes) {
  auto mended = encode(ClockDatagram{.node = 1});
  const auto given = bytes.first(std::min(bytes.size(), mended.size()));
  std::copy(given.begin(), given.end(), mended.begin());
  const std::uint32_t crc = crc32c(std::span(mended).first(mended.size() - 4));
  for (std::size_t k = 0; k < 4; ++k)
    mended[mended.size() - 4 + k] = static_cast<std::uint8_t>(crc >> (24 - 8 * k));
  check_datagram(mended);
}

// An instant anywhere a clock may be, or a step on from the one before.
std::int64_t instant(fuzz::ByteReader& in, std::int64_t before) {
  const std::uint8_t how = in.byte();
  if (how < 8) return in.i64() % kClockLimit_ns;
  const auto step = static_cast<std::int64_t>(in.number(how % 5 + 1));
  return std::clamp(before + step, -kClockLimit_ns, kClockLimit_ns);
}

void check_map(const ClockMap& map, std::int64_t node_ns) {
  const ClockFit& last = *map.last();
  require(std::abs(map.host_time_ns(node_ns)) <= kClockLimit_ns, "an instant is one that a clock may have");
  require(map.host_time_ns(last.node_ns) == bounded_ns(last.host_ns), "a fit holds at its own instant");
  const std::vector<ClockFit> fits = map.fits();
  ClockMap again;
  for (const ClockFit& fit : fits) again.take(fit);
  require(again.fits() == fits, "the fits of a map make the same map");
  if (fits.size() < 2) return;
  const ClockFit& before = fits.front();
  require(before.host_ns < last.host_ns, "two that are joined come one behind the other");
  require(std::abs(map.host_time_ns(before.node_ns) - before.host_ns) <= 1, "and so does the one before it");
}

void check_model(std::span<const std::uint8_t> bytes) {
  fuzz::ByteReader in(bytes);
  ClockModel model(1, 2);
  ClockMap map;
  ClockExchange exchange{.node = 1, .epoch = 2};
  constexpr double kUseful_s = 1.0;
  std::int64_t fits = 0;
  while (!in.empty()) {
    ++exchange.number;
    exchange.asked_ns = instant(in, exchange.heard_ns);
    exchange.received_ns = instant(in, exchange.answered_ns);
    exchange.answered_ns = instant(in, exchange.received_ns);
    exchange.heard_ns = instant(in, exchange.asked_ns);
    model.add(exchange);
    const ClockFit fit = model.fit(instant(in, exchange.heard_ns));
    require(fit.number == ++fits, "fits are numbered");
    if (fit.uncertainty_s < kUseful_s) useful.count();
    require(std::isfinite(fit.drift) && std::isfinite(fit.uncertainty_s) && fit.uncertainty_s >= 0,
            "a fit is of finite numbers");
    require(fit.breaks == model.breaks() && fit.breaks <= exchange.number, "breaks are counted");
    if (!fit.is_known()) continue;
    map.take(fit);
    check_map(map, instant(in, fit.node_ns));
  }
}

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  roadbalance::check_datagram(bytes);
  roadbalance::check_mended(bytes);
  roadbalance::check_model(bytes);
  return 0;
}
