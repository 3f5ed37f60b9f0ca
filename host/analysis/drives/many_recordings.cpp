#include "host/analysis/drives/many_recordings.hpp"

#include <utility>

#include "common/config/section.hpp"
#include "host/analysis/drives/same_car.hpp"
#include "host/recording/recorded_vehicle.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

bool overlap(const MeasuredTime& a, const MeasuredTime& b) {
  return a.node == b.node && a.epoch == b.epoch && a.first_ns <= b.last_ns && b.first_ns <= a.last_ns;
}

}  // namespace

ManyRecordings::ManyRecordings(const std::vector<fs::path>& recordings, bool skip_unusable)
    : skip_unusable_(skip_unusable) {
  std::optional<VehicleConfig> first;
  for (const fs::path& recording : recordings) {
    std::optional<VehicleConfig> vehicle;
    try {
      vehicle = recorded_vehicle(recording);
    } catch (const std::exception& error) {
      leave_out(recording, error.what(), true);
      continue;
    }
    if (!vehicle) {
      leave_out(recording, "holds no vehicle.toml or no scan", false);
      continue;
    }
    if (!first)
      first = vehicle;
    else if (const auto difference = difference_of_cars(*first, *vehicle))
      throw ConfigError(recordings_.front().string() + " and " + recording.string() +
                        " do not belong together: " + *difference);
    vehicle_ = std::move(vehicle);
    recordings_.push_back(recording);
  }
  if (!first) throw Unusable("none of the recordings is usable");
  drives_.emplace(*vehicle_);
}

void ManyRecordings::leave_out(const fs::path& recording, const std::string& why, bool not_read) {
  if (skip_unusable_) {
    left_out_.push_back({recording, why});
    return;
  }
  const std::string sentence = recording.string() + ": " + why + "; --skip-unusable leaves it out";
  if (not_read) throw std::runtime_error(sentence);
  throw Unusable(sentence);
}

/// Drives that are counted twice would seem surer than they are.
void ManyRecordings::refuse_shared_samples(const fs::path& recording,
                                           const std::vector<MeasuredTime>& measured) {
  for (const Held& held : held_)
    for (const MeasuredTime& there : held.measured)
      for (const MeasuredTime& here : measured)
        if (overlap(there, here))
          throw ConfigError(held.recording.string() + " and " + recording.string() +
                            " hold the same samples of node " + std::to_string(here.node) +
                            ": a drive counts once");
}

void ManyRecordings::take(const fs::path& recording, DriveShare share) {
  if (!share.sums) return leave_out(recording, share.unusable, share.not_read);
  refuse_shared_samples(recording, share.measured);
  held_.push_back({recording, std::move(share.measured)});
  if (!share.contradictions.empty())
    contradictions_ +=
        (contradictions_.empty() ? "" : "; ") + recording.string() + ": " + share.contradictions;
  const DriveMoments total = share.sums->classes.total();
  used_.push_back({recording, total.seconds, total.sections, share.missing_blocks});
  drives_->add(std::move(*share.sums));
}

RecordedEstimate ManyRecordings::estimate() {
  if (used_.empty()) throw Unusable("none of the recordings is usable");
  const DriveEstimate estimate = drives_->estimate();
  RecordedEstimate found =
      recorded_estimate(estimate, drives_->forces(), *vehicle_, drives_->common_sigma_rad());
  found.refusal = drives_->refusal();
  for (const std::string& diagnostic : drives_->diagnostics()) found.diagnostics.push_back(diagnostic);
  if (!contradictions_.empty()) found.refusal += (found.refusal.empty() ? "" : "; ") + contradictions_;
  return found;
}

}  // namespace roadbalance
