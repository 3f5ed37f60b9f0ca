#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/results.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/identify/assemble.hpp"
#include "host/identify/decimate.hpp"
#include "host/identify/estimate.hpp"
#include "host/identify/judgement.hpp"
#include "host/identify/section.hpp"
#include "host/identify/speed_classes.hpp"
#include "host/identify/speed_forces.hpp"

namespace roadbalance {

/// Fewer sections than this cannot tell their own scatter.
inline constexpr int kLeastSections = 6;

struct DriveEstimate {
  Identification identification;
  std::array<Balance, kWheels> balance;
};

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
  const DriveForces& forces() const { return forces_; }
  /// Grows by one with each new estimate.
  std::int64_t version() const { return version_; }

 private:
  void report_unknown(Unknown state);
  void add_sample(const IdentificationSample& sample);
  void add_section(const DrivenSection& section);
  void note_news();
  void learn_weights();
  void weigh_early_sections();
  void update_estimate();
  void publish(const UnknownVector& x, const Judgement& judgement);
  void publish_balances(const UnknownVector& x, const Judgement& judgement);
  /// In the balances: what vehicle.toml may be wrong by, where the body alone was heard.
  void add_doubt_of_parameters(const DriveMoments& drive);
  void publish_unknown(Unknown state);
  void describe_drive(const SpeedClasses& drive);

  VehicleConfig vehicle_;
  Known known_;
  SpeedClasses classes_;
  std::vector<DrivenSection> early_;  ///< of classes_, while the car is as vehicle.toml has it
  bool weights_known_ = false;
  std::int64_t time_ns_ = 0, news_ns_ = 0;
  DriveEstimate estimate_;
  DriveForces forces_{};
  std::int64_t version_ = 0;
  bool stale_ = false;  ///< there is more to tell than estimate_ does
  std::string obstacle_;
  std::string refusal_;  ///< of the estimate; empty: it is given, or there is none yet
  bool body_only_;
  SectionBuilder sections_;
  std::optional<Decimator> decimator_;
  std::optional<Assembler> assembler_;
};

}  // namespace roadbalance
