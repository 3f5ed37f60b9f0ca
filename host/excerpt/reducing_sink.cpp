#include "host/excerpt/reducing_sink.hpp"

#include <utility>

namespace roadbalance {
namespace {

constexpr std::int32_t kNoReferences = kQualityNoReference0 | kQualityNoReference1;

}  // namespace

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
  // A block's references are known or not: a row that knows them is not to stand with one that does not.
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
  // What is missing up to the end, as far as a scan of it would have been left.
  const std::int64_t end = (index_ + factor_ - 1) / factor_;
  if (begun_ && gap_ && end > next_) to_->gap(end - next_, next_ns_, *gap_);
  to_->end(ending);
}

}  // namespace roadbalance
