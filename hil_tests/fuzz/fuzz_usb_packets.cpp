#include <cstdint>
#include <memory>
#include <vector>

#include "firmware/backends/usb/board_reader.hpp"
#include "firmware/board/packet.hpp"
#include "hil_tests/fuzz/byte_reader.hpp"
#include "hil_tests/fuzz/property.hpp"

// Transfers as a node reads them: of one or two boards, honest, jumping, spoiled, or with any fields that a
// CRC can cover.
namespace roadbalance {
namespace {

using fuzz::require;

fuzz::Reached scans("a scan"), edges("an edge");

constexpr std::uint32_t kTickHz = 10'000'000;
constexpr std::uint32_t kTicksPerScan = 1000;
constexpr std::uint64_t kFirstTicks = std::uint64_t{1} << 40;

/// Sample of a board's scan, by its number, modulo kMarked, and the channel.
constexpr std::int32_t kChannelsMarked = 64, kMarked = 1 << 16;
std::int32_t mark(std::uint64_t scan, std::size_t board, std::size_t channel) {
  const auto of_scan = static_cast<std::int32_t>(scan % kMarked) * kChannelsMarked;
  return of_scan + static_cast<std::int32_t>(32 * board + channel);
}

class Run {
 public:
  explicit Run(std::span<const std::uint8_t> bytes)
      : in_(bytes), boards_(1 + in_.byte() % 2u), reader_(make_reader()) {}

  void play() {
    begin();
    while (!in_.empty()) {
      step();
      hand_over();
    }
  }

 private:
  std::unique_ptr<BoardReader> make_reader() {
    std::vector<DeviceReport*> reports{&report_[0]};
    if (boards_ > 1) reports.push_back(&report_[1]);
    return std::make_unique<BoardReader>(reports, 1.0 * kTickHz / kTicksPerScan, 12, std::array{true, true});
  }

