#include "host/analyser/tap_meter.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {
namespace {

/// Angle that a reference turns through in the block.
double turned_rad(const ScanBlock& block, int line) {
  const auto last = static_cast<std::size_t>(block.header.scans - 1);
  const auto sine = static_cast<std::size_t>(kAccelerations + 2 * line);
  const double s0 = block.counts[0][sine], c0 = block.counts[0][sine + 1];
  const double s1 = block.counts[last][sine], c1 = block.counts[last][sine + 1];
  return std::abs(std::atan2(s1 * c0 - s0 * c1, s1 * s0 + c1 * c0));
}

bool turns(const ScanBlock& block) {
  constexpr double kTurning_rad_s = 0.5;
  const double seconds =
      static_cast<double>(block.header.scans) * static_cast<double>(block.period_ps) * 1e-12;
  for (int line = 0; line < kEncoderLines; ++line)
    if ((block.quality & quality_no_reference(line)) == 0 &&
        turned_rad(block, line) > kTurning_rad_s * seconds)
      return true;
  return false;
}

}  // namespace

TapMeter::TapMeter(const NodeConfig& node) : node_(node) {}

void TapMeter::begin_anew() {
  noise_ = {};
  learned_ = quiet_ = wanted_ = 0;
  rows_.clear();
}

std::optional<Tap> TapMeter::add(const ScanBlock& block) {
  if (block.header.scans <= 0) return std::nullopt;
  const bool moves = turns(block);
  if (block.header.first_scan != next_scan_ || moves) begin_anew();
  next_scan_ = block.header.first_scan + block.header.scans;
  if (moves) return std::nullopt;
  std::optional<Tap> tap;
  for (std::int64_t r = 0; r < block.header.scans; ++r) {
    Row row{};
    const auto& counts = block.counts[static_cast<std::size_t>(r)];
    for (std::size_t c = 0; c < node_.channel.size() && c < row.size(); ++c)
      if (node_.channel[c].role != ChannelRole::kUnused) row[c] = node_.channel[c].to_si(counts[c]);
    if (auto ended = add(row, block.row_time_ns(r))) tap = ended;
  }
  return tap;
}

std::optional<Tap> TapMeter::add(const Row& row, std::int64_t time_ns) {
  Row about{};
  for (std::size_t c = 0; c < row.size(); ++c) about[c] = row[c] - noise_[c].mean;
  const auto scans = [this](double seconds) { return std::lround(seconds * node_.rate_hz); };
  rows_.push_back(about);
  if (wanted_ > 0) {
    if (--wanted_ > 0) return std::nullopt;
    ++number_;
    const Tap tap = finish();
    rows_.clear();
    quiet_ = scans(kQuiet_s);
    return tap;
  }
  if (std::ssize(rows_) > scans(kBefore_s) + 1) rows_.pop_front();
  const bool knows = learned_ >= scans(kMemory_s);
  if (quiet_ > 0) {
    --quiet_;
  } else if (knows && begins(about)) {
    wanted_ = scans(kWindow_s);
    begin_ns_ = time_ns;
    return std::nullopt;
  }
  learn(row);
  return std::nullopt;
}

/// Exponential memory; the plain mean while it fills.
void TapMeter::learn(const Row& row) {
  ++learned_;
  const double share =
      1.0 / static_cast<double>(std::min(learned_, static_cast<std::int64_t>(kMemory_s * node_.rate_hz)));
  for (std::size_t c = 0; c < row.size(); ++c) {
    Noise& noise = noise_[c];
    const double about = row[c] - noise.mean;
    noise.mean += share * about;
    noise.square += share * (about * (row[c] - noise.mean) - noise.square);
  }
}

/// By squares: no root for each channel of each scan.
bool TapMeter::begins(const Row& about) const {
  if (std::ranges::any_of(noise_,
                          [](const Noise& noise) { return noise.square > kStill_m_s2 * kStill_m_s2; }))
    return false;
  for (std::size_t c = 0; c < about.size(); ++c)
    if (std::abs(about[c]) > kLeast_m_s2 && about[c] * about[c] > kNoises * kNoises * noise_[c].square)
      return true;
  return false;
}

Tap TapMeter::finish() const {
  Tap tap{.node = node_.id, .time_ns = begin_ns_, .number = number_};
  for (std::size_t c = 0; c < static_cast<std::size_t>(kAccelerations); ++c) {
    double& peak = tap.peak_m_s2[c];
    for (const Row& row : rows_) peak = std::max(peak, std::abs(row[c]));
    auto row =
        std::ranges::find_if(rows_, [&](const Row& each) { return std::abs(each[c]) >= kSwing * peak; });
    if (row == rows_.end()) continue;
    double& first = tap.first_m_s2[c];
    for (const bool up = (*row)[c] > 0.0; row != rows_.end() && ((*row)[c] > 0.0) == up; ++row)
      if (std::abs((*row)[c]) > std::abs(first)) first = (*row)[c];
  }
  const auto loudest = std::ranges::max_element(tap.peak_m_s2);
  tap.channel = static_cast<std::int32_t>(loudest - tap.peak_m_s2.begin());
  return tap;
}

}  // namespace roadbalance
