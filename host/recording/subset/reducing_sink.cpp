#include "host/recording/subset/reducing_sink.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/dsp/decimation.hpp"
#include "common/types/angle_sigma.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {
namespace {

constexpr std::int32_t kNoReferences = kQualityNoReference0 | kQualityNoReference1;

/// A node's scan with the flags of its block.
struct QualifiedRow {
  std::array<std::int32_t, kChannels> counts{};
  std::int64_t time_ns = 0;
  std::int32_t overload = 0;
  std::int32_t quality = 0;
};

/// The quality that is true of two scans together.  A gap before one of them is not: nothing that takes them
/// together reaches across it.
std::int32_t worst_of(std::int32_t a, std::int32_t b) {
  std::int32_t both = (a | b) & kQualityFlags & ~kQualityAfterGap;
  for (int line = 0; line < kEncoderLines; ++line) {
    const int place = angle_sigma_place(line);
    const std::int32_t one = a >> place & kMostAngleSigma, other = b >> place & kMostAngleSigma;
    if (one != 0 && other != 0) both |= std::max(one, other) << place;  // 0: unknown
  }
  return both;
}

/// Every factor-th scan behind reduction_taps(), all channels alike, without delay.
///
/// A scan comes out where all scans within the filter's reach are there in one run.  It stands for all of
/// them: it is overloaded if one of them was, and its angles are as uncertain as the worst of them.  The
/// references of a wheel whose angle is unknown in one of them are 0.
class RowDecimator {
 public:
  explicit RowDecimator(int factor);

  struct Reduced {
    QualifiedRow row;
    std::int64_t index = 0;  ///< among the new scans: old index / factor
  };
  /// The next scan of a run.
  /// @param index  counted from the begin; an index that does not follow the one before begins a new run
  std::optional<Reduced> add(const QualifiedRow& row, std::int64_t index);

 private:
  struct Beside {
    std::int64_t time_ns;
    std::int32_t overload, quality;
  };
  QualifiedRow filtered() const;

  const int factor_;
  const Eigen::VectorXd taps_;
  Eigen::Matrix<double, kChannels, Eigen::Dynamic> history_;  ///< column filled_ - 1 the newest
  std::vector<Beside> beside_;                                ///< [column]
  Eigen::Index filled_ = 0;
  std::int64_t next_index_ = 0;
};

RowDecimator::RowDecimator(int factor)
    : factor_(factor),
      taps_(reduction_taps(factor)),
      history_(kChannels, 4 * taps_.size()),
      beside_(static_cast<std::size_t>(history_.cols())) {}

QualifiedRow RowDecimator::filtered() const {
  const Eigen::Index n = taps_.size();
  const Eigen::Matrix<double, kChannels, 1> values = history_.middleCols(filled_ - n, n) * taps_;
  const auto begin = beside_.begin() + (filled_ - n);
  QualifiedRow row{.time_ns = (begin + (n - 1) / 2)->time_ns, .overload = 0, .quality = begin->quality};
  for (auto one = begin; one != begin + n; ++one) {
    row.overload |= one->overload;
    row.quality = worst_of(row.quality, one->quality);
  }
  for (std::size_t c = 0; c < row.counts.size(); ++c)
    row.counts[c] = static_cast<std::int32_t>(std::lround(values[static_cast<Eigen::Index>(c)]));
  for (int line = 0; line < kEncoderLines; ++line)
    if ((row.quality & quality_no_reference(line)) != 0)
      std::fill_n(row.counts.begin() + kAccelerations + 2 * line, 2, 0);
  return row;
}

std::optional<RowDecimator::Reduced> RowDecimator::add(const QualifiedRow& row, std::int64_t index) {
  const Eigen::Index n = taps_.size();
  if (index != next_index_) filled_ = 0;
  next_index_ = index + 1;
  if (filled_ == history_.cols()) {
    history_.leftCols(n - 1) = history_.rightCols(n - 1).eval();
    std::copy(beside_.end() - (n - 1), beside_.end(), beside_.begin());
    filled_ = n - 1;
  }
  history_.col(filled_) =
      Eigen::Map<const Eigen::Matrix<std::int32_t, kChannels, 1>>(row.counts.data()).cast<double>();
  beside_[static_cast<std::size_t>(filled_)] = {row.time_ns, row.overload, row.quality};
  ++filled_;
  const std::int64_t centre = index - (n - 1) / 2;
  if (filled_ < n || centre % factor_ != 0) return std::nullopt;
  return Reduced{filtered(), centre / factor_};
}

/// The sink of make_reducing_sink().
class ReducingSink final : public EpochSink {
 public:
  ReducingSink(int factor, std::unique_ptr<EpochSink> to);

