#pragma once

#include <functional>
#include <optional>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/dsp/state_filter.hpp"
#include "common/dsp/taper.hpp"
#include "host/identify/body_instrument.hpp"
#include "host/identify/decimate.hpp"
#include "host/identify/harmonic.hpp"
#include "host/identify/moments.hpp"
#include "host/identify/phase_drift.hpp"

namespace roadbalance {

/// Cuts the drive into sections of steady speed and turns each into its moments.
///
/// Every section is closed by a C2 taper on its instruments, so that (2) holds for the finite section without
/// end terms.  Instruments: for the chassis, Butterworth order 5 at 15 Hz of each acceleration with lag 20
/// ms; for a tyre, s^2 / ((s + wl)^2 B3(s / wh)) of the wheel's own acceleration, 1 .. 80 Hz, lag 4 ms.  Lags
/// are positive (instrument past, acceleration future): the road to come and sensor noise then drop out.
class SectionBuilder {
 public:
  using Emit = std::function<void(const DriveMoments&)>;

  /// @param body_only  no sensor sits on the wheel carriers: the moments are BodyMoments
  SectionBuilder(const VehicleConfig& vehicle, Emit emit, bool body_only = false);
  void consume(const IdentificationSample& sample);

  /// A wheel whose encoder gave no angle in some section, which was therefore not used; nothing: none.
  std::optional<int> missing_reference() const { return missing_reference_; }
  /// Of the sections so far.
  const PhaseDrift& phase_drift() const { return phase_drift_; }
  /// Driving below the least speed since the last section.
  double slow_seconds() const { return slow_s_; }

  /// Present knowledge of the car, for the weights of the sections to come.
  void set_parameters(const ParameterVector& parameters) { parameters_ = parameters; }

 private:
  void restart(Eigen::Index keep);
  void check_steadiness();
  void finish_section();
  DriveMoments moments() const;
  void add_chassis(DriveMoments& sum) const;
  void add_tyre(DriveMoments& sum, int wheel, double omega) const;
  bool has_reference(int wheel, Eigen::Index first, Eigen::Index count) const;
  std::optional<int> speed_wheel(Eigen::Index first, Eigen::Index count) const;
  double mean_rotation(int wheel, Eigen::Index first, Eigen::Index count) const;

  double rate_hz_;
  double least_speed_m_s_;
  std::array<double, kWheels> rolling_radius_m_;
  std::array<bool, kWheels> has_encoder_;
  Eigen::Index samples_;  ///< of a section
  Eigen::Index part_;     ///< of a section, between checks of steadiness
  Eigen::Index chassis_lag_, tyre_lag_;
  StateFilter chassis_filter_, tyre_filter_;
  Taper taper_;
  HarmonicInstrument harmonic_;
  std::optional<BodyInstrument> body_;  ///< in its place
  PhaseDrift phase_drift_;
  ParameterVector parameters_;
  SignalMatrix signals_;            ///< [signal x sample], samples_ + the longest lag
  Eigen::MatrixXd chassis_states_;  ///< [coordinate + 7 * state x sample]
  Eigen::MatrixXd tyre_states_;     ///< [wheel + 4 * state x sample]
  Eigen::Index filled_ = 0;
  double slow_s_ = 0.0;
  std::optional<int> missing_reference_;
  Eigen::Index settling_ = 0;  ///< samples still to skip until the filters have settled
  Emit emit_;
};

}  // namespace roadbalance
