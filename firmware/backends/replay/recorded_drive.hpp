#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "common/record/record_reader.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {

/// A run of what one node had from its devices, in order: the edges and samples come no later than the first
/// scan that is younger.
struct RecordedPiece {
  std::vector<Scan> scans;
  std::vector<Edge> edges;
  std::vector<SignalSample> signals;
};

/// Reads what a node's devices gave back out of its recording: scans with the index they had since the start,
/// gaps as jumps of it; edges and samples of signals as they were stamped.
///
/// The record has edges up to 1.3 s behind the scans they belong to; here they are in order again.
class RecordedDrive {
 public:
  /// @param epoch  which run of the node; nothing: the only one
  /// @throws std::system_error if the folder cannot be read, ConfigError if it holds no scan of the node, or
  ///         several runs of it and none was chosen
  RecordedDrive(const std::filesystem::path& folder, std::int32_t node, std::optional<std::int64_t> epoch);

  /// The next twentieth of a second or so; nothing at the end.
  std::optional<RecordedPiece> next();

  NodeTime first_scan() const { return first_scan_; }

 private:
  void fill();
  bool take(const SealedBlock& block);

  RecordReader reader_;
  const std::int32_t node_;
  std::int64_t epoch_ = 0;
  std::int64_t last_sequence_ = 0;
  NodeTime first_scan_{};
  bool over_ = false;
  bool absent_ = false;  ///< the gap before the next scan is one of a device that was gone
  bool slept_ = false;   ///< the same of a sleep
  std::deque<Scan> scans_;
  std::deque<Edge> edges_;
  std::deque<SignalSample> signals_;
  std::unique_ptr<SealedBlock> block_ = std::make_unique<SealedBlock>();
};

}  // namespace roadbalance
