#include "hil_tests/simulated_truth.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <memory>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/record/record_reader.hpp"
#include "common/test/source.hpp"
#include "sim/front_end.hpp"

namespace roadbalance::test {
namespace {

constexpr std::size_t kScansAtOnce = 256;

/// One node of the car, as fast as it is read.
class SimulatedNode {
 public:
  SimulatedNode(const std::string& name, const std::string& drive)
      : vehicle_(VehicleConfig::read_file(source_path("sim/demo/vehicle.toml"))),
        node_(*std::ranges::find(vehicle_.node, name, &NodeConfig::name)),
        device_(sim::open_sim_front_end({"?rate=max&" + drive, vehicle_, node_})) {}

  int number() const { return node_.id; }
  double rate_hz() const { return node_.rate_hz; }

  /// The scan after the one that was given before; nullptr: the drive is over.
  const Scan* next() {
    while (given_ == got_) {
      const Read read = device_->read(scans_, edges_read_, {});
      edges_.insert(edges_.end(), edges_read_.begin(),
                    edges_read_.begin() + static_cast<std::ptrdiff_t>(read.edges));
      given_ = 0;
      got_ = read.scans;
      if (read.status != ReadStatus::kOk && got_ == 0) return nullptr;
    }
    return &scans_[given_++];
  }
  /// Those before the scans that were read, and not taken from here.
  std::deque<Edge>& edges() { return edges_; }

 private:
  const VehicleConfig vehicle_;
  const NodeConfig& node_;
  std::unique_ptr<FrontEnd> device_;
  std::vector<Scan> scans_{kScansAtOnce};
  std::vector<Edge> edges_read_{1024};
  std::deque<Edge> edges_;
  std::size_t given_ = 0, got_ = 0;
};

class Comparison {
 public:
  Comparison(const std::string& node, const std::string& drive) : car_(node, drive) {}

  void take(const SealedBlock& block) {
    if (block.header.node != car_.number() || block.header.sequence == 0) return;
    if (block.kind == BlockKind::kScan) take(decode_scan(block));
    if (block.kind == BlockKind::kEdge)
      for (const Edge& edge : decode_edge(block).unpack()) recorded_edges_.push_back(edge);
  }

  void finish() {
    EXPECT_GT(scans_, 0);
    EXPECT_EQ(wrong_scans_, 0) << "of " << scans_ << ", the first at "
                               << static_cast<double>(first_wrong_) / car_.rate_hz() << " s";
    const auto is_before = [](const Edge& edge, std::int64_t time_ns) { return to_ns(edge.time) < time_ns; };
    const auto is_the_same = [](const Edge& a, const Edge& b) {
      return a.time == b.time && a.line == b.line && a.kind == b.kind;
    };
    const auto between = [&](auto& edges) {
      const auto first = std::lower_bound(edges.begin(), edges.end(), first_ns_, is_before);
      return std::vector<Edge>(first, std::lower_bound(first, edges.end(), last_ns_, is_before));
    };
    const auto there = between(recorded_edges_);
    const auto given = between(car_.edges());
    EXPECT_GT(given.size(), 0u);
    EXPECT_EQ(there.size(), given.size());
    EXPECT_TRUE(std::ranges::equal(there, given, is_the_same)) << "edges are not those of the wheels";
  }

 private:
  void take(const ScanBlock& block) {
    for (std::int64_t row = 0; row < block.header.scans; ++row) {
      const Scan* scan = car_.next();
      // The car was on the road before it was recorded.
      while (scan && scans_ == 0 && to_ns(scan->time) < block.header.time_ns) scan = car_.next();
      ASSERT_NE(scan, nullptr) << "there are more scans than the drive has";
      const auto& counts = block.counts[static_cast<std::size_t>(row)];
      const bool is_right = to_ns(scan->time) == block.row_time_ns(row) &&
                            std::equal(scan->counts.begin(), scan->counts.end(), counts.begin());
      if (!is_right && wrong_scans_++ == 0) first_wrong_ = scan->index;
      if (scans_++ == 0) first_ns_ = to_ns(scan->time);
      last_ns_ = to_ns(scan->time);
    }
  }

  SimulatedNode car_;
  std::vector<Edge> recorded_edges_;
  std::int64_t scans_ = 0, wrong_scans_ = 0, first_wrong_ = 0;
  std::int64_t first_ns_ = 0, last_ns_ = 0;
};

}  // namespace

void expect_as_simulated(const std::filesystem::path& record, const std::string& node,
                         const std::string& drive) {
  Comparison comparison(node, drive);
  RecordReader reader(record);
  reader.finish();
  SealedBlock block;
  while (const auto event = reader.next())
    if (accept(event->data, block) == Refusal::kNone) comparison.take(block);
  comparison.finish();
}

}  // namespace roadbalance::test
