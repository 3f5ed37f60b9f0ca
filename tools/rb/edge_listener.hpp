#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "common/bus/bus.hpp"
#include "common/link/blocks.hpp"

namespace roadbalance {

/// The edges of one encoder line as its node sends them, half a second late at the most.  Nobody repairs
/// what the bus loses: where blocks were missed stands an edge of kind kLost.
class EdgeListener {
 public:
  EdgeListener(const std::string& url, std::int32_t node, int line);

  /// Waits up to `timeout`, then takes all that has arrived.
  void handle(std::chrono::milliseconds timeout) { bus_.handle(timeout); }
  /// For the taker to remove.
  std::deque<Edge> edges;

  /// The node sends previews: it is there, and would send its edges if somebody recorded.
  bool heard_preview() const { return preview_; }
  bool heard_blocks() const { return epoch_ != 0; }
  std::vector<std::string> other_versions() { return bus_.other_versions(); }

 private:
  void take(std::span<const std::uint8_t> bytes);

  Bus bus_;
  const std::int32_t node_;
  const int line_;
  std::unique_ptr<SealedBlock> block_ = std::make_unique<SealedBlock>();
  bool preview_ = false;
  std::int64_t epoch_ = 0, sequence_ = 0;
};

}  // namespace roadbalance
