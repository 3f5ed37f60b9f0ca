#include "tools/study/encoder_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/angle/wheel_encoder.hpp"
#include "firmware/block_packer.hpp"
#include "host/analysis/angle/recorded_angle.hpp"

namespace roadbalance {
namespace {

constexpr int kInstants = 20;
constexpr double kStep_ns = 5e5;
constexpr double kBlock_s = kInstants * kStep_ns * 1e-9;

double degrees(double rad) {
  return rad * 180.0 / std::numbers::pi;
}

/// Errors of the stamps of the zero marks themselves.
class MarkStamps {
 public:
  MarkStamps(const sim::PulseTrain& train, const std::vector<Edge>& edges) {
    for (const Edge& edge : edges) {
      if (edge.kind != EdgeKind::kZeroMark) continue;
      const double time_s = static_cast<double>(to_ns(edge.time)) * 1e-9;
      const double late_deg = degrees(std::remainder(train.angle_rad(time_s), 2.0 * std::numbers::pi));
      time_s_.push_back(time_s);
      sum_deg_.push_back(late_deg + (sum_deg_.empty() ? 0.0 : sum_deg_.back()));
    }
  }
  /// How late they are in the mean of all up to an instant: an angle from them is too small by that.
  double late_deg(double until_s) const {
    const auto marks = std::ranges::upper_bound(time_s_, until_s) - time_s_.begin();
    return marks == 0 ? 0.0 : sum_deg_[static_cast<std::size_t>(marks - 1)] / static_cast<double>(marks);
  }

 private:
  std::vector<double> time_s_, sum_deg_;
};

/// Compares block after block of angles with the truth.
class AngleComparison {
 public:
  explicit AngleComparison(const sim::PulseTrain& train) : train_(train) {}

  /// @param marks_late_deg  in the mean of those that the angles are from
  void add(double start_s, std::span<const double> angle_rad, double marks_late_deg) {
    for (std::size_t i = 0; i < angle_rad.size(); ++i) {
      const double truth = train_.angle_rad(start_s + static_cast<double>(i) * kStep_ns * 1e-9);
      const double error = degrees(std::remainder(angle_rad[i] - truth, 2.0 * std::numbers::pi));
      all_.add(error);
      but_for_marks_.add(error + marks_late_deg);
    }
  }
  void put(AngleErrors& errors) const {
    errors.all = all_.result();
    errors.but_for_marks = but_for_marks_.result();
  }

 private:
  struct Sum {
    double square = 0.0, largest = 0.0;
    std::int64_t count = 0;

    void add(double error) {
      square += error * error;
      largest = std::max(largest, std::abs(error));
      ++count;
    }
    AngleErrors::Size result() const {
      return {std::sqrt(square / static_cast<double>(std::max<std::int64_t>(1, count))), largest};
    }
  };
  const sim::PulseTrain& train_;
  Sum all_, but_for_marks_;
};

NodeTime at(double seconds) {
  return node_time_from_ns(std::llround(seconds * 1e9));
}

}  // namespace

AngleErrors live_errors(const EncoderRow& row, const std::vector<Edge>& edges) {
  WheelEncoder encoder({.pulses_per_turn = row.train.teeth});
  AngleErrors errors;
  AngleComparison comparison(row.train);
  const MarkStamps marks(row.train, edges);
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
      comparison.add(start, angle, marks.late_deg(start));
    else
      ++errors.unknown;
  }
  comparison.put(errors);
  return errors;
}

AngleErrors offline_errors(const EncoderRow& row, const std::vector<Edge>& edges) {
  RecordedAngle recorded({.pulses_per_turn = row.train.teeth}, edges);
  AngleErrors errors;
  AngleComparison comparison(row.train);
  const MarkStamps marks(row.train, edges);
  std::array<double, kInstants> angle;
  for (double start = 1.0; start + 1.0 < row.seconds; start += kBlock_s) {
    ++errors.blocks;
    if (recorded.angles(at(start), kStep_ns, angle))
      comparison.add(start, angle, marks.late_deg(row.seconds));
    else
      ++errors.unknown;
  }
  comparison.put(errors);
  return errors;
}

namespace {

/// Errors of many runs: the mean square of all, and the largest.
struct Pool {
  double square = 0.0;
  AngleErrors::Size all;
  double worst_rms_deg = 0.0;
  int unknown = 0;
  double lag_ms = 0.0;

  void add(const AngleErrors& errors, int runs) {
    square += errors.all.rms_deg * errors.all.rms_deg / runs;
    all = {std::sqrt(square), std::max(all.max_deg, errors.all.max_deg)};
    worst_rms_deg = std::max(worst_rms_deg, errors.all.rms_deg);
    unknown += errors.unknown;
    lag_ms = std::max(lag_ms, errors.lag_ms);
  }
};

bool is_allowed(const EncoderRow& row, const AngleErrors& errors, const AngleErrors::Size& size) {
  constexpr double kLongestWait_ms = BlockPacker::kLongestWait_ns * 1e-6;
  return errors.blocks > 0 && errors.unknown == 0 && errors.lag_ms < kLongestWait_ms &&
         size.rms_deg <= row.allowed_rms_deg && size.max_deg <= row.allowed_max_deg;
}

}  // namespace

nlohmann::ordered_json encoder_row_result(EncoderRow row, int runs) {
  Pool live_pool, offline_pool;
  int met = 0, met_but_for_marks = 0;
  for (int run = 0; run < runs; ++run, ++row.train.seed) {
    const std::vector<Edge> edges = row.train.edges(0.0, row.seconds);
    const AngleErrors live = live_errors(row, edges), offline = offline_errors(row, edges);
    live_pool.add(live, runs);
    offline_pool.add(offline, runs);
    if (is_allowed(row, live, live.all) && is_allowed(row, offline, offline.all)) ++met;
    if (is_allowed(row, live, live.but_for_marks) && is_allowed(row, offline, offline.but_for_marks))
      ++met_but_for_marks;
  }
  const nlohmann::ordered_json most =
      std::isfinite(row.allowed_max_deg) ? nlohmann::ordered_json(row.allowed_max_deg) : nullptr;
  return {{"case", row.name},
          {"rms_deg", live_pool.all.rms_deg},
          {"max_deg", live_pool.all.max_deg},
          {"offline_rms_deg", offline_pool.all.rms_deg},
          {"offline_max_deg", offline_pool.all.max_deg},
          {"allowed_rms_deg", row.allowed_rms_deg},
          {"allowed_max_deg", most},
          {"unknown_blocks", live_pool.unknown + offline_pool.unknown},
          {"lag_ms", live_pool.lag_ms},
          {"runs", runs},
          {"runs_met", met},
          {"runs_met_but_for_marks", met_but_for_marks},
          {"worst_run_rms_deg", std::max(live_pool.worst_rms_deg, offline_pool.worst_rms_deg)},
          {"met", met == runs}};
}

}  // namespace roadbalance
