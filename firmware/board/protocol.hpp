#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

/// The board's vendor-class USB protocol: see PROTOCOL.md.  Shared by the firmware, the host's backend and
/// the emulated device; needs neither heap, exceptions nor an operating system.
///
/// All numbers are little endian.  Each structure has one encoded form of fixed size, made by encode() and
/// read by decode_*().  Minor versions append fields at the end of a structure; they change nothing that is
/// there.
namespace roadbalance::board {

inline constexpr std::uint16_t kProtocolMajor = 1;
inline constexpr std::uint16_t kProtocolMinor = 0;

inline constexpr std::uint16_t kVendorId = 0x1209;  ///< pid.codes
inline constexpr std::uint16_t kProductId =
    0x0001;                                    ///< its id for testing; a product asks for one of its own
inline constexpr std::uint8_t kBulkIn = 0x81;  ///< the only endpoint besides EP0
inline constexpr std::size_t kUsbPacketBytes = 512;  ///< of a high-speed bulk endpoint

inline constexpr std::size_t kInputChannels = 12;  ///< accelerations
inline constexpr std::size_t kLoopChannels =
    4;  ///< references come back: sin, cos of wheel 0, then of wheel 1
inline constexpr std::size_t kStreamChannels = kInputChannels + kLoopChannels;
inline constexpr std::size_t kLines = 2;   ///< encoders
inline constexpr std::size_t kRanges = 4;  ///< input ranges to choose from
inline constexpr std::size_t kSerialBytes = 16;

/// bRequest of a vendor request to the device (bmRequestType 0xC0 in, 0x40 out); wValue and wIndex are 0.
enum class Request : std::uint8_t {
  kIdentify = 0x01,       ///< in: Identity; in any state
  kConfigure = 0x02,      ///< out: Configuration; while idle
  kReferences = 0x03,     ///< out: ReferenceSetup; while idle
  kTestPattern = 0x04,    ///< out: TestPattern; while idle
  kArm = 0x05,            ///< out: Arm; while idle and configured
  kStart = 0x06,          ///< out: Start; while armed, not as follower
  kStop = 0x07,           ///< out, no data; in any state
  kStatus = 0x08,         ///< in: Status; in any state
  kConfiguration = 0x09,  ///< in: the Configuration in force
};
inline constexpr std::uint8_t kVendorIn = 0xC0;
inline constexpr std::uint8_t kVendorOut = 0x40;

enum Capability : std::uint32_t {
  kHasReferences = 1u << 0,   ///< D/A references and their loop-back
  kHasQuadrature = 1u << 1,   ///< encoder lines decode direction
  kHasSync = 1u << 2,         ///< SYNC connector: master and follower
  kHasTestPattern = 1u << 3,  ///< kTestPattern
};

struct Identity {
  static constexpr std::size_t kBytes = 72;

  std::uint16_t major = kProtocolMajor;
  std::uint16_t minor = kProtocolMinor;
  std::uint32_t firmware_version = 0;       ///< major << 16 | minor << 8 | patch
  std::array<char, kSerialBytes> serial{};  ///< ASCII, filled up with zeros
  std::uint8_t inputs = kInputChannels;
  std::uint8_t loop_channels = kLoopChannels;
  std::uint8_t lines = kLines;
  std::uint8_t ranges = kRanges;
  std::uint32_t capabilities = 0;  ///< OR of Capability
  std::uint32_t tick_hz = 0;       ///< of the one timer that stamps scans and edges
  std::uint32_t rate_min_hz = 0;
  std::uint32_t rate_max_hz = 0;
  std::uint32_t filter_min_hz = 0;  ///< limits of the anti-aliasing filter's corner
  std::uint32_t filter_max_hz = 0;
  std::uint32_t filter_orders = 0;                     ///< bit n: order n can be had; bit 0: without filter
  std::array<std::uint32_t, kRanges> full_scale_uv{};  ///< input voltage of 2^23 counts in each range
};

enum EncoderFlag : std::uint16_t {
  kInvertA = 1u << 0,     ///< the active flank of A is the falling one
  kInvertB = 1u << 1,     ///< swaps forward and backward
  kInvertZero = 1u << 2,  ///< the zero mark is low
  kQuadrature = 1u << 3,  ///< B is wired: teeth have a direction
  kZeroWired = 1u << 4,   ///< the zero mark is wired
};
inline constexpr std::uint16_t kEncoderFlags = 0x1F;

struct EncoderSetup {
  std::uint16_t pulses_per_turn = 0;  ///< 0: the line is not used
  std::uint16_t flags = 0;            ///< OR of EncoderFlag
};

struct Configuration {
  static constexpr std::size_t kBytes = 32;

