#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "common/bus/bus.hpp"
#include "host/analysis/calibration/line_edges.hpp"

namespace roadbalance {

/// LineEdges of a node on a bus.
class EdgeListener {
 public:
  EdgeListener(const std::string& url, std::int32_t node, int line);

  /// Waits up to `timeout`, then takes all that has arrived.
  void handle(std::chrono::milliseconds timeout) { bus_.handle(timeout); }
  LineEdges line;

  std::vector<std::string> other_versions() { return bus_.other_versions(); }

 private:
  Bus bus_;
  std::unique_ptr<SealedBlock> block_ = std::make_unique<SealedBlock>();
};

}  // namespace roadbalance
