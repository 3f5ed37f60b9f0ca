#include "host/web/test/scene.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "common/bus/knock.hpp"
#include "common/bus/recording.hpp"
#include "common/bus/remark.hpp"
#include "common/bus/setup.hpp"
#include "common/bus/verification.hpp"

namespace roadbalance {
namespace {

/// 217 degrees and 35 g before; 2 g, the mirrored place, the heavy spot itself, no effect.
WheelVerification verification(std::int32_t wheel) {
  constexpr std::array kPlacements{WeightPlacement::kAsWanted, WeightPlacement::kMirrored,
                                   WeightPlacement::kOpposite, WeightPlacement::kNoEffect};
  constexpr std::array kVerdicts{VerificationVerdict::kGood, VerificationVerdict::kMore,
                                 VerificationVerdict::kMore, VerificationVerdict::kUnchanged};
  const auto w = static_cast<std::size_t>(wheel);
  WheelVerification v{.wheel = wheel,
                      .time_ns = 1,
                      .state = VerificationState::kKnown,
                      .verdict = kVerdicts[w],
                      .placement = kPlacements[w],
                      .weight_radius_m = 0.19,
                      .reduction = 1.0 - kAfter_g[w] / 35.0,
                      .sigma_reduction = 0.04,
                      .text = "2026-11-22-first"};
  v.before_g << 35.0 * std::cos(217 * kDegree), 35.0 * std::sin(217 * kDegree);
  v.after_g << kAfter_g[w] * std::cos(kAfterDegrees[w] * kDegree),
      kAfter_g[w] * std::sin(kAfterDegrees[w] * kDegree);
  return v;
}

NodeSetup setup(int node) {
  NodeSetup setup{.node = node,
                  .name = node == 1 ? "front" : "rear",
                  .vehicle = "demonstration car",
                  .vehicle_crc32c = 1234,
                  .rate_hz = 2000.0,
                  .filter_order = 6,
                  .filter_cutoff_hz = 200.0,
                  .channel = {},
                  .encoder = {}};
  for (std::size_t c = 0; c < 12; ++c) {
    const bool left = c % 2 == 0;
    const float side = left ? 1.0F : -1.0F;
    NodeSetup::Channel& channel = setup.channel.emplace_back();
    channel.name = std::string(left ? "left" : "right") + "_" + std::to_string(c / 2 + 1);
    channel.mount = c < 2 ? 2 * (node - 1) + (left ? 0 : 1) : -1;
    channel.position_m = {(node == 1 ? 1.2F : -1.3F) + 0.1F * static_cast<float>(c / 2), 0.7F * side, 0.1F};
    // The last pair: the right one is mounted upside down, and so it says.
    channel.direction = {0.0F, 0.0F, c == 11 ? -1.0F : 1.0F};
    channel.range_m_s2 = c < 2 ? 200.0F : 50.0F;
    channel.scale_m_s2_per_count = channel.range_m_s2 / 8388608.0F;
  }
  for (std::size_t line = 0; line < 2; ++line)
    setup.encoder[line] = {static_cast<std::int32_t>(2 * (node - 1)) + static_cast<std::int32_t>(line), 48,
                           static_cast<std::int32_t>(EncoderTrait::kZeroMark), 0.5, 0.002};
  return setup;
}

/// Upwards on the channel that is mounted upside down, whose wires are right, again and again.
Knock knock(const Scene& scene, std::int64_t number) {
  Knock knock{.node = 2, .time_ns = 1, .number = number, .channel = scene.trouble ? 1 : 11};
  knock.first_m_s2.fill(0.02);
  knock.peak_m_s2.fill(0.03);
  knock.first_m_s2[static_cast<std::size_t>(knock.channel)] = -4.0;
  knock.peak_m_s2[static_cast<std::size_t>(knock.channel)] = 5.0;
  return knock;
}

RecordingReceipt recording(const Scene& scene, std::int32_t number) {
  constexpr std::int64_t kHour_us = 3'600'000'000;
  RecordingReceipt receipt{
      .number = number, .recordings = 3, .name = "2026-11-22-drive-" + std::to_string(number)};
  receipt.vehicle = "demonstration car";
  receipt.first_us = 1000 * kIncarnation - number * kHour_us;
  receipt.last_us = receipt.first_us + kHour_us / 2;
  receipt.bytes = 1'230'000'000;
  constexpr std::array kStates{RecordingState::kGrowing, RecordingState::kComplete,
                               RecordingState::kIncomplete};
  receipt.state = kStates[static_cast<std::size_t>(number)];
  if (number == 0 && scene.armed) receipt.state = RecordingState::kNotRead;
  if (number == 2 && scene.trouble) receipt.state = RecordingState::kDamaged;
  receipt.refused = receipt.state == RecordingState::kDamaged ? 2 : 0;
  receipt.verdict = number == 0 ? "" : number == 1 ? "complete" : "incomplete, every gap declared";
  if (number > 0)
    for (std::int32_t node = 1; node <= 2; ++node)
      receipt.node.push_back({node, 3'600'000, number == 2 ? 40 : 0, 3, 1800.0, 0.2 * (node - 1), 12e-6});
  if (number > 0) receipt.rate_hz = 2000, receipt.cutoff_hz = 200, receipt.most_reduction = 4;
  receipt.mark = {{receipt.first_us + 60'000'000, "weights fitted", 1}};
  receipt.marks = 1;
  if (number == 2) {  // more than a message tells
    receipt.marks = 9;
    for (std::int32_t mark = 2; mark <= receipt.marks; ++mark)
      receipt.mark.push_back({receipt.first_us + mark * 60'000'000, "", mark});
  }
  return receipt;
}

}  // namespace

void say_rest(Bus& bus, const Scene& scene) {
  static std::int64_t knocks = 0;
  for (int node = 1; node <= 2; ++node) bus.publish(setup_channel(node), encode(setup(node)));
  bus.publish(kKnockChannel, encode(knock(scene, ++knocks)));
  for (std::int32_t number = 0; number < 3; ++number)
    bus.publish(kRecordingChannel, encode(recording(scene, number)));
  const std::vector<std::string> sentences{
      "the scale of grams and N/m rests on the wheels' masses and the sensors' gains in vehicle.toml",
      "static unbalance only: couple unbalance leaves no trace in vertical sensors"};
  for (const Remark& remark : remarks_of(0, scene.known ? sentences : std::vector<std::string>()))
    bus.publish(kRemarkChannel, encode(remark));
  if (scene.verified)
    for (std::int32_t wheel = 0; wheel < kWheels; ++wheel)
      bus.publish(kVerificationChannel, encode(verification(wheel)));
}

}  // namespace roadbalance
