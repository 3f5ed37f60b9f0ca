#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>

namespace roadbalance {

/// Finds the value at which a channel is clipped, whatever range it is said to have.
///
/// A signal spends the less time at a value the further that is from its rest.  Where tops are cut off, the
/// time that they would have spent beyond is spent at the limit: the density of the samples rises there once
/// more, and next to nothing lies beyond.  With L a distance from the rest, n the samples at or beyond a
/// distance and K the tops that reach the limit, a side is clipped at L if one of these holds:
///
///     flat     K >= 16 and at least five times as many samples in the last 2 % below L as in each 2 % from
///              4 % to 10 % below it; no more beyond L than in them
///     rounded  K >= 24 and n(0.95 L) - n(1.05 L) >= (1 + 1.5 / sqrt(K)) (n(0.85 L) - n(0.95 L));
///              n(1.05 L) <= 0.15 n(0.95 L); K / 4 tops or more between 0.7 L and 0.9 L
///
/// "Flat" is a converter or a sensor at its end.  Behind a limit the anti-aliasing filter rounds the edges
/// and overshoots by a few per cent, and a rough signal leaves the limit again and again: "rounded".  Noise
/// and single shocks show no second rise, however heavy their tails, and 1.5 / sqrt(K) is their scatter.  A
/// steady tone does: a sine spends 3.7 times as long in its last 2 % as in the parts it is compared with (the
/// arcsine law).  But its tops are all alike.  So an eighth of the tops at the limit ("rounded": a quarter)
/// must be followed by one that does not reach it, or ("flat") it is there for a third of the time on this
/// side; and tops must last three samples.  A quantised or resting channel is not judged before it moves by
/// 16
/// ("rounded": 40) of its own steps.
///
/// What it cannot tell: tops shorter than three samples; a limit that fewer than 16 tops have reached; a
/// tone that loses less than a sixth of its height.
///
/// The distances are from the first second's mean.  All that came counts.  A limit holds until
/// n(1.05 L) > 0.3 n(0.95 L).
class ClippingDetector {
 public:
  /// Where it is clipped, counts, to 5 % of L; nothing: that side is not known to be.
  struct Limits {
    std::optional<std::int32_t> low, high;
    std::int64_t rest = 0;

    bool any() const { return low || high; }
    /// True from 0.95 L on.
    bool reached_by(std::int32_t counts) const {
      const auto within = [off = counts - rest, this](std::int64_t limit) {
        return 20 * std::abs(off) >= 19 * std::abs(limit - rest);
      };
      return counts >= rest ? high && within(*high) : low && within(*low);
    }
  };

  /// @param rate_hz  of the samples, > 0: there is a verdict each second
  explicit ClippingDetector(double rate_hz);

  /// The next sample, of 24 bits.  True if it ends a second: limits() are of now.  Never allocates.
  bool add(std::int32_t counts) noexcept;
  /// Samples are missing before the next one.
  void skip() noexcept;
  /// Forgets all: the samples to come are of another device.
  void restart() noexcept;

  const Limits& limits() const { return limits_; }

 private:
  static constexpr int kBins = 512;
  static constexpr int kMinute_s = 60;

  /// One side of the rest.  A bin is 2^shift steps wide.
  struct Side {
    std::array<std::uint32_t, kBins> samples{}, tops{};
    std::array<std::int32_t, kBins> falls{};  ///< +1 in a top's bin and -1 in that of the lower one behind it
    int shift = 0;
    std::int64_t last_top = 0;          ///< steps
    std::optional<std::int64_t> limit;  ///< L, steps

    int bin(std::int64_t steps) const { return static_cast<int>(steps >> shift); }
    void widen(std::int64_t steps);
    void end_top(std::int64_t steps);
  };
  struct Sums {
    std::int64_t samples = 0, sum = 0, squares = 0;  ///< of distances from the rest, in counts
  };
  /// How many lie in a bin or beyond.
  struct Beyond {
    std::array<std::int64_t, kBins + 1> samples, tops, falls;
  };

  void place(std::int32_t counts) noexcept;
  void end_second() noexcept;
  void begin(std::int32_t rest) noexcept;
  bool moved_away() noexcept;
  void judge(std::size_t side) noexcept;
  bool is_passed(int bin) const noexcept;
  bool is_flat(int bin) const noexcept;
  bool is_rounded(int bin) const noexcept;

  std::int64_t second_;                ///< samples
  std::optional<std::int32_t> last_;   ///< newest sample
  std::int64_t least_difference_ = 0;  ///< between successive samples, not 0; 0: none yet
  std::optional<std::int32_t> rest_;
  std::int64_t step_ = 0;  ///< of the channel's own resolution, counts
  Sums now_, before_, minute_;
  std::array<Side, 2> side_;       ///< above, below
  std::optional<std::size_t> at_;  ///< the side on which it is
  std::int64_t top_ = 0;           ///< since it is there, steps
  Limits limits_;
  Beyond beyond_;
};

}  // namespace roadbalance
