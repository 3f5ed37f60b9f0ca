#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/analysis/identify/estimators/estimator.hpp"
#include "host/analysis/identify/estimators/grouped.hpp"
#include "host/analysis/identify/section_buffer.hpp"
#include "host/analysis/identify/whittle_moments.hpp"

namespace roadbalance {

/// Sums of two-stage estimators over sections driven at about one speed.
struct SectionMoments {
  DriveMoments drive;
  Eigen::Vector4d turned_rad = Eigen::Vector4d::Zero();  ///< in DriveMoments::seconds

  SectionMoments& operator+=(const SectionMoments& other) {
    drive += other.drive;
    turned_rad += other.turned_rad;
    return *this;
  }
};

/// Where the stiffness of a tyre is taken from.
enum class TyreFrom {
  kKnown,       ///< Question::known
  kInstrument,  ///< the wheel's own past acceleration (SectionBuffer)
  kWhittle,     ///< the likelihood of the road (whittle.hpp)
};

/// First the suspension from the body's rows, then the tyres, then the unbalances by demodulation
/// (harmonic.hpp): the product's own way, put together anew for each kind of TyreFrom and RoadShare.
///
/// The covariance is computed from the road that is left about the wheels' order, from the likelihood's
/// information and from the slopes dU/dct; what the suspension is known to comes from its jackknife and
/// differences.  Where tyres come from the instrument it is the jackknife's all through.
///
/// Each stretch is cut into equal sections of about 10 s that overlap as in SectionBuffer.  A stretch below
/// 4 s has no segment for the likelihood.
class TwoStage final : public Estimator {
 public:
  struct Options {
    TyreFrom tyre = TyreFrom::kKnown;
    RoadShare share = RoadShare::kApart;
    bool separate_force = false;  ///< from a force that does not grow with speed (first_order.hpp)
  };
  TwoStage(const Question& question, const Options& options) : question_(question), options_(options) {}

  void add(const Stretch& stretch) override;
  EstimatorAnswer solve() const override;

 private:
  using Drive = BySpeed<SectionMoments>;
  struct Solution {
    UnknownVector x;
    UnknownMatrix covariance;  ///< suspension taken for exact
  };
  /// Question::known with what the body's rows determine of what is asked.
  std::optional<ParameterVector> with_suspension(const DriveMoments& drive) const;
  std::optional<Solution> solve_wheels(const Drive& drive, const ParameterVector& parameters) const;
  /// Unbalances beside a force that does not grow with speed, where speeds separate them; returns the
  /// diagnostics.
  std::vector<std::string> separate_forces(const Drive& drive, Solution& solution) const;
  void add_variance_of_suspension(const Drive& drive, const ParameterVector& parameters,
                                  Solution& solution) const;

  Question question_;
  Options options_;
  std::optional<SectionBuffer> buffer_;  ///< for stretches of one length
  std::optional<WhittleGatherer> road_;
  Grouped<SectionMoments> sections_;
  BySpeed<WhittleMoments> roads_;  ///< of whole stretches
};

/// known-tyre, instrument, whittle, cancellation, force-variation.
std::vector<EstimatorKind> two_stage_kinds();

}  // namespace roadbalance