  void step() {
    switch (in_.byte() % 8) {
      case 0:
        return begin();
      case 1:
        now_ += std::chrono::milliseconds(in_.below(65'536));
        return;
      case 2: {
        const auto any = in_.take(static_cast<std::size_t>(in_.below(4096)));
        return send(std::vector(any.begin(), any.end()));
      }
      case 3:
        return send(spoiled(packet(header())));
      case 4:
        return send(packet(any_header()));
      default:
        return send(packet(header()));
    }
  }

  void begin() {
    delivery_.kind = BoardDelivery::Kind::kRunBegin;
    delivery_.run.token = ++token_;
    delivery_.run.ticks_per_scan = {kTicksPerScan, kTicksPerScan};
    delivery_.run.tick_hz = {kTickHz, kTickHz};
    for (std::size_t k = 0; k < 2; ++k) {
      delivery_.run.begin[k] = {kFirstTicks, now_};
      next_[k] = {};
    }
    reader_->take(delivery_);
    delivery_.kind = BoardDelivery::Kind::kTransfer;
    absences_ = 1;
  }

  /// As the board would go on, perhaps behind a loss.
  board::PacketHeader header() {
    delivery_.board = static_cast<std::uint8_t>(in_.below(static_cast<std::int64_t>(boards_)));
    board::PacketHeader& next = next_[delivery_.board];
    next.token = token_;
    next.ticks_per_scan = kTicksPerScan;
    if (in_.byte() % 4 == 0) {
      next.sequence += in_.byte();
      next.first_scan += static_cast<std::uint64_t>(in_.below(3000));
    }
    next.scans = static_cast<std::uint16_t>(in_.below(160));
    next.edges = static_cast<std::uint16_t>(in_.below(10));
    next.base_ticks = kFirstTicks + (next.first_scan + 1) * kTicksPerScan;
    const board::PacketHeader header = next;
    ++next.sequence;
    next.first_scan += next.scans;
    now_ += std::chrono::microseconds(100 * next.scans);
    return header;
  }

  board::PacketHeader any_header() {
    board::PacketHeader header = Run::header();
    header.sequence = static_cast<std::uint32_t>(in_.number(4));
    header.first_scan = in_.number(8);
    header.base_ticks = in_.byte() % 2 ? in_.number(8) : kFirstTicks + in_.number(5);
    header.ticks_per_scan = in_.byte() % 2 ? kTicksPerScan : static_cast<std::uint32_t>(in_.number(4));
    header.scans_lost = static_cast<std::uint32_t>(in_.number(4));
    header.flags = in_.byte();
    return header;
  }

  std::vector<std::uint8_t> packet(const board::PacketHeader& header) {
    std::vector<std::uint8_t> bytes(board::packet_bytes(header.scans, header.edges));
    const std::span<std::uint8_t> all(bytes);
    board::encode_header(header, all.first<board::kHeaderBytes>());
    std::size_t at = board::kHeaderBytes;
    for (std::uint16_t k = 0; k < header.scans; ++k, at += board::kScanBytes) {
      board::PacketScan scan{.overload = k};
      for (std::size_t c = 0; c < board::kStreamChannels; ++c)
        scan.counts[c] = mark(header.first_scan + k, delivery_.board, c);
      board::encode_scan(scan, all.subspan(at).first<board::kScanBytes>());
    }
    std::int32_t offset = in_.byte() % 16 ? -500 : static_cast<std::int32_t>(in_.number(3)) - (1 << 23);
    for (int k = 0; k < header.edges; ++k, at += board::kEdgeBytes) {
      offset += in_.byte() % 64;
      board::encode_edge({offset, static_cast<std::uint8_t>(in_.byte() % 3),
                          static_cast<board::PacketEdgeKind>(in_.byte() % 5), 0},
                         all.subspan(at).first<board::kEdgeBytes>());
    }
    board::seal_packet(all);
    return bytes;
  }

  std::vector<std::uint8_t> spoiled(std::vector<std::uint8_t> bytes) {
    if (in_.byte() % 2)
      bytes.resize(static_cast<std::size_t>(in_.below(static_cast<std::int64_t>(bytes.size()))));
    else
      bytes[static_cast<std::size_t>(in_.below(static_cast<std::int64_t>(bytes.size())))] ^= 1;
    return bytes;
  }

  void send(const std::vector<std::uint8_t>& bytes) {
    if (bytes.size() > delivery_.bytes.size()) return;
    std::copy(bytes.begin(), bytes.end(), delivery_.bytes.begin());
    delivery_.size = static_cast<std::uint32_t>(bytes.size());
    delivery_.dropped = in_.byte() % 8 ? 0 : in_.byte();
    delivery_.arrival = now_;
    reader_->take(delivery_);
  }

  void hand_over() {
    for (bool more = true; more;) {
      Read read;
      more = !reader_->hand_over(scans_, edges_, read);
      require(!more || read.scans == scans_.size() || read.edges == edges_.size(), "it stops only when full");
      for (const Scan& scan : std::span(scans_).first(read.scans)) {
        require(scan.index > last_, "numbers rise");
        const auto marked = static_cast<std::uint64_t>(scan.counts[0] / kChannelsMarked);
        const std::size_t inputs = board::kInputChannels / boards_;
        for (std::size_t c = 0; c < kAccelerations; ++c)
          require(scan.counts[c] == mark(marked, c / inputs, c % inputs),
                  "each channel of one and the same scan");
        require(scan.after_absence || last_ < 0 ||
                    (scan.index - last_ - scan.counts[0] / kChannelsMarked + marked_) % kMarked == 0,
                "numbered as the board did");
        last_ = scan.index;
        marked_ = scan.counts[0] / kChannelsMarked;
        scans.count();
        require(!scan.after_absence || absences_-- > 0, "a run begins once");
        require(scan.overload < 1u << kChannels, "only channels that there are");
      }
      for (const Edge& edge : std::span(edges_).first(read.edges))
        require(edge.line < kEncoderLines && edge.kind <= EdgeKind::kLost, "only edges that there are");
      if (read.edges > 0) edges.count();
    }
  }

  fuzz::ByteReader in_;
  const std::size_t boards_;
  std::array<DeviceReport, 2> report_{DeviceReport("usb:first"), DeviceReport("usb:second")};
  std::unique_ptr<BoardReader> reader_;
  NodeTime now_ = node_time_from_ns(1'000'000'000'000);
  std::uint32_t token_ = 0;
  std::array<board::PacketHeader, 2> next_;
  BoardDelivery delivery_;
  std::int64_t last_ = -1, marked_ = 0;
  int absences_ = 0;
  std::array<Scan, 37> scans_;
  std::array<Edge, 5> edges_;
};

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  roadbalance::Run({data, size}).play();
  return 0;
}
