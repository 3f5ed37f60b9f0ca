#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/dsp/window.hpp"

namespace roadbalance {

inline constexpr const char* kViewChannel = "RB_VIEW";
inline constexpr const char* kTransferFunctionChannel = "RB_TRANSFER";

/// A channel as messages name it.
struct ChannelId {
  std::int32_t node = 0;
  std::int32_t channel = 0;

  friend auto operator<=>(const ChannelId&, const ChannelId&) = default;
};

struct ChannelPair {
  ChannelId input, output;
};

/// A channel, and the wheel whose orders are looked at in it.
struct WheelChannel {
  std::int32_t wheel = 0;  ///< 0 .. kWheels - 1
  ChannelId channel{};

  friend auto operator<=>(const WheelChannel&, const WheelChannel&) = default;
};

inline constexpr std::size_t kMostViewPairs = 16, kMostViewChannels = 16, kMostViewWaterfalls = 4;
inline constexpr int kShortestSegment = 1024, kLongestSegment = 65'536;  ///< that a view may ask for

/// The plots that a viewer asks for; fields as in common/wire/view_t.
struct View {
  std::int64_t viewer = 0;
  std::int32_t segment = 4096;
  Window window = Window::kHann;
  std::int32_t memory = 0;
  bool hold_peaks = false;
  double overlap = 0.5;
  double highest_hz = 250.0;
  std::vector<ChannelPair> pair{};        ///< at most kMostViewPairs
  std::vector<ChannelId> spectrum{};      ///< at most kMostViewChannels
  std::vector<ChannelId> envelope{};      ///< at most kMostViewChannels
  std::vector<WheelChannel> waterfall{};  ///< at most kMostViewWaterfalls
};

inline constexpr std::size_t kTransferFunctionBinsPerPart = 48;

/// Why there is no transfer function, or no spectrum (yet).
enum class SpectralState : std::int32_t {
  kComputed = 0,
  kTooShort = 1,      ///< no segment is full yet
  kNoChannel = 2,     ///< the vehicle has no such channel in use
  kNoCommonTime = 3,  ///< the nodes' samples do not lie on one grid of time
  kTooMuch = 4,       ///< segments this long of so many channels are more than the analyser holds
};

/// Part of a transfer function; fields as in common/wire/transfer_t.
struct TransferFunctionPart {
  std::int64_t viewer = 0;
  ChannelPair pair{};
  SpectralState state = SpectralState::kComputed;
  std::int64_t time_ns = 0;
  std::int32_t part = 0, parts = 1;
  double first_hz = 0.0, step_hz = 0.0, enbw_hz = 0.0;
  double independent_averages = 0.0, coherence_by_chance = 1.0;
  struct Bin {
    float input = 0.0F, output = 0.0F, h1_re = 0.0F, h1_im = 0.0F, radius_95 = 0.0F, coherence = 0.0F;
  };
  std::vector<Bin> bin{};  ///< at most kTransferFunctionBinsPerPart
};

std::vector<std::uint8_t> encode(const View& message);
std::vector<std::uint8_t> encode(const TransferFunctionPart& message);
std::optional<View> decode_view(std::span<const std::uint8_t> bytes);
std::optional<TransferFunctionPart> decode_transfer_function(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
