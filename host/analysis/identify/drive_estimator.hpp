#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/identify/assemble.hpp"
#include "host/analysis/identify/decimate.hpp"
#include "host/analysis/identify/drive_posterior.hpp"
#include "host/analysis/identify/drive_sums.hpp"
#include "host/analysis/identify/estimate_report.hpp"
#include "host/analysis/identify/section.hpp"
#include "host/analysis/identify/speed_classes.hpp"

namespace roadbalance {

/// Sealed blocks in, estimate out: the one path of identification, live and offline.
///
/// Where no sensor sits on some wheel's carrier the unbalances come from the body alone (BodyInstrument), and
/// wheels that turned in step are refused: their shares in what the body feels differ by a model only.
///
/// Blocks of one node come in the order of their sequence with the fits of its clock between them; how those
/// of different nodes interleave does not matter.  Memory is bounded: moments are kept per speed class and
/// jackknife group, not per section.
///
/// There is a new estimate for every second of steady driving: the section that is still being driven counts
/// as far as it goes, in the jackknife's group that it will belong to.  An estimate is a function of the
/// blocks so far; when it was asked for makes no difference.
class DriveEstimator {
 public:
  explicit DriveEstimator(const VehicleConfig& vehicle);
  DriveEstimator(const DriveEstimator&) = delete;
  DriveEstimator& operator=(const DriveEstimator&) = delete;

  void consume(const SealedBlock& block);
  /// In the order of the record: a fit counts for the blocks of its node that come after it.
  void consume(const ClockFit& fit);

  /// Why there is no estimate, naming the thing at fault; empty: only time is missing.
  std::string refusal() const;

  /// A sentence for each channel that is clipped: sections in which it was are not used.
  std::vector<std::string> clipped() const;

  /// Sentences on what the newest estimate shows of car and sensors beyond vehicle.toml.
  const std::vector<std::string>& remarks() const { return report_.remarks(); }

  /// The newest estimate; its states give what is not known yet and why.  Computed when asked for.
  const DriveEstimate& estimate();
  /// The car of the newest estimate; nothing: none was found, or it is from the body alone.
  const std::optional<PosteriorCar>& car() const { return car_; }
  /// Forces at each class of speed by the newest estimate; empty where it gives no balance, or none but from
  /// the body alone.
  const DriveForces& forces() const { return report_.forces(); }
  /// This drive's contribution, as far as it went, to an estimate from many (joint_drives.hpp).
  DriveSums sums();
  /// Grows by one with each new estimate.
  std::int64_t version() const { return version_; }

 private:
  void report_unknown(Unknown state);
  void add_sample(const IdentificationSample& sample);
  void add_section(const DrivenSection& section);
  void note_news();
  void learn_weights();
  void weigh_early_sections();
  SpeedClasses classes_so_far(const std::optional<DrivenSection>& running) const;

  VehicleConfig vehicle_;
  EstimateReport report_;
  SpeedClasses classes_;
  std::optional<DrivePosterior> posterior_;  ///< none: from the body alone
  std::vector<DrivenSection> early_;         ///< of classes_, while the car is as vehicle.toml has it
  bool weights_known_ = false;
  std::int64_t time_ns_ = 0, news_ns_ = 0;
  std::int64_t version_ = 0;
  std::optional<PosteriorCar> car_;
  bool stale_ = false;  ///< report_ is older than the sums
  SectionBuilder sections_;
  std::optional<Decimator> decimator_;
  std::optional<Assembler> assembler_;
};

}  // namespace roadbalance