  void scans(const ScanBlock& block) override;
  void gap(std::int64_t scans, std::int64_t time_ns, GapCause cause) override;
  void edges(std::span<const Edge> edges) override { to_->edges(edges); }
  void signals(std::span<const SignalSample> samples) override { to_->signals(samples); }
  void end(Ending ending) override;

 private:
  void add(const RowDecimator::Reduced& reduced, std::int64_t period_ps);
  void put_rows();

  const int factor_;
  const std::unique_ptr<EpochSink> to_;
  RowDecimator decimator_;
  std::int64_t index_ = 0;       ///< of the next scan that comes in
  std::int64_t next_ = 0;        ///< of the next scan that goes out
  std::int64_t next_ns_ = 0;     ///< its instant
  bool begun_ = false;           ///< a scan went out, or a gap begins the grid
  ScanBlock block_;              ///< of outgoing scans, being filled
  std::optional<GapCause> gap_;  ///< since the last outgoing scan
};

ReducingSink::ReducingSink(int factor, std::unique_ptr<EpochSink> to)
    : factor_(factor), to_(std::move(to)), decimator_(factor) {}

void ReducingSink::put_rows() {
  if (block_.header.scans > 0) to_->scans(block_);
  block_ = ScanBlock{};
}

void ReducingSink::add(const RowDecimator::Reduced& reduced, std::int64_t period_ps) {
  const QualifiedRow& row = reduced.row;
  if (begun_ && reduced.index > next_) {
    put_rows();
    to_->gap(reduced.index - next_, next_ns_, gap_.value_or(GapCause::kLostInRecord));
  }
  begun_ = true;
  gap_.reset();
  // The references of a whole block are known or not: rows with and without them go into different blocks.
  const bool differs = ((block_.quality ^ row.quality) & kNoReferences) != 0;
  if (block_.header.scans == kScansPerBlock || differs) put_rows();
  if (block_.header.scans == 0) {
    block_.header.time_ns = row.time_ns;
    block_.period_ps = period_ps;
    block_.quality = row.quality;
  }
  block_.counts[static_cast<std::size_t>(block_.header.scans++)] = row.counts;
  block_.overload |= row.overload;
  block_.quality = worst_of(block_.quality, row.quality);
  next_ = reduced.index + 1;
  next_ns_ = row.time_ns + period_ps / 1000;
}

void ReducingSink::scans(const ScanBlock& block) {
  for (std::int64_t k = 0; k < block.header.scans; ++k) {
    const QualifiedRow row{.counts = block.counts[static_cast<std::size_t>(k)],
                           .time_ns = block.row_time_ns(k),
                           .overload = block.overload,
                           .quality = block.quality};
    if (const auto reduced = decimator_.add(row, index_++)) add(*reduced, factor_ * block.period_ps);
  }
}

void ReducingSink::gap(std::int64_t scans, std::int64_t time_ns, GapCause cause) {
  if (scans == 0) {
    put_rows();
    return to_->gap(0, time_ns, cause);
  }
  if (!begun_) {
    begun_ = true;
    next_ = (index_ + factor_ - 1) / factor_;
    next_ns_ = time_ns;
  }
  index_ += scans;
  gap_ = cause;
}

void ReducingSink::end(Ending ending) {
  put_rows();
  // The gap up to the end, if it holds a scan of the new grid.
  const std::int64_t end = (index_ + factor_ - 1) / factor_;
  if (begun_ && gap_ && end > next_) to_->gap(end - next_, next_ns_, *gap_);
  to_->end(ending);
}

}  // namespace

std::unique_ptr<EpochSink> make_reducing_sink(int factor, std::unique_ptr<EpochSink> to) {
  return std::make_unique<ReducingSink>(factor, std::move(to));
}

}  // namespace roadbalance
