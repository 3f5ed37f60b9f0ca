#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <complex>
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
#include "common/bus/control.hpp"
#include "common/bus/operation.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/bus/results.hpp"
#include "common/process/stop_on_signal.hpp"
#include "host/web/test/scene.hpp"

// rb-web-scene URL SCENE: says on the bus, 25 times a second, what a car in a state that is wanted would
// say, so that a test of the page knows what it must show.

namespace {

using namespace roadbalance;

const std::map<std::string_view, Scene> kScenes{{"known", {}},
                                                {"armed", {.armed = true}},
                                                {"unknown", {.known = false}},
                                                {"verified", {.verified = true}},
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
  balance.unbalance_g = scene.verified ? kAfter_g[w] : kGrams[w];
  balance.angle_rad = (scene.verified ? kAfterDegrees[w] : kDegrees[w]) * kDegree;
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
  switch (scene.verified && of.wheel == 0 ? 3 : of.wheel) {
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

void say(Bus& bus, const Scene& scene) {
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
  say_rest(bus, scene);
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
    say(bus, scene->second);
    std::this_thread::sleep_for(std::chrono::milliseconds(40));
  }
  return 0;
}
