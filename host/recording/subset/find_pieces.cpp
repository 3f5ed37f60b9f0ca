#include "host/recording/subset/find_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/config/section.hpp"
#include "common/record/record_reader.hpp"
#include "host/recording/in_sequence.hpp"
#include "host/recording/levels.hpp"
#include "host/recording/subset/epoch_clocks.hpp"

namespace roadbalance {
namespace {

/// Limit of instants of a recording.
constexpr double kMostSeconds = 1e9;

std::int64_t mark_ns(std::int64_t number, const std::string& option, const ExportTable& table) {
  std::string all;
  for (const ExportMark& mark : table.mark) {
    if (mark.number == number) return table.start_ns + mark.time_ns;
    all += " " + std::to_string(mark.number);
  }
  throw ConfigError(option + ": " + std::to_string(number) + ": no such mark; " +
                    (all.empty() ? "the recording has none" : "allowed:" + all));
}

std::int64_t instant(std::int64_t zero_ns, double seconds, const std::string& option) {
  if (!(std::abs(seconds) <= kMostSeconds)) throw ConfigError(option + ": no time of a recording");
  return zero_ns + std::llround(seconds * 1e9);
}

Piece span_of(const TimeChoice& time, const ExportTable& table) {
  Piece span{std::numeric_limits<std::int64_t>::min(), Piece::kEver};
  const std::int64_t from_zero =
      time.from_mark ? mark_ns(*time.from_mark, "--from-mark", table) : table.start_ns;
  const std::int64_t to_zero = time.to_mark ? mark_ns(*time.to_mark, "--to-mark", table) : table.start_ns;
  if (time.from_s || time.from_mark) span.from_ns = instant(from_zero, time.from_s.value_or(0.0), "--from");
  if (time.to_s || time.to_mark) span.to_ns = instant(to_zero, time.to_s.value_or(0.0), "--to");
  if (span.to_ns <= span.from_ns) throw ConfigError("--to: not after --from; allowed: a later time");
  return span;
}

/// Stretches of time by what the samples of a recording show.
struct JudgedTime {
  Pieces at_speed;  ///< the car's speed is within the limits
  Pieces covered;   ///< all chosen nodes have begun and not ended
  Pieces unclean;   ///< of a chosen node samples are missing, a chosen channel left its range or an angle is
                    ///< not known
};

/// Speeds are means over this time: long enough to measure a wheel's turning, short against changes of speed.
constexpr double kInterval_s = 0.1;

/// The first node that reads a wheel; nullptr: none does.
const NodeConfig* pace_of(const VehicleConfig& vehicle) {
  for (const NodeConfig& node : vehicle.node)
    for (int line = 0; line < kEncoderLines; ++line)
      if (vehicle.wheel_at(node, line)) return &node;
  return nullptr;
}

class Judge {
 public:
  Judge(const SubsetRequest& request, const RecordingSurvey& survey)
      : request_(request), vehicle_(survey.vehicle), pace_(pace_of(vehicle_)), clocks_(survey) {
    if (!pace_ && (request.time.least_m_s || request.time.most_m_s))
      throw ConfigError("--speed: no node reads a wheel's encoder; allowed: a recording that tells speeds");
  }

  void take(const LogEvent& event) {
    clocks_.take(event);
    if (!event.channel.starts_with(kBlockChannels) || accept(event, *block_) != Refusal::kNone) return;
    in_sequence_.add(*block_, [&](const SealedBlock& block) { take(block); });
  }

  JudgedTime result() && {
    judged_.at_speed = merged(std::move(judged_.at_speed));
    judged_.unclean = merged(std::move(judged_.unclean));
    return std::move(judged_);
  }

 private:
  struct Epoch {
    std::unique_ptr<LevelMeter> meter;
    Piece interval;          ///< in the meter
    double metered_s = 0.0;  ///< of it
    std::int64_t next_scan = 0;
    std::int64_t end_ns = 0;  ///< behind the last scan
  };

  void take(const SealedBlock& block) {
    if (block.kind != BlockKind::kScan) return;
    const NodeEpoch key{block.header.node, block.header.epoch};
    const NodeConfig* node = vehicle_.node_with_id(key.first);
    const EpochClock* clock = clocks_.of(key);
    if (!node || !clock || chosen_channels(request_.choice, *node) == 0) return;
    const ScanBlock scans = decode_scan(block);
    const auto from_ns = clock->time_ns(scans.header.time_ns);
    const auto to_ns = clock->time_ns(scans.row_time_ns(scans.header.scans));
    if (!from_ns || !to_ns) return;
    Epoch& epoch = epoch_[key];
    judge(scans, {*from_ns, *to_ns}, *node, epoch);
    if (node == pace_) meter(scans, {*from_ns, *to_ns}, epoch);
    epoch.next_scan = scans.header.first_scan + scans.header.scans;
    epoch.end_ns = *to_ns;
  }

