#include "firmware/board/protocol.hpp"

#include "firmware/board/byte_order.hpp"

namespace roadbalance::board {
namespace {

// Encodes into an array of exactly the structure's size.
template <class Structure, class Fill>
std::array<std::uint8_t, Structure::kBytes> filled(Fill fill) {
  std::array<std::uint8_t, Structure::kBytes> bytes{};
  ByteWriter writer(bytes);
  fill(writer);
  return bytes;
}

}  // namespace

std::array<std::uint8_t, Identity::kBytes> encode(const Identity& identity) {
  return filled<Identity>([&](ByteWriter& out) {
    out.put(identity.major);
    out.put(identity.minor);
    out.put(identity.firmware_version);
    for (const char c : identity.serial) out.put(c);
    out.put(identity.inputs);
    out.put(identity.loop_channels);
    out.put(identity.lines);
    out.put(identity.ranges);
    out.put(identity.capabilities);
    out.put(identity.tick_hz);
    out.put(identity.rate_min_hz);
    out.put(identity.rate_max_hz);
    out.put(identity.filter_min_hz);
    out.put(identity.filter_max_hz);
    out.put(identity.filter_orders);
    for (const std::uint32_t full_scale : identity.full_scale_uv) out.put(full_scale);
  });
}

std::optional<Identity> decode_identity(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < Identity::kBytes) return std::nullopt;
  ByteReader in(bytes);
  Identity identity;
  identity.major = in.take<std::uint16_t>();
  identity.minor = in.take<std::uint16_t>();
  identity.firmware_version = in.take<std::uint32_t>();
  for (char& c : identity.serial) c = in.take<char>();
  identity.inputs = in.take<std::uint8_t>();
  identity.loop_channels = in.take<std::uint8_t>();
  identity.lines = in.take<std::uint8_t>();
  identity.ranges = in.take<std::uint8_t>();
  identity.capabilities = in.take<std::uint32_t>();
  identity.tick_hz = in.take<std::uint32_t>();
  identity.rate_min_hz = in.take<std::uint32_t>();
  identity.rate_max_hz = in.take<std::uint32_t>();
  identity.filter_min_hz = in.take<std::uint32_t>();
  identity.filter_max_hz = in.take<std::uint32_t>();
  identity.filter_orders = in.take<std::uint32_t>();
  for (std::uint32_t& full_scale : identity.full_scale_uv) full_scale = in.take<std::uint32_t>();
  return identity;
}

std::array<std::uint8_t, Configuration::kBytes> encode(const Configuration& configuration) {
  return filled<Configuration>([&](ByteWriter& out) {
    out.put(configuration.ticks_per_scan);
    out.put(configuration.filter_corner_hz);
    out.put(configuration.packet_limit_us);
    out.put(configuration.filter_order);
    out.put(configuration.references_on);
    for (const std::uint8_t range : configuration.range) out.put(range);
    for (const EncoderSetup& encoder : configuration.encoder) {
      out.put(encoder.pulses_per_turn);
      out.put(encoder.flags);
    }
  });
}

std::optional<Configuration> decode_configuration(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != Configuration::kBytes) return std::nullopt;
  ByteReader in(bytes);
  Configuration configuration;
  configuration.ticks_per_scan = in.take<std::uint32_t>();
  configuration.filter_corner_hz = in.take<std::uint32_t>();
  configuration.packet_limit_us = in.take<std::uint16_t>();
  configuration.filter_order = in.take<std::uint8_t>();
  configuration.references_on = in.take<std::uint8_t>();
  for (std::uint8_t& range : configuration.range) range = in.take<std::uint8_t>();
  for (EncoderSetup& encoder : configuration.encoder) {
    encoder.pulses_per_turn = in.take<std::uint16_t>();
    encoder.flags = in.take<std::uint16_t>();
  }
  return configuration;
}

std::array<std::uint8_t, ReferenceSetup::kBytes> encode(const ReferenceSetup& setup) {
  return filled<ReferenceSetup>([&](ByteWriter& out) {
    for (const ReferenceWheel& wheel : setup.wheel) {
      out.put(wheel.on);
      out.put(wheel.line);
      out.put(wheel.amplitude_per_mille);
      out.put(wheel.corner_mhz);
      out.put(wheel.datum);
    }
  });
}

