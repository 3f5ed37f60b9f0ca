#include "firmware/board/reference_generator.hpp"

namespace roadbalance::board {
namespace {

std::int16_t rounded(float code) {
  return static_cast<std::int16_t>(code < 0.0f ? code - 0.5f : code + 0.5f);
}

}  // namespace

void ReferenceGenerator::start(const ReferenceSetup& setup, const Configuration& configuration,
                               std::uint32_t tick_hz) {
  locked_.store(0, std::memory_order_relaxed);
  for (std::size_t k = 0; k < wheels_.size(); ++k) {
    const ReferenceWheel& wanted = setup.wheel[k];
    Wheel& wheel = wheels_[k];
    wheel.on = configuration.references_on != 0 && wanted.on != 0;
    if (!wheel.on) continue;
    wheel.line = wanted.line;
    wheel.amplitude = kFullScaleCode * static_cast<float>(wanted.amplitude_per_mille) / 1000.0f;
    wheel.datum = static_cast<Phase>(wanted.datum);
    const EncoderSetup& encoder = configuration.encoder[wanted.line];
    wheel.tracker.start({.pulses_per_turn = encoder.pulses_per_turn,
                         .tick_hz = tick_hz,
                         .corner_hz = static_cast<float>(wanted.corner_mhz) / 1000.0f,
                         .zero_mark = (encoder.flags & kZeroWired) != 0});
  }
}

void ReferenceGenerator::follow(const CapturedEdge& edge) {
  for (Wheel& wheel : wheels_) {
    if (!wheel.on || wheel.line != edge.line) continue;
    if (edge.kind == PacketEdgeKind::kZeroMark)
      wheel.tracker.zero_mark(edge.ticks);
    else
      wheel.tracker.tooth(edge.ticks, edge.kind == PacketEdgeKind::kToothForward);
  }
}

ReferenceGenerator::Codes ReferenceGenerator::codes(std::uint64_t ticks) {
  Codes codes{};
  std::uint32_t locked = 0;
  for (std::size_t k = 0; k < wheels_.size(); ++k) {
    const Wheel& wheel = wheels_[k];
    if (!wheel.on || !wheel.tracker.locked(ticks)) continue;
    locked |= 1u << k;
    const SineCosine value = sine_cosine(wheel.tracker.angle(ticks) + wheel.datum);
    codes[2 * k] = rounded(wheel.amplitude * value.sine);
    codes[2 * k + 1] = rounded(wheel.amplitude * value.cosine);
  }
  locked_.store(locked, std::memory_order_relaxed);
  return codes;
}

}  // namespace roadbalance::board
