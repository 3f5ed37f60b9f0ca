#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "common/dsp/linear_filter.hpp"
#include "host/analysis/identify/estimators/annihilator.hpp"
#include "host/analysis/identify/stretch.hpp"

namespace roadbalance {

/// Signals x that the filter turns into instruments, in this order: z'' [7], then cos and sin of each wheel's
/// angle [8] as in signals.hpp, then the road u under the wheels [4] where it is measured.
inline constexpr int kRelationSignals = kSignals + kWheels;

/// The sample covariances that relation (2) is made of, of one lag tau: sums over time, as integrals, of an
/// instrument's w''(t), w'(t), w(t) with what is measured tau later.
///
/// Row: instrument j of signal s at row j kRelationSignals + s.
struct LaggedCovariances {
  Eigen::MatrixXd w2_z, w1_z, w0_z;  ///< [instrument x 7] with z'': H C_yz'', H F^-1 C_yz'', H F^-2 C_yz''
  Eigen::MatrixXd w2_d;              ///< [instrument x 8] H C_yd with Om^2 cos, Om^2 sin of each wheel
  Eigen::MatrixXd w2_u;              ///< [instrument x 4] H C_yu; 0 where the road is not measured
};

/// Sums over stretches at one speed; two add by +=.
struct RelationCovariances {
  double seconds = 0.0;
  double metres = 0.0;
  Eigen::Vector4d turned_rad = Eigen::Vector4d::Zero();  ///< by each wheel; 0: it has no reference
  std::vector<LaggedCovariances> lag;
  Eigen::VectorXd power;  ///< [instrument] integral of w''^2

  double speed_m_s() const { return metres / seconds; }
  Eigen::Vector4d omega() const { return turned_rad / seconds; }  ///< rad/s
  RelationCovariances& operator+=(const RelationCovariances& other);
};

/// Cuts stretches into parts and takes the covariances of each.
///
/// As the paper does it, averages over a stretch stand for expected values; their end effects fall with the
/// length.  Windowed, the instrument of each part is W = h w with a C2 taper h and
///
///     W' = h w' + h' w,   W'' = h w'' + 2 h' w' + h'' w,
///
/// so that (2) is an identity of the part, without end terms.
class RelationFilter {
 public:
  struct Options {
    int order = 5;
    double cutoff_hz = 30.0;
    std::vector<double> lags_s{0.0};  ///< tau: instrument earlier, measurement later; negative: the reverse
    bool windowed = false;
    double taper_fraction = 0.1;  ///< of a part, at each end
    double part_s = 2.5;          ///< parts are this long or a little longer
  };
  using Emit = std::function<void(double speed_m_s, const RelationCovariances&)>;

  /// @throws std::invalid_argument as butterworth() and annihilator()
  explicit RelationFilter(Options options);

  /// The parts of a stretch.  Wheels whose omega is 0 have no references.
  void parts(const Stretch& stretch, const Emit& emit) const;

 private:
  Options options_;
  ContinuousFilter filter_;
  Annihilator H_;
};

}  // namespace roadbalance