std::optional<ReferenceSetup> decode_reference_setup(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != ReferenceSetup::kBytes) return std::nullopt;
  ByteReader in(bytes);
  ReferenceSetup setup;
  for (ReferenceWheel& wheel : setup.wheel) {
    wheel.on = in.take<std::uint8_t>();
    wheel.line = in.take<std::uint8_t>();
    wheel.amplitude_per_mille = in.take<std::uint16_t>();
    wheel.corner_mhz = in.take<std::uint32_t>();
    wheel.datum = in.take<std::int32_t>();
  }
  return setup;
}

std::array<std::uint8_t, TestPattern::kBytes> encode(const TestPattern& pattern) {
  return filled<TestPattern>([&](ByteWriter& out) { out.put(static_cast<std::uint32_t>(pattern.pattern)); });
}

std::optional<TestPattern> decode_test_pattern(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != TestPattern::kBytes) return std::nullopt;
  const auto pattern = ByteReader(bytes).take<std::uint32_t>();
  if (pattern > static_cast<std::uint32_t>(Pattern::kCounter)) return std::nullopt;
  return TestPattern{static_cast<Pattern>(pattern)};
}

std::array<std::uint8_t, Arm::kBytes> encode(const Arm& arm) {
  return filled<Arm>([&](ByteWriter& out) {
    out.put(arm.token);
    out.put(static_cast<std::uint32_t>(arm.mode));
  });
}

std::optional<Arm> decode_arm(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != Arm::kBytes) return std::nullopt;
  ByteReader in(bytes);
  const auto token = in.take<std::uint32_t>();
  const auto mode = in.take<std::uint32_t>();
  if (mode > static_cast<std::uint32_t>(StartMode::kFollower)) return std::nullopt;
  return Arm{token, static_cast<StartMode>(mode)};
}

std::array<std::uint8_t, Start::kBytes> encode(const Start& start) {
  return filled<Start>([&](ByteWriter& out) { out.put(start.token); });
}

std::optional<Start> decode_start(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != Start::kBytes) return std::nullopt;
  return Start{ByteReader(bytes).take<std::uint32_t>()};
}

std::array<std::uint8_t, Status::kBytes> encode(const Status& status) {
  return filled<Status>([&](ByteWriter& out) {
    out.put(static_cast<std::uint8_t>(status.state));
    out.put(static_cast<std::uint8_t>(status.last_refusal));
    out.put(status.refused_request);
    out.put(status.configured);
    out.put(status.token);
    out.put(status.refusals);
    out.put(status.scans_lost);
    out.put(status.scans_missed);
    out.put(status.edges_lost);
    out.put(status.overloads);
    out.put(status.glitches);
    out.put(status.packets);
    out.put(status.scans);
    out.put(status.ticks);
  });
}

std::optional<Status> decode_status(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < Status::kBytes) return std::nullopt;
  ByteReader in(bytes);
  Status status;
  const auto state = in.take<std::uint8_t>();
  const auto refusal = in.take<std::uint8_t>();
  if (state > static_cast<std::uint8_t>(State::kLost)) return std::nullopt;
  if (refusal > static_cast<std::uint8_t>(Refusal::kHardware)) return std::nullopt;
  status.state = static_cast<State>(state);
  status.last_refusal = static_cast<Refusal>(refusal);
  status.refused_request = in.take<std::uint8_t>();
  status.configured = in.take<std::uint8_t>();
  status.token = in.take<std::uint32_t>();
  status.refusals = in.take<std::uint32_t>();
  status.scans_lost = in.take<std::uint32_t>();
  status.scans_missed = in.take<std::uint32_t>();
  status.edges_lost = in.take<std::uint32_t>();
  status.overloads = in.take<std::uint32_t>();
  status.glitches = in.take<std::uint32_t>();
  status.packets = in.take<std::uint32_t>();
  status.scans = in.take<std::uint64_t>();
  status.ticks = in.take<std::uint64_t>();
  return status;
}

}  // namespace roadbalance::board
