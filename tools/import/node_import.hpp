#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/dsp/clipping_detector.hpp"
#include "firmware/epoch_packer.hpp"

namespace roadbalance {

/// A sample this close to full scale is taken as clipped.
inline constexpr double kRangeEnd = 0.999;

/// Suspicious properties of an acceleration channel: an offset that gravity cannot explain, no signal,
/// clipping at its full scale or below. Nothing is corrected.
class ChannelSuspicion {
 public:
  /// @param channel  outlives this
  ChannelSuspicion(const ChannelConfig& channel, double rate_hz);

  /// The next of uniform samples; NaN: there is none.
  void add(double value_m_s2);
  /// Each as a clause in English: "is constant during 3 of 10 s".
  std::vector<std::string> found() const;

 private:
  void end_second();

  const ChannelConfig& channel_;
  const std::int64_t samples_a_second_;
  std::int64_t samples_ = 0;
  double mean_ = 0.0, squares_ = 0.0;  ///< of the present second; squares about its mean
  std::int64_t seconds_ = 0, constant_ = 0, offset_ = 0, clipped_ = 0;
  double sum_offset_ = 0.0;
  ClippingDetector clipping_;
};

/// Where each column of a file of samples stands in its rows.
using ColumnOf = std::map<std::string, std::size_t>;

/// One node's share of other programs' samples, sealed as the node would have sealed it.
class NodeImport {
 public:
  struct Counts {
    std::int64_t blocks = 0, scans = 0, scans_missing = 0, edges = 0;
  };

  /// @param vehicle  outlives this
  /// @param node     with the rate that the samples have; outlives this
  /// @param samples  the file, for errors
  NodeImport(const VehicleConfig& vehicle, const NodeConfig& node, const ColumnOf& columns,
             std::int64_t epoch, const std::filesystem::path& samples, EpochPacker::Take take);
  NodeImport(const NodeImport&) = delete;
  NodeImport& operator=(const NodeImport&) = delete;

  /// An edge, before the first row that is not earlier.
  void add(const Edge& edge);
  /// A row of the file.  One in which all of the node's cells are empty is a scan that it has not.
  /// @param row  from 0, for errors
  /// @throws ConfigError if some are
  void add(std::span<const double> cells, std::int64_t row, std::int64_t index, NodeTime time);
  /// Nothing follows.  Rows of the file before the node's first scan, and behind its last, are a gap, too.
  /// @throws ConfigError if the node has no scan at all
  void end();

  const NodeConfig& node() const { return node_; }
  const Counts& counts() const { return counts_; }
  /// Channels and what is strange about them, in their order; then wheels whose zero marks name no tooth.
  std::vector<std::pair<std::string, std::string>> suspicions() const;

 private:
  struct Input {
    std::size_t channel, column;
  };
  void seal();
  [[noreturn]] void refuse_absence() const;
  bool is_there(std::span<const double> cells, std::int64_t row) const;

  const VehicleConfig& vehicle_;
  const NodeConfig& node_;
  const std::filesystem::path samples_;
  std::vector<Input> input_;
  std::vector<std::pair<Input, ChannelSuspicion>> suspicion_;
  std::vector<Edge> edges_;  ///< not yet sealed, with scans_
  std::vector<Scan> scans_;
  bool has_sample_ = false;
  std::int64_t end_index_ = 0;  ///< behind the last row, with its time
  NodeTime end_time_{};
  Counts counts_;
  std::array<std::array<int, 2>, kEncoderLines> mark_counts_{};  ///< the latest that were wrong
  EpochPacker packer_;
};

}  // namespace roadbalance