  std::uint32_t ticks_per_scan = 0;      ///< Identity::tick_hz / rate; whole, so that no instant is rounded
  std::uint32_t filter_corner_hz = 0;    ///< -3 dB; 0 without filter
  std::uint16_t packet_limit_us = 5000;  ///< a packet goes out at the latest so long after its first scan
  std::uint8_t filter_order = 0;         ///< Butterworth; 0: none
  std::uint8_t references_on = 0;        ///< 1: D/A and loop-back run; 0: channels 12 to 15 are 0
  std::array<std::uint8_t, kInputChannels> range{};  ///< of each input, 0 .. kRanges - 1
  std::array<EncoderSetup, kLines> encoder{};
};
inline constexpr std::uint16_t kPacketLimitMinUs = 500;
inline constexpr std::uint16_t kPacketLimitMaxUs = 50000;

/// The angle of one wheel, made of an encoder's teeth, as sine and cosine.
struct ReferenceWheel {
  std::uint8_t on = 0;
  std::uint8_t line = 0;                    ///< which encoder
  std::uint16_t amplitude_per_mille = 900;  ///< of the loop-back channels' full scale, 1 .. 1000
  std::uint32_t corner_mhz = 20000;         ///< double corner frequency of the tracking loop in mHz
  std::int32_t datum = 0;                   ///< added to the angle, 2^-32 turns
};
struct ReferenceSetup {
  static constexpr std::size_t kBytes = 24;
  std::array<ReferenceWheel, kLoopChannels / 2> wheel{};
};

enum class Pattern : std::uint32_t {
  kOff = 0,
  kCounter = 1,  ///< channel c of scan n is (16 n + c) mod 2^24 as a signed 24-bit number
};
struct TestPattern {
  static constexpr std::size_t kBytes = 4;
  Pattern pattern = Pattern::kOff;
};

enum class StartMode : std::uint8_t {
  kImmediate = 0,  ///< SYNC is neither driven nor looked at
  kMaster = 1,     ///< drives SYNC: one rising edge for each conversion, from the first
  kFollower = 2,   ///< converts with each rising edge of SYNC; the first after arming is scan 0
};
struct Arm {
  static constexpr std::size_t kBytes = 8;
  std::uint32_t token = 0;  ///< the host's choice; comes back in every packet of the run
  StartMode mode = StartMode::kImmediate;
};
struct Start {
  static constexpr std::size_t kBytes = 4;
  std::uint32_t token = 0;  ///< as armed
};

enum class State : std::uint8_t {
  kIdle = 0,
  kArmed = 1,
  kRunning = 2,
  kLost = 3,  ///< no conversion came for so long that the next one's index is unknown; kStop leads to idle
};

/// Why the last refused request was stalled.
enum class Refusal : std::uint8_t {
  kNone = 0,
  kUnknownRequest = 1,
  kWrongLength = 2,
  kWrongState = 3,  ///< e.g. to configure while running, to arm without a configuration
  kOutOfRange = 4,  ///< a field has a value that this board does not have
  kWrongToken = 5,
  kHardware = 6,  ///< the converter, filter or D/A did not take the set-up
};

struct Status {
  static constexpr std::size_t kBytes = 52;

  State state = State::kIdle;
  Refusal last_refusal = Refusal::kNone;
  std::uint8_t refused_request = 0;  ///< bRequest of that
  std::uint8_t configured = 0;
  std::uint32_t token = 0;
  std::uint32_t refusals = 0;      ///< since power-up; the following since the start of the run:
  std::uint32_t scans_lost = 0;    ///< ring overrun: converted, but never sent
  std::uint32_t scans_missed = 0;  ///< not converted, e.g. no edge of SYNC
  std::uint32_t edges_lost = 0;
  std::uint32_t overloads = 0;  ///< scans with at least one channel at its limit
  std::uint32_t glitches = 0;  ///< conversions within half a period of the one before: dropped (a noisy SYNC)
  std::uint32_t packets = 0;   ///< given to the USB
  std::uint64_t scans = 0;     ///< index behind the last scan sent
  std::uint64_t ticks = 0;     ///< the timer now
};

std::array<std::uint8_t, Identity::kBytes> encode(const Identity& identity);
std::array<std::uint8_t, Configuration::kBytes> encode(const Configuration& configuration);
std::array<std::uint8_t, ReferenceSetup::kBytes> encode(const ReferenceSetup& setup);
std::array<std::uint8_t, TestPattern::kBytes> encode(const TestPattern& pattern);
std::array<std::uint8_t, Arm::kBytes> encode(const Arm& arm);
std::array<std::uint8_t, Start::kBytes> encode(const Start& start);
std::array<std::uint8_t, Status::kBytes> encode(const Status& status);

/// A request of the host is read only at exactly its length, and with enumerations and reserved bytes as
/// defined.
std::optional<Configuration> decode_configuration(std::span<const std::uint8_t> bytes);
std::optional<ReferenceSetup> decode_reference_setup(std::span<const std::uint8_t> bytes);
std::optional<TestPattern> decode_test_pattern(std::span<const std::uint8_t> bytes);
std::optional<Arm> decode_arm(std::span<const std::uint8_t> bytes);
std::optional<Start> decode_start(std::span<const std::uint8_t> bytes);

/// The device's answers may be longer, of a newer minor version; the known part is read.  An Identity of
/// another major version is returned too, so that the host can name both.
std::optional<Identity> decode_identity(std::span<const std::uint8_t> bytes);
std::optional<Status> decode_status(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance::board
