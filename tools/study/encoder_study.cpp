#include "tools/study/encoder_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "firmware/encoder/wheel_encoder.hpp"
#include "firmware/pack.hpp"
#include "host/encoder/recorded_angle.hpp"

namespace roadbalance {
namespace {

constexpr int kInstants = 20;
constexpr double kStep_ns = 5e5;
constexpr double kBlock_s = kInstants * kStep_ns * 1e-9;

/// Compares block after block of angles with the truth.
class Comparison {
 public:
  explicit Comparison(const sim::PulseTrain& train) : train_(train) {}

  void add(double start_s, std::span<const double> angle_rad) {
    for (std::size_t i = 0; i < angle_rad.size(); ++i) {
      const double truth = train_.angle_rad(start_s + static_cast<double>(i) * kStep_ns * 1e-9);
      const double error =
          std::remainder(angle_rad[i] - truth, 2.0 * std::numbers::pi) * 180.0 / std::numbers::pi;
      square_ += error * error;
      largest_ = std::max(largest_, std::abs(error));
      ++count_;
    }
  }
  void put(AngleErrors& errors) const {
    errors.rms_deg = std::sqrt(square_ / static_cast<double>(std::max<std::int64_t>(1, count_)));
    errors.max_deg = largest_;
  }

 private:
  const sim::PulseTrain& train_;
  double square_ = 0.0, largest_ = 0.0;
  std::int64_t count_ = 0;
};

NodeTime at(double seconds) {
  return node_time_from_ns(std::llround(seconds * 1e9));
}

}  // namespace

AngleErrors live_errors(const EncoderRow& row, const std::vector<Edge>& edges) {
  WheelEncoder encoder({.pulses_per_turn = row.train.teeth});
  AngleErrors errors;
  Comparison comparison(row.train);
  auto edge = edges.begin();
  std::array<double, kInstants> angle;
  for (double start = 0.0; start + 0.2 < row.seconds; start += kBlock_s) {
    const NodeTime last = at(start + (kInstants - 1) * kStep_ns * 1e-9);
    for (; edge != edges.end() && edge->time < encoder.complete_at(last); ++edge)
      encoder.add(edge->time, edge->kind);
    if (start < row.from_s) continue;
    ++errors.blocks;
    errors.lag_ms =
        std::max(errors.lag_ms, static_cast<double>(to_ns(encoder.complete_at(last)) - to_ns(last)) * 1e-6);
    if (encoder.angles(at(start), kStep_ns, angle))
      comparison.add(start, angle);
    else
      ++errors.unknown;
  }
  comparison.put(errors);
  return errors;
}

AngleErrors offline_errors(const EncoderRow& row, const std::vector<Edge>& edges) {
  RecordedAngle recorded({.pulses_per_turn = row.train.teeth}, edges);
  AngleErrors errors;
  Comparison comparison(row.train);
  std::array<double, kInstants> angle;
  for (double start = 1.0; start + 1.0 < row.seconds; start += kBlock_s) {
    ++errors.blocks;
    if (recorded.angles(at(start), kStep_ns, angle))
      comparison.add(start, angle);
    else
      ++errors.unknown;
  }
  comparison.put(errors);
  return errors;
}

nlohmann::ordered_json encoder_row_result(const EncoderRow& row) {
  constexpr double kLongestWait_ms = Sealer::kLongestWait_ns * 1e-6;
  const std::vector<Edge> edges = row.train.edges(0.0, row.seconds);
  const AngleErrors live = live_errors(row, edges), offline = offline_errors(row, edges);
  const auto allowed = [&](const AngleErrors& errors) {
    return errors.blocks > 0 && errors.unknown == 0 && errors.rms_deg <= row.allowed_rms_deg &&
           errors.max_deg <= row.allowed_max_deg;
  };
  const nlohmann::ordered_json most =
      std::isfinite(row.allowed_max_deg) ? nlohmann::ordered_json(row.allowed_max_deg) : nullptr;
  return {{"case", row.name},
          {"rms_deg", live.rms_deg},
          {"max_deg", live.max_deg},
          {"offline_rms_deg", offline.rms_deg},
          {"offline_max_deg", offline.max_deg},
          {"allowed_rms_deg", row.allowed_rms_deg},
          {"allowed_max_deg", most},
          {"unknown_blocks", live.unknown + offline.unknown},
          {"lag_ms", live.lag_ms},
          {"met", allowed(live) && allowed(offline) && live.lag_ms < kLongestWait_ms}};
}

}  // namespace roadbalance
