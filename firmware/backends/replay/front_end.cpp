#include "firmware/backends/replay/front_end.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "common/config/address_query.hpp"
#include "common/frontend/pace.hpp"
#include "common/process/channel.hpp"
#include "firmware/backends/replay/lateness.hpp"
#include "firmware/backends/replay/recorded_drive.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kPiecesAhead = 80;  // of a twentieth of a second each
constexpr auto kLongestWait = std::chrono::milliseconds(100);
constexpr std::size_t kRunScans = 64;  // a reader is not woken for every scan

/// Process: record -> pieces, ahead of their time.  A record that cannot be read any more is reported.
void read_ahead(RecordedDrive drive, Out<RecordedPiece> pieces, std::atomic<bool>& failed) {
  try {
    while (auto piece = drive.next())
      if (!pieces.send(std::move(*piece))) return;
  } catch (const std::exception&) {
    failed.store(true);
  }
}

class ReplayFrontEnd final : public FrontEnd {
 public:
  using Inform = std::function<void(const std::string&)>;

  ReplayFrontEnd(RecordedDrive drive, std::optional<double> rate, double rate_hz, Inform inform)
      : inform_(std::move(inform)), first_(drive.first_scan()), run_s_(std::min(5e-3, kRunScans / rate_hz)) {
    auto [out, in] = make_channel<RecordedPiece>(kPiecesAhead);
    pieces_.emplace(std::move(in));
    reader_ = std::jthread([this, drive = std::move(drive), out = std::move(out)]() mutable {
      read_ahead(std::move(drive), std::move(out), failed_);
    });
    if (rate) pace_.emplace(*rate, WallClock::now());
  }
  ~ReplayFrontEnd() override {
    pieces_.reset();  // before the thread is waited for
    if (inform_ && lateness_.events() > 0) inform_(lateness_.sentence());
  }

  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample> signals) noexcept override {
    Read read;
    const NodeTime due = wait();
    while (read.scans < scans.size()) {
      if (piece_is_empty() && !next_piece()) {
        if (pieces_->finished()) read.status = failed_ ? ReadStatus::kFailed : ReadStatus::kEnd;
        break;
      }
      const NodeTime next_scan = scan_ < piece_.scans.size() ? piece_.scans[scan_].time : NodeTime::max();
      const NodeTime until = std::min(next_scan, due);
      give(until, piece_.edges, edge_, edges, read.edges);
      give(until, piece_.signals, signal_, signals, read.signals);
      const bool no_room =
          waits_before(until, piece_.edges, edge_) || waits_before(until, piece_.signals, signal_);
      if (no_room || (next_scan > due && !piece_is_empty())) break;
      if (scan_ == piece_.scans.size()) continue;
      scans[read.scans++] = piece_.scans[scan_++];
    }
    return read;
  }

  bool waits() const noexcept override { return !pace_ || pace_->rate() != 1.0; }
  NodeTime node_time(MachineTime machine) const noexcept override {
    return pace_ ? first_ + NodeClock::duration(pace_->drive_ns(machine)) : NodeTime{};
  }

 private:
  /// Waits for a run of scans.  Returns up to which time they are due.
  NodeTime wait() noexcept {
    if (!pace_) return NodeTime::max();
    const auto since_start = [&](NodeTime time) { return to_seconds(time - first_); };
    if (scan_ < piece_.scans.size()) {
      const WallTime at = pace_->wall(since_start(piece_.scans[scan_].time) + run_s_ * pace_->rate());
      std::this_thread::sleep_until(std::min(at, WallClock::now() + kLongestWait));
      // A gap is waited for in parts.
      if (const WallTime now = WallClock::now(); now >= at) lateness_.add(now - at);
    }
    return first_ + NodeClock::duration(std::llround(1e9 * pace_->drive_s(WallClock::now())));
  }

  bool piece_is_empty() const {
    return scan_ == piece_.scans.size() && edge_ == piece_.edges.size() && signal_ == piece_.signals.size();
  }

  bool next_piece() {
    auto piece = pieces_->receive_for(kLongestWait);
    if (!piece) return false;
    piece_ = std::move(*piece);
    scan_ = edge_ = signal_ = 0;
    return true;
  }

  template <typename Item>
  static bool waits_before(NodeTime until, const std::vector<Item>& from, std::size_t next) {
    return next < from.size() && from[next].time <= until;
  }

  /// Copies what is not younger than `until`, as far as there is room.
  template <typename Item>
  static void give(NodeTime until, const std::vector<Item>& from, std::size_t& next, std::span<Item> to,
                   std::size_t& used) {
    while (next < from.size() && used < to.size() && from[next].time <= until) to[used++] = from[next++];
  }

  const Inform inform_;
  Lateness lateness_;
  const NodeTime first_;
  const double run_s_;
  std::atomic<bool> failed_{false};
  std::optional<In<RecordedPiece>> pieces_;
  std::jthread reader_;
  std::optional<Pace> pace_;
  RecordedPiece piece_;
  std::size_t scan_ = 0, edge_ = 0, signal_ = 0;  ///< next of piece_
};

}  // namespace

std::unique_ptr<FrontEnd> open_replay_front_end(const FrontEndRequest& request,
                                                const std::function<void(const std::string&)>& inform) {
  AddressQuery query("replay", request.address);
  const std::optional<double> rate = query.rate();
  const auto epoch = query.number<std::int64_t>("epoch", 1, INT64_MAX);
  const auto name = query.text("node");
  query.finish();
  if (query.path().empty()) query.fail("no recording; allowed: replay:FOLDER");
  const NodeConfig& node = name ? request.vehicle.node_named(*name) : request.node;
  ReplayFrontEnd::Inform inform_named;
  if (inform)
    inform_named = [inform, path = query.path()](const std::string& sentence) {
      inform("replay:" + path + ": " + sentence);
    };
  return std::make_unique<ReplayFrontEnd>(RecordedDrive(query.path(), node.id, epoch), rate, node.rate_hz,
                                          std::move(inform_named));
}

}  // namespace roadbalance
