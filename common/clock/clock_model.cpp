#include "common/clock/clock_model.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {
namespace {

constexpr double kUncertainties = 5.0;  // a break is more than so many
constexpr double kStaleDrift = 2e-6;    // how far a drift may have moved since all exchanges aged out

std::int64_t bin_of(const ClockExchange& exchange) {
  const std::int64_t ns = exchange.middle_ns();
  return ns / ClockModel::kBin_ns - (ns % ClockModel::kBin_ns < 0 ? 1 : 0);
}

double age_s(const std::vector<ClockExchange>& exchanges, std::int64_t host_ns) {
  return 1e-9 * static_cast<double>(std::max<std::int64_t>(host_ns - exchanges.back().middle_ns(), 0));
}

}  // namespace

bool ClockModel::add(const ClockExchange& exchange) {
  if (!exchange.is_plausible()) return false;
  // Exchanges may overtake each other by a moment; one older than the newest second has had its chance.
  if (!best_.empty() && bin_of(exchange) < bin_of(best_.back())) return false;
  ++exchanges_;
  if (!contradicts(exchange)) {
    suspect_.reset();
    keep(exchange);
    return false;
  }
  const auto together = [](const ClockExchange& a, const ClockExchange& b) {
    return std::abs(a.offset_ns() - b.offset_ns()) <=
           kLeastBreak_ns + (a.round_trip_ns() + b.round_trip_ns()) / 2;
  };
  if (!suspect_ || !together(*suspect_, exchange)) {
    suspect_ = exchange;
    return false;
  }
  ++breaks_;
  restart();
  keep(*suspect_);
  suspect_.reset();
  keep(exchange);
  return true;
}

bool ClockModel::contradicts(const ClockExchange& exchange) const {
  if (best_.empty()) return false;
  const std::int64_t at = exchange.middle_ns();
  const OffsetLine line(best_, at, prior_);
  const double off_ns = static_cast<double>(std::abs(exchange.offset_ns() - (line.node_time_ns(at) - at)));
  const double limit_ns = std::max(static_cast<double>(kLeastBreak_ns),
                                   kUncertainties * 1e9 * line.uncertainty_s(at, age_s(best_, at)));
  return off_ns > limit_ns + 0.5 * static_cast<double>(exchange.round_trip_ns());
}

void ClockModel::keep(const ClockExchange& exchange) {
  ++since_start_;
  if (!best_.empty() && bin_of(best_.back()) == bin_of(exchange)) {
    if (exchange.round_trip_ns() < best_.back().round_trip_ns()) best_.back() = exchange;
    return;
  }
  const std::int64_t oldest = bin_of(exchange) - static_cast<std::int64_t>(kBins) + 1;
  const auto aged_out = [&](const ClockExchange& e) { return bin_of(e) < oldest; };
  if (!best_.empty() && aged_out(best_.back())) {
    const OffsetLine line(best_, best_.back().middle_ns(), prior_);
    prior_ = {line.drift(), std::min(DriftPrior{}.sigma, line.drift_sigma() + kStaleDrift)};
  }
  std::erase_if(best_, aged_out);
  best_.push_back(exchange);
}

void ClockModel::host_stepped() {
  ++breaks_;
  suspect_.reset();
  restart();
}

void ClockModel::restart() {
  best_.clear();
  prior_ = {};
  since_start_ = 0;
}

ClockFit ClockModel::fit(std::int64_t host_ns) {
  ClockFit fit{.node = node_,
               .epoch = epoch_,
               .number = ++fits_,
               .host_ns = host_ns,
               .exchanges = exchanges_,
               .unanswered = unanswered_,
               .breaks = breaks_};
  if (best_.empty()) return fit;
  const OffsetLine line(best_, host_ns, prior_);
  const double age = age_s(best_, host_ns);
  fit.node_ns = line.node_time_ns(host_ns);
  fit.drift = line.drift();
  fit.uncertainty_s =
      line.uncertainty_s(host_ns + kFitLife_ns, age + 1e-9 * static_cast<double>(kFitLife_ns));
  fit.round_trip_s = line.round_trip_s();
  fit.residual_s = line.residual_s();
  if (is_locked())
    fit.state = age * 1e9 > static_cast<double>(kHoldover_ns) ? ClockState::kHoldover : ClockState::kLocked;
  return fit;
}

}  // namespace roadbalance
