#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/identify/assemble.hpp"
#include "host/identify/conclusions.hpp"
#include "host/identify/decimate.hpp"
#include "host/identify/drive_sums.hpp"
#include "host/identify/section.hpp"
#include "host/identify/speed_classes.hpp"

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

  /// What stands in the way of an estimate, naming the thing at fault; empty: nothing but time.
  std::string obstacle() const;

  /// The newest estimate; its states say what is not known yet and why.  Computed when asked for.
  const DriveEstimate& estimate();
  /// What the newest estimate makes of each class of speed; empty where it gives no balance, or none but from
  /// the body alone.
  const DriveForces& forces() const { return conclusions_.forces(); }
  /// What this drive, as far as it went, gives to an estimate from many (joint_drives.hpp).
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
  SpeedClasses classes_so_far();

  VehicleConfig vehicle_;
  Conclusions conclusions_;
  SpeedClasses classes_;
  std::vector<DrivenSection> early_;  ///< of classes_, while the car is as vehicle.toml has it
  bool weights_known_ = false;
  std::int64_t time_ns_ = 0, news_ns_ = 0;
  std::int64_t version_ = 0;
  bool stale_ = false;  ///< there is more to tell than conclusions_ do
  SectionBuilder sections_;
  std::optional<Decimator> decimator_;
  std::optional<Assembler> assembler_;
};

}  // namespace roadbalance
