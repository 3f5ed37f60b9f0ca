#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

#include "firmware/board/board.hpp"
#include "firmware/board/test/simulated_hardware.hpp"
#include "hil_tests/fuzz/byte_reader.hpp"
#include "hil_tests/fuzz/property.hpp"

namespace roadbalance::board {
namespace {

using fuzz::ByteReader;
using fuzz::require;

constexpr std::uint32_t kTickHz = 1'000'000;

fuzz::Reached any_packets("a packet of any fields"), packets("a packet of the board");
fuzz::Reached identities("an identity"), statuses("a status");

Identity identity() {
  Identity identity;
  identity.tick_hz = kTickHz;
  identity.rate_min_hz = 100;
  identity.rate_max_hz = 10'000;
  identity.filter_min_hz = 50;
  identity.filter_max_hz = 5'000;
  identity.filter_orders = 0xFF;
  identity.capabilities = kHasTestPattern;
  return identity;
}

// A board and what a host that reads all of it must see.
class Driven {
 public:
  void act(ByteReader& bytes);

 private:
  void request(ByteReader& bytes);
  void set_up(ByteReader& bytes);
  bool send(Request request, std::span<const std::uint8_t> data);
  void begin_if_started(bool done, Request request);
  void read();

  test::SimulatedHardware hardware_;
  Board board_{identity(), hardware_};
  std::array<std::uint8_t, kTransferBytes> packet_{};
  std::uint32_t sequence_ = 0;
  std::uint64_t next_scan_ = 0;
  std::uint64_t last_scan_ticks_ = 0;
  std::uint64_t holes_ = 0;
};

bool Driven::send(Request request, std::span<const std::uint8_t> data) {
  const SetupPacket setup{kVendorOut, static_cast<std::uint8_t>(request), 0, 0,
                          static_cast<std::uint16_t>(data.size())};
  const bool done = board_.control_request(setup, data, {}).has_value();
  begin_if_started(done, request);
  return done;
}

void Driven::begin_if_started(bool done, Request request) {
  if (!done || (request != Request::kArm && request != Request::kStart)) return;
  sequence_ = 0;
  next_scan_ = 0;
  last_scan_ticks_ = 0;
  holes_ = 0;
}

// A run that can begin, of a set-up that the bytes choose.
void Driven::set_up(ByteReader& bytes) {
  Configuration wanted;
  wanted.ticks_per_scan = static_cast<std::uint32_t>(100 + bytes.below(9'900));
  wanted.references_on = bytes.byte() & 1;
  wanted.packet_limit_us = static_cast<std::uint16_t>(500 + bytes.below(49'500));
  for (EncoderSetup& encoder : wanted.encoder)
    encoder = {static_cast<std::uint16_t>(4 + bytes.below(2'000)),
               static_cast<std::uint16_t>(bytes.byte() & 0x1F)};
  ReferenceSetup references;
  for (ReferenceWheel& wheel : references.wheel) wheel = {1, static_cast<std::uint8_t>(bytes.byte() & 1)};
  const auto mode = static_cast<StartMode>(bytes.below(3));
  send(Request::kStop, {});
  require(send(Request::kConfigure, encode(wanted)), "a possible configuration is taken");
  require(send(Request::kReferences, encode(references)), "possible references are taken");
  require(send(Request::kArm, encode(Arm{7, mode})), "a configured board can be armed");
  require(send(Request::kStart, encode(Start{7})) == (mode != StartMode::kFollower),
          "a follower is not started");
}

void Driven::request(ByteReader& bytes) {
  SetupPacket setup{bytes.byte(), bytes.byte(), bytes.byte(), bytes.byte(), bytes.byte()};
  const auto data = bytes.take(setup.request_type == kVendorOut ? setup.length : 0);
  std::array<std::uint8_t, 128> reply{};
  const auto size = board_.control_request(setup, data, reply);
  require(!size || *size <= setup.length, "no reply is longer than asked for");
  begin_if_started(size.has_value() && setup.request_type == kVendorOut, static_cast<Request>(setup.request));
}

void Driven::read() {
  const std::size_t size = board_.next_packet(packet_);
  if (size == 0) return;
  const auto packet = decode_packet({packet_.data(), size});
  require(packet.has_value(), "what the board sends can be read");
  packets.count();
  const PacketHeader& header = packet->header();
  require(header.sequence == sequence_++, "packets are numbered without gap");
  require(header.first_scan >= next_scan_, "no scan comes twice");
  holes_ += header.first_scan - next_scan_;
  require(holes_ <= std::uint64_t{header.scans_lost} + header.scans_missed, "every hole is counted");
  next_scan_ = header.first_scan + header.scans;
  for (std::size_t k = 0; k < header.edges; ++k) {
    const std::uint64_t ticks =
        header.base_ticks + static_cast<std::uint64_t>(std::int64_t{packet->edge(k).offset_ticks});
    require(ticks > last_scan_ticks_ || last_scan_ticks_ == 0, "no edge follows a scan that it was before");
  }
  if (header.scans > 0)
    last_scan_ticks_ =
        header.base_ticks + (header.scans - 1u) * std::uint64_t{header.ticks_per_scan} - kTickHz / 2'000'000;
}

void Driven::act(ByteReader& bytes) {
  hardware_.now += bytes.byte();
  switch (bytes.below(8)) {
    case 0:
      return request(bytes);
    case 1:
      return set_up(bytes);
    case 2:
      hardware_.now += static_cast<std::uint64_t>(bytes.below(65'536)) * 64;
      return;
    case 3:
      return read();
    case 4:
      board_.update_references(hardware_.now + bytes.byte());
      return;
    case 5: {
      const std::uint8_t what = bytes.byte();
      const std::uint64_t late = bytes.byte() & 0x0F;
      board_.line_change(what & 3, static_cast<Signal>((what >> 2) % 3), (what & 0x10) != 0,
                         hardware_.now - std::min(late, hardware_.now));
      return;
    }
    case 6: {
      ScanWords words{};
      words.fill(static_cast<std::uint32_t>(bytes.number(3)));
      for (int k = bytes.byte(); k >= 0; --k)
        board_.scan(words, 0, hardware_.now += hardware_.configuration.ticks_per_scan);
      return;
    }
    default:
      if (bytes.byte() == 0) board_.reset();
  }
}

// A host's reading of a board's replies: one may be longer, from a later board, and is not refused for it.
void check_replies(std::span<const std::uint8_t> bytes) {
  const auto begins = [&](const auto& encoded) {
    return std::equal(encoded.begin(), encoded.end(), bytes.begin());
  };
  if (const auto identity = decode_identity(bytes)) {
    require(begins(encode(*identity)), "an identity that was read is encoded as it came");
    identities.count();
  }
  if (const auto status = decode_status(bytes)) {
    require(begins(encode(*status)), "a status that was read is encoded as it came");
    statuses.count();
  }
}

// Bytes as a packet, with magic, lengths and CRC that let them through to the content.
void check_decoder(std::span<const std::uint8_t> bytes) {
  std::array<std::uint8_t, kMaxPacketBytes + 8> packet{};
  const std::size_t size = std::min(bytes.size(), packet.size());
  std::copy_n(bytes.begin(), size, packet.begin());
  (void)decode_packet(std::span(packet).first(size));
  if (size < packet_bytes(0, 0)) return;
  constexpr std::array<std::uint8_t, 8> kBegin = {'R',          'B', 'S', 'P', kProtocolMajor, kProtocolMinor,
                                                  kHeaderBytes, 0};
  std::copy(kBegin.begin(), kBegin.end(), packet.begin());
  seal_packet(std::span(packet).first(size));
  const auto view = decode_packet(std::span(packet).first(size));
  if (!view) return;
  any_packets.count();
  auto again = std::make_unique<std::array<std::uint8_t, kMaxPacketBytes>>();
  const std::span<std::uint8_t> out(*again);
  std::size_t at = kHeaderBytes;
  encode_header(view->header(), out.first<kHeaderBytes>());
  for (std::size_t k = 0; k < view->header().scans; ++k, at += kScanBytes)
    encode_scan(view->scan(k), out.subspan(at).first<kScanBytes>());
  for (std::size_t k = 0; k < view->header().edges; ++k, at += kEdgeBytes)
    encode_edge(view->edge(k), out.subspan(at).first<kEdgeBytes>());
  seal_packet(out.first(at + kCrcBytes));
  require(at + kCrcBytes == size &&
              std::equal(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size), packet.begin()),
          "encoding what was decoded gives the same bytes");
}

}  // namespace
}  // namespace roadbalance::board

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  if (size == 0) return 0;
  const std::span<const std::uint8_t> bytes(data + 1, size - 1);
  if (data[0] % 2 == 0) {
    board::check_replies(bytes);
    board::check_decoder(bytes);
    return 0;
  }
  fuzz::ByteReader reader(bytes);
  const auto driven = std::make_unique<board::Driven>();
  while (!reader.empty()) driven->act(reader);
  return 0;
}