  void judge(const ScanBlock& scans, const Piece& piece, const NodeConfig& node, Epoch& epoch) {
    if (scans.header.first_scan > epoch.next_scan && epoch.next_scan > 0)
      append_any({epoch.end_ns, piece.from_ns});
    std::int32_t angles = 0;
    for (int line = 0; line < kEncoderLines; ++line)
      if (vehicle_.wheel_at(node, line))
        angles |= quality_no_reference(line) | (kQualityUncertainAngle0 << line);
    const auto chosen = static_cast<std::int32_t>(chosen_channels(request_.choice, node));
    if ((scans.quality & angles) != 0 || (scans.overload & chosen) != 0) append_any(piece);
  }

  /// The pieces of several nodes come in no order; those of one mostly touch the one before.
  void append_any(const Piece& piece) {
    Pieces& all = judged_.unclean;
    if (!all.empty() && all.back().from_ns <= piece.from_ns)
      append(all, piece);
    else
      all.push_back(piece);
  }

  void meter(const ScanBlock& scans, const Piece& piece, Epoch& epoch) {
    if (!epoch.meter || scans.header.first_scan != epoch.next_scan) {
      epoch.meter = std::make_unique<LevelMeter>(vehicle_, *pace_);
      epoch.interval = piece;
      epoch.metered_s = 0.0;
    }
    epoch.meter->add(scans);
    epoch.interval.to_ns = piece.to_ns;
    epoch.metered_s += 1e-12 * static_cast<double>(scans.period_ps * scans.header.scans);
    if (epoch.metered_s < kInterval_s) return;
    const auto level = epoch.meter->take();
    if (level && is_wanted(*level)) judged_.at_speed.push_back(epoch.interval);
    epoch.interval.from_ns = piece.to_ns;
    epoch.metered_s = 0.0;
  }

  bool is_wanted(const Level& level) const {
    double sum_m_s = 0.0;
    int known = 0;
    for (int line = 0; line < kEncoderLines; ++line) {
      const WheelConfig* wheel = vehicle_.wheel_at(*pace_, line);
      const double hz = level.rotation_hz[static_cast<std::size_t>(line)];
      if (!wheel || !std::isfinite(hz)) continue;
      sum_m_s += 2.0 * std::numbers::pi * wheel->rolling_radius_m * hz;
      ++known;
    }
    if (known == 0) return false;
    const double speed_m_s = sum_m_s / known;
    return speed_m_s >= request_.time.least_m_s.value_or(-std::numeric_limits<double>::infinity()) &&
           speed_m_s < request_.time.most_m_s.value_or(std::numeric_limits<double>::infinity());
  }

  const SubsetRequest& request_;
  const VehicleConfig& vehicle_;
  const NodeConfig* const pace_;
  EpochClocks clocks_;
  InSequence in_sequence_;
  std::map<NodeEpoch, Epoch> epoch_;
  std::unique_ptr<SealedBlock> block_ = std::make_unique<SealedBlock>();
  JudgedTime judged_;
};

/// The time while all chosen nodes measure.
Pieces covered_by(const RecordingSurvey& survey, const ChannelChoice& choice) {
  Pieces all{{std::numeric_limits<std::int64_t>::min(), Piece::kEver}};
  for (const NodeConfig& node : survey.vehicle.node) {
    if (chosen_channels(choice, node) == 0) continue;
    Pieces of_node;
    for (const RecordedSpan& span : survey.span)
      if (span.node == node.id && (span.first_fit || !survey.own_clocks()))
        of_node.push_back({span.first_host_ns(), span.end_ns()});
    all = common_of(all, merged(std::move(of_node)));
  }
  return all;
}

/// Reads the recording once.
/// @throws as read_recording(); std::runtime_error if `stop` was requested; ConfigError if a speed is asked
/// for and no node reads a wheel
JudgedTime judge_time(const SubsetRequest& request, const RecordingSurvey& survey,
                      const std::stop_token& stop) {
  Judge judge(request, survey);
  RecordReader reader(request.folder);
  reader.finish();
  while (const auto event = reader.next()) {
    judge.take(*event);
    if (stop.stop_requested()) throw std::runtime_error("stopped");
  }
  JudgedTime judged = std::move(judge).result();
  judged.covered = covered_by(survey, request.choice);
  return judged;
}

}  // namespace

Pieces find_pieces(const SubsetRequest& request, const RecordingSurvey& survey, const ExportTable& table,
                   const std::stop_token& stop) {
  Pieces pieces{span_of(request.time, table)};
  if (!request.time.asks_samples()) return pieces;
  const JudgedTime judged = judge_time(request, survey, stop);
  if (request.time.least_m_s || request.time.most_m_s) pieces = common_of(pieces, judged.at_speed);
  if (request.time.clean) pieces = without(common_of(pieces, judged.covered), judged.unclean);
  std::erase_if(pieces, [&](const Piece& piece) {
    return piece.to_ns != Piece::kEver &&
           static_cast<double>(piece.to_ns - piece.from_ns) * 1e-9 < request.time.least_s;
  });
  if (pieces.empty())
    throw ConfigError("--speed, --clean: no stretch of " + std::to_string(request.time.least_s) +
                      " s is of that kind");
  return pieces;
}

}  // namespace roadbalance
