#include "common/clock/refine.hpp"

#include <algorithm>
#include <cstdlib>
#include <optional>

#include "common/clock/clock_model.hpp"
#include "common/clock/offset_line.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kReach_ns = ClockModel::kBin_ns * static_cast<std::int64_t>(ClockModel::kBins) / 2;

/// Exchanges so much older than the newest belong to another boot of the host: no question waits so long.
constexpr std::int64_t kAnotherBoot_ns = 2'000'000'000;

/// The plausible exchanges, cut where the node's time base broke or the host's clock began anew.
std::vector<std::vector<ClockExchange>> pieces_of(std::span<const ClockExchange> exchanges) {
  std::vector<std::vector<ClockExchange>> pieces(1);
  if (exchanges.empty()) return pieces;
  std::optional<ClockModel> model;
  std::int64_t newest_ns = 0;
  for (const auto& exchange : exchanges) {
    if (!exchange.is_plausible()) continue;
    if (!model || exchange.middle_ns() < newest_ns - kAnotherBoot_ns) {
      if (model) pieces.emplace_back();
      model.emplace(exchange.node, exchange.epoch);
      newest_ns = exchange.middle_ns();
    }
    newest_ns = std::max(newest_ns, exchange.middle_ns());
    auto& piece = pieces.back();
    if (!model->add(exchange)) {
      piece.push_back(exchange);
      continue;
    }
    // The break was proved by this one and the one before it.
    const ClockExchange first = piece.back();
    piece.pop_back();
    pieces.push_back({first, exchange});
  }
  return pieces;
}

/// The exchange with the shortest round trip in each second.
std::vector<ClockExchange> best_of_seconds(std::vector<ClockExchange> piece) {
  const auto second = [](const ClockExchange& e) { return e.middle_ns() / ClockModel::kBin_ns; };
  std::stable_sort(piece.begin(), piece.end(), [&](const auto& a, const auto& b) {
    return second(a) != second(b) ? second(a) < second(b) : a.round_trip_ns() < b.round_trip_ns();
  });
  const auto end = std::unique(piece.begin(), piece.end(),
                               [&](const auto& a, const auto& b) { return second(a) == second(b); });
  piece.erase(end, piece.end());
  return piece;
}

void add_fits(const std::vector<ClockExchange>& best, std::int64_t breaks, std::vector<ClockFit>& fits) {
  auto from = best.begin(), to = best.begin();
  for (const auto& centre : best) {
    const std::int64_t at = centre.middle_ns();
    while (at - from->middle_ns() > kReach_ns) ++from;
    while (to != best.end() && to->middle_ns() - at <= kReach_ns) ++to;
    const OffsetLine line(std::span(from, to), at, {});
    fits.push_back({.node = centre.node,
                    .epoch = centre.epoch,
                    .number = std::ssize(fits) + 1,
                    .state = ClockState::kLocked,
                    .host_ns = at,
                    .node_ns = line.node_time_ns(at),
                    .drift = line.drift(),
                    .uncertainty_s = line.uncertainty_s(at, 0.0),
                    .round_trip_s = line.round_trip_s(),
                    .residual_s = line.residual_s(),
                    .breaks = breaks});
  }
}

}  // namespace

std::vector<ClockFit> refine(std::span<const ClockExchange> exchanges) {
  std::vector<ClockFit> fits;
  std::int64_t breaks = 0;
  for (auto& piece : pieces_of(exchanges)) {
    if (std::ssize(piece) >= ClockModel::kLeastExchanges)
      add_fits(best_of_seconds(std::move(piece)), breaks, fits);
    ++breaks;
  }
  return fits;
}

const ClockFit* RefinedFits::at(std::int64_t node_time_ns) {
  if (fits_.empty()) return nullptr;
  const auto distance = [&](std::size_t i) { return std::abs(fits_[i].node_ns - node_time_ns); };
  while (next_ + 1 < fits_.size() && distance(next_ + 1) <= distance(next_)) ++next_;
  return &fits_[next_];
}

}  // namespace roadbalance
