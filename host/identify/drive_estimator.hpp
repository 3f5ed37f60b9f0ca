#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/results.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/identify/assemble.hpp"
#include "host/identify/decimate.hpp"
#include "host/identify/estimate.hpp"
#include "host/identify/section.hpp"

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

  /// The newest estimate; its states say what is not known yet and why.
  const DriveEstimate& estimate() const { return estimate_; }
  /// Grows by one with each new estimate.
  std::int64_t version() const { return version_; }

 private:
  /// Sections of about one speed, dealt out to the jackknife's groups in turn.
  struct SpeedClass {
    static constexpr std::size_t kGroups = 10;
    std::array<DriveMoments, kGroups> group;
    DriveMoments total;
  };

  void report_unknown(Unknown state);
  void add_sample(const IdentificationSample& sample);
  void add_section(const DriveMoments& section);
  void update_estimate();
  void publish(const UnknownVector& x, const UnknownMatrix& covariance);
  void publish_suspension(const UnknownVector& x, const UnknownMatrix& covariance);
  void publish_balances(const UnknownVector& x, const UnknownMatrix& covariance);
  /// In the balances: how well the zero marks' datums are known.
  void add_doubt_of_datums();
  /// In the balances: what vehicle.toml may be wrong by, where the body alone was heard.
  void add_doubt_of_parameters();
  void publish_unknown(Unknown state);
  void describe_drive();

  VehicleConfig vehicle_;
  Geometry geometry_;
  ParameterVector known_;
  std::map<int, SpeedClass> classes_;
  std::int64_t time_ns_ = 0;
  DriveEstimate estimate_;
  std::int64_t version_ = 0;
  std::string obstacle_;
  bool body_only_;
  SectionBuilder sections_;
  std::optional<Decimator> decimator_;
  std::optional<Assembler> assembler_;
};

}  // namespace roadbalance
