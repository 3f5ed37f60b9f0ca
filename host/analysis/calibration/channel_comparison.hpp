#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/types/blocks.hpp"
#include "host/analysis/calibration/channel_match.hpp"

namespace roadbalance {

/// Channel-matching calibration of a node: all its inputs were given one signal, and what they make of it
/// finds how their gains and delays differ.
///
/// Beside channels in use those of a loop-back are compared, which pass the same filters and converters: an
/// angle is known against them, so that their median is the reference for delays; without a loop-back it is
/// the median of all channels.  For gains it is the median of the accelerations always.  Motion does not go
/// through a loop-back: then it has no part.
class ChannelComparison {
 public:
  struct Settings {
    double low_hz = 2.0, high_hz = 30.0;
    double segment_s = 2.0;
    /// All sensors felt one motion; else all inputs were given one voltage, and sensors have no part in it.
    bool motion = false;
    std::string reference{};  ///< channel that stays as it is; empty: the medians
  };
  /// A channel further from the others' size than this share is not matched but left as it is: what an input
  /// hears of its neighbours, or a range that vehicle.toml does not have.
  static constexpr double kMostMismatch = 0.2;

  /// Whether the node has the reference that is named, if one is.
  static bool has_reference(const NodeConfig& node, const Settings& settings);

  /// @throws ConfigError naming what cannot be compared
  ChannelComparison(const NodeConfig& node, const Settings& settings);

  /// Blocks of the node as they come; what an overload of what is compared, or a hole touches is left out.
  void add(const ScanBlock& block);

  struct Channel {
    std::string name;
    ChannelMatch match;
    // The correction that makes a matched acceleration like the reference.
    bool can_be_set = false;
    double scale_m_s2_per_count = 0.0;
    double offset_counts = 0.0;  ///< as it was
    double delay_s = 0.0;
  };
  struct Result {
    std::vector<Channel> channel;  ///< empty: there is a refusal
    double seconds = 0.0;          ///< compared
    double overload_s = 0.0;       ///< left out
    std::string refusal{};         ///< why there is no result and what would help, for people
  };
  Result result() const;
  /// A drive without a hole must last so long at least.
  double least_s() const { return 0.5 * (kLeastAverages + 1) * settings_.segment_s; }

 private:
  struct Input {
    std::string name;
    std::size_t place;  ///< among the node's 16
    double per_count;   ///< to what is compared
    double base_scale;  ///< m/s^2 per count of a channel of gain 1
    double present_delay_s, offset_counts;
    bool reference;  ///< of the loop-back
  };
  Input input_of(const ChannelConfig& channel, std::size_t place) const;
  bool loops_back() const;
  std::string text_of(ChannelMatches::Reason refusal) const;
  double size_of(const std::vector<ChannelMatch>& all, bool reference) const;
  bool loop_back_was_fed(const std::vector<ChannelMatch>& all) const;
  void doubt_other_sizes(std::vector<ChannelMatch>& all) const;

  const NodeConfig node_;
  const Settings settings_;
  std::vector<Input> input_;
  Eigen::MatrixXd samples_;  ///< [input x scan] of a block
  std::optional<CrossSpectra> spectra_;
  std::int32_t compared_ = 0;  ///< as bits of an overload
  std::int64_t epoch_ = 0, next_scan_ = -1, scans_ = 0, overloaded_ = 0;
};

}  // namespace roadbalance
