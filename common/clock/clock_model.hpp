#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/clock/offset_line.hpp"
#include "common/types/exchange.hpp"

namespace roadbalance {

/// How one node's clock stands to the host's, from exchanges as they come; pure: its time is that of the
/// exchanges.
///
/// Per second the exchange with the shortest round trip counts (D. Mills' clock filter, RFC 5905, section
/// 10), over the last 32 s an OffsetLine through these.  Once every exchange has aged out, the drift found
/// last is kept as prior knowledge.  An exchange proves by its own round trip how far it can be wrong; two in
/// a row that prove a jump of more than max(kLeastBreak_ns, 5 u) are a break of the node's time base: it is
/// counted and the line begins anew, nothing is smeared over it.
class ClockModel {
 public:
  static constexpr std::int64_t kBin_ns = 1'000'000'000;
  static constexpr std::size_t kBins = 32;
  static constexpr std::int64_t kHoldover_ns = 3'000'000'000;  ///< without an exchange
  static constexpr int kLeastExchanges = 4;                    ///< to be locked
  static constexpr std::int64_t kLeastBreak_ns = 1'000'000;    ///< a smaller jump is none
  static constexpr std::int64_t kFitLife_ns = 1'000'000'000;   ///< a fit is used so long, until the next one

  ClockModel(std::int32_t node, std::int64_t epoch) : node_(node), epoch_(epoch) {}

  /// @return true if it proved a break
  bool add(const ClockExchange& exchange);
  /// The host's clock steps, or may have: a break of the time base.
  void host_stepped();
  /// A question was not answered.
  void add_unanswered() { ++unanswered_; }

  /// The relation at an instant of the host clock, its uncertainty that of the whole kFitLife_ns from then
  /// on; numbered from 1 in order of call.
  ClockFit fit(std::int64_t host_ns);

  std::int64_t breaks() const { return breaks_; }
  /// Enough exchanges since the line began.
  bool is_locked() const { return since_start_ >= kLeastExchanges; }

 private:
  bool contradicts(const ClockExchange& exchange) const;
  void keep(const ClockExchange& exchange);
  void restart();

  const std::int32_t node_;
  const std::int64_t epoch_;
  std::vector<ClockExchange> best_;  ///< one a bin, ascending
  DriftPrior prior_;
  std::optional<ClockExchange> suspect_;  ///< the last one, if it proves a jump
  std::int64_t since_start_ = 0;          ///< exchanges since the line began
  std::int64_t exchanges_ = 0, unanswered_ = 0, breaks_ = 0, fits_ = 0;
};

}  // namespace roadbalance
