#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <complex>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/compensation.hpp"
#include "common/bus/control_messages.hpp"
#include "common/bus/operation.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/bus/recording.hpp"
#include "common/bus/remark.hpp"
#include "common/bus/results.hpp"
#include "common/bus/setup.hpp"
#include "common/bus/tap.hpp"
#include "common/bus/weight_check.hpp"
#include "common/process/stop_on_signal.hpp"

// rb-web-scene URL SCENE: publishes on the bus, 25 times a second, the messages of a car in the wanted state,
// so that a test of the page knows what it must show.

namespace {

using namespace roadbalance;

constexpr std::int64_t kIncarnation = 1'763'741'000'000;
constexpr double kDegree = std::numbers::pi / 180.0;

struct Scene {
  bool known = true;     ///< the unbalances
  bool armed = false;    ///< a recording has ended, with a receipt; the next may begin
  bool checked = false;  ///< a drive before weights were fitted is known
  bool analysed = true;  ///< an analyser is there: levels and results
  bool trouble = false;  ///< disk full, samples lost, clock held over, overload, dead channel, faulty turns
  bool disk_is_away = false;
  bool device_is_gone = false;  ///< of node 2
};
/// Unbalance that is left of 35 g at 217 degrees with weights at 37: nearly none; with weights at -37, 2 |sin
/// 37| times as much; at 217 twice as much; or not fitted.
constexpr std::array kAfter_g{2.0, 42.1, 70.0, 35.0}, kAfterDegrees{80.0, 270.0, 217.0, 217.0};

const std::map<std::string_view, Scene> kScenes{{"known", {}},
                                                {"armed", {.armed = true}},
                                                {"unknown", {.known = false}},
                                                {"checked", {.checked = true}},
                                                {"unanalysed", {.analysed = false}},
                                                {"trouble", {.trouble = true}},
                                                {"disk away", {.disk_is_away = true}},
                                                {"device gone", {.device_is_gone = true}}};

RecorderStatus recorder(const Scene& scene) {
  RecorderStatus status;
  status.time_us = 1000 * kIncarnation;
  status.recorder = 7;
  status.incarnation = kIncarnation;
  status.recording_s = 5'025;  // 1:23:45
  status.name = "Autobahn";
  status.nodes = 2;
  status.operable = true;
  status.state = scene.trouble ? RecorderState::kDiskFull : RecorderState::kRecording;
  status.bytes_recorded = 4'560'000'000;
  status.bytes_free = scene.trouble ? 0 : 400'000'000'000;
  status.seconds_left = scene.trouble ? 0.0 : 5.5 * 3600;
  if (scene.disk_is_away) {
    status.state = RecorderState::kDiskFailing;
    status.disk_failures = 17;
    status.fault =
        "recording /media/laptop/measurements/Autobahn (mount the disk that it is on; or stop, and start "
        "another recording): No such device";
  }
  if (scene.armed) {
    status.incarnation = 0;
    status.recording_s = 0;
    status.name = "";
    status.state = RecorderState::kArmed;
    status.bytes_free = 87'600'000'000;
  }
  return status;
}

Receipt receipt(int node) {
  return {.incarnation = kIncarnation,
          .began_us = 1000 * kIncarnation,
          .ended_us = 1000 * kIncarnation + 5'025'000'000,
          .index = node - 1,
          .nodes = 2,
          .node = node,
          .epochs = 1,
          .samples_sent = 10'050'000,
          .samples_recorded = 10'050'000,
          .repaired = 3 * node,
          .overload_s = 0.2 * node,
          .sync_us = 12.0,
          .blocks_crc32c = 0x1234'abcd,
          .sums_agree = true,
          .bytes = 1'520'000'000,
          .marks = 4,
          .name = "Autobahn"};
}

Heartbeat heartbeat(const Scene& scene, int node) {
  Heartbeat beat;
  beat.node = node;
  beat.epoch = 7;
  beat.state = scene.armed ? NodeState::kPreview : NodeState::kStarted;
  beat.owner = scene.armed ? 0 : kIncarnation;
  beat.scans_sampled = 1'000'000;
  beat.blocks_repaired = 3;
  beat.scans_missing = scene.trouble ? 40 : 0;
  beat.encoder_faults = {0, scene.trouble ? 2 : 0};
  if (scene.device_is_gone && node == 2)
    beat.device_counts[static_cast<std::size_t>(DeviceCounter::kGone)] = 1;
  return beat;
}

ClockFit clock_fit(const Scene& scene, int node) {
  ClockFit fit;
  fit.node = node;
  fit.epoch = 7;
  fit.number = 1;
  fit.state = scene.trouble ? ClockState::kHoldover : ClockState::kLocked;
  fit.uncertainty_s = scene.trouble ? 120e-6 : 12e-6;
  return fit;
}

Level level(const Scene& scene, int node) {
  Level level;
  level.node = node;
  level.seconds = 0.1;
  level.speed_m_s = 31.0;
  for (std::size_t c = 0; c < kChannels; ++c) {
    level.rms[c] = 0.2 * static_cast<double>(c + 1);
    level.peak[c] = 4 * level.rms[c];
  }
  if (scene.trouble) {
    level.overload = 1U << 2;
    level.clipped = 1U << 7;
    level.dead = 1U << 4 | 1U << (kChannels + 6);
    level.rms[4] = level.peak[4] = 0;
  }
  return level;
}

/// 35 g at 217 degrees on both front wheels, whose weights then go to 37.
Balance balance(const Scene& scene, std::int32_t wheel) {
  constexpr std::array kGrams{35.0, 35.0, 12.0, 1.2};
  constexpr std::array kDegrees{217.0, 217.0, 305.0, 128.0};
  const auto w = static_cast<std::size_t>(wheel);
  Balance balance;
  balance.wheel = wheel;
  balance.time_ns = 1;
  if (!scene.known) {
    constexpr std::array kWhy{Unknown::kTooShort, Unknown::kInStep, Unknown::kNoReference, Unknown::kTooSlow};
    balance.state = kWhy[w];
    return balance;
  }
  balance.state = Unknown::kNone;
  balance.unbalance_g = scene.checked ? kAfter_g[w] : kGrams[w];
  balance.angle_rad = (scene.checked ? kAfterDegrees[w] : kDegrees[w]) * kDegree;
  // Wheels 2 and 4 are done: better than the wanted 2 g.
  const double scale = w % 2 == 0 ? 1.0 : 0.36;
  balance.covariance_g2 << 9.0 * scale, 2.0 * scale, 2.0 * scale, 4.0 * scale;
  balance.sigma_g = 2.5 * std::sqrt(scale);
  balance.sigma_rad = std::min(std::numbers::pi, balance.sigma_g / balance.unbalance_g);
  balance.weight_radius_m = 0.19;
  balance.weight_angle_rad = std::fmod(kDegrees[w] + 180.0, 360.0) * kDegree;
  balance.seconds_used = 280.0;
  balance.least_speed_m_s = 25.0;
  balance.greatest_speed_m_s = 36.0;
  return balance;
}

Compensation compensation(const Scene& scene, const Balance& of) {
  Compensation plan;
  plan.wheel = of.wheel;
  plan.time_ns = of.time_ns;
  if (of.state != Unknown::kNone) return plan;
  plan.verdict = {.residual_g = 2.6,
                  .shop_g = 7.0,
                  .permissible_g = 30.0,
                  .permissible_grade_mm_s = 40.0,
                  .grade_mm_s = 3.4,
                  .by_rotor = true,
                  .force_left_share = 0.1};
  plan.wanted_sigma_g = 2.0;
  constexpr std::array kSecondsWanted{42.0, 0.0, std::numeric_limits<double>::infinity(), 0.0};
  plan.seconds_wanted = kSecondsWanted[static_cast<std::size_t>(of.wheel)];
  plan.seat_now_m_s2 = 0.052;
  plan.seat_left_m_s2 = 0.0043;
  constexpr WeightPlace kOuter{0.19, WeightKind::kClip, RimPlane::kOuter};
  constexpr WeightPlace kInner{0.19, WeightKind::kClip, RimPlane::kInner};
  constexpr WeightPlace kStuck{0.19, WeightKind::kAdhesive, RimPlane::kInner};
  switch (scene.checked && of.wheel == 0 ? 3 : of.wheel) {
    case 0:
    case 1:
      plan.advice = Advice::kSteps;
      plan.plan.step.push_back(
          {WeightAction::kAdd, {35.0, of.weight_angle_rad, of.wheel == 0 ? kOuter : kStuck}, {}});
      break;
    case 2:
      plan.advice = Advice::kSteps;
      plan.plan.step.push_back(
          {WeightAction::kMove, {20.0, 90 * kDegree, kInner}, {20.0, 30 * kDegree, kOuter}});
      plan.plan.step.push_back({WeightAction::kRemove, {5.0, 200 * kDegree, kOuter}, {}});
      plan.verdict.incurable =
          "force that does not grow with speed dominates: match-mount or replace the tyre";
      break;
    default:
      plan.advice = Advice::kLeaveUncertain;
  }
  return plan;
}

Identification identification(const Scene& scene) {
  Identification known;
  known.seconds_used = scene.known ? 280.0 : 18.0;
  known.seconds_needed = 60.0;
  known.least_speed_m_s = 32.0;
  known.state = scene.known ? Unknown::kNone : Unknown::kTooShort;
  return known;
}

/// 217 degrees and 35 g before; 2 g, the mirrored place, the heavy spot itself, no effect.
WeightCheck weight_check(std::int32_t wheel) {
  constexpr std::array kPlacements{WeightPlacement::kAsWanted, WeightPlacement::kMirrored,
                                   WeightPlacement::kOpposite, WeightPlacement::kNoEffect};
  constexpr std::array kVerdicts{WeightCheckVerdict::kGood, WeightCheckVerdict::kMore,
                                 WeightCheckVerdict::kMore, WeightCheckVerdict::kUnchanged};
  const auto w = static_cast<std::size_t>(wheel);
  WeightCheck v{.wheel = wheel,
                .time_ns = 1,
                .state = WeightCheckState::kKnown,
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
    // The last pair: the right one is mounted upside down, and described so.
    channel.direction = {0.0F, 0.0F, c == 11 ? -1.0F : 1.0F};
    channel.range_m_s2 = c < 2 ? 200.0F : 50.0F;
    channel.scale_m_s2_per_count = channel.range_m_s2 / 8388608.0F;
  }
  for (std::size_t line = 0; line < 2; ++line)
    setup.encoder[line] = {static_cast<std::int32_t>(2 * (node - 1)) + static_cast<std::int32_t>(line), 48,
                           static_cast<std::int32_t>(EncoderTrait::kZeroMark), 0.5, 0.002};
  return setup;
}

/// Upwards on the channel that is mounted upside down, whose wires are right; repeated.
Tap tap(const Scene& scene, std::int64_t number) {
  Tap tap{.node = 2, .time_ns = 1, .number = number, .channel = scene.trouble ? 1 : 11};
  tap.first_m_s2.fill(0.02);
  tap.peak_m_s2.fill(0.03);
  tap.first_m_s2[static_cast<std::size_t>(tap.channel)] = -4.0;
  tap.peak_m_s2[static_cast<std::size_t>(tap.channel)] = 5.0;
  return tap;
}

RecordingSummary recording(const Scene& scene, std::int32_t number) {
  constexpr std::int64_t kHour_us = 3'600'000'000;
  RecordingSummary summary{
      .number = number, .recordings = 3, .name = "2026-11-22-drive-" + std::to_string(number)};
  summary.vehicle = "demonstration car";
  summary.first_us = 1000 * kIncarnation - number * kHour_us;
  summary.last_us = summary.first_us + kHour_us / 2;
  summary.bytes = 1'230'000'000;
  constexpr std::array kStates{RecordingState::kGrowing, RecordingState::kComplete,
                               RecordingState::kIncomplete};
  summary.state = kStates[static_cast<std::size_t>(number)];
  if (number == 0 && scene.armed) summary.state = RecordingState::kNotRead;
  if (number == 2 && scene.trouble) summary.state = RecordingState::kDamaged;
  summary.refused = summary.state == RecordingState::kDamaged ? 2 : 0;
  summary.verdict = number == 0 ? "" : number == 1 ? "complete" : "incomplete, every gap declared";
  if (number > 0)
    for (std::int32_t node = 1; node <= 2; ++node)
      summary.node.push_back({node, 3'600'000, number == 2 ? 40 : 0, 3, 1800.0, 0.2 * (node - 1), 12e-6});
  if (number > 0) summary.rate_hz = 2000, summary.cutoff_hz = 200, summary.most_reduction = 4;
  summary.mark = {{summary.first_us + 60'000'000, "weights fitted", 1}};
  summary.marks = 1;
  if (number == 2) {  // more than a message holds
    summary.marks = 9;
    for (std::int32_t mark = 2; mark <= summary.marks; ++mark)
      summary.mark.push_back({summary.first_us + mark * 60'000'000, "", mark});
  }
  return summary;
}

/// Setups, the last tap, recordings, remarks and the effect of weights.
void publish_knowledge(Bus& bus, const Scene& scene) {
  static std::int64_t taps = 0;
  for (int node = 1; node <= 2; ++node) bus.publish(setup_channel(node), encode(setup(node)));
  bus.publish(kTapChannel, encode(tap(scene, ++taps)));
  for (std::int32_t number = 0; number < 3; ++number)
    bus.publish(kRecordingChannel, encode(recording(scene, number)));
  const std::vector<std::string> sentences{
      "the scale of grams and N/m rests on the wheels' masses and the sensors' gains in vehicle.toml",
      "static unbalance only: couple unbalance leaves no trace in vertical sensors"};
  for (const Remark& remark : remarks_of(0, scene.known ? sentences : std::vector<std::string>()))
    bus.publish(kRemarkChannel, encode(remark));
  if (scene.checked)
    for (std::int32_t wheel = 0; wheel < kWheels; ++wheel)
      bus.publish(kWeightCheckChannel, encode(weight_check(wheel)));
}

void publish_all(Bus& bus, const Scene& scene) {
  bus.publish(kRecorderChannel, encode(recorder(scene)));
  for (int node = 1; node <= 2; ++node) {
    bus.publish(heartbeat_channel(node), encode(heartbeat(scene, node)));
    if (scene.armed) bus.publish(kReceiptChannel, encode(receipt(node)));
    bus.publish(clock_fit_channel(node), encode(clock_fit(scene, node)));
    if (scene.analysed) bus.publish(kLevelChannel, encode(level(scene, node)));
  }
  if (!scene.analysed) return;
  bus.publish(kIdentificationChannel, encode(identification(scene)));
  for (std::int32_t wheel = 0; wheel < kWheels; ++wheel) {
    const Balance of = balance(scene, wheel);
    bus.publish(kBalanceChannel, encode(of));
    bus.publish(kCompensationChannel, encode(compensation(scene, of)));
  }
  publish_knowledge(bus, scene);
}

}  // namespace

int main(int argc, char** argv) {
  const StopOnSignal signals;
  const auto scene = argc == 3 ? kScenes.find(argv[2]) : kScenes.end();
  if (scene == kScenes.end()) {
    std::string names;
    for (const auto& [name, of] : kScenes) names += " \"" + std::string(name) + '"';
    std::fprintf(stderr, "usage: rb-web-scene URL SCENE, one of%s\n", names.c_str());
    return 2;
  }
  Bus bus(argv[1]);
  while (!signals.token().stop_requested()) {
    publish_all(bus, scene->second);
    std::this_thread::sleep_for(std::chrono::milliseconds(40));
  }
  return 0;
}
