#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/identify/body_instrument.hpp"
#include "host/analysis/identify/decimate.hpp"
#include "host/analysis/identify/line_moments.hpp"
#include "host/analysis/identify/moments.hpp"
#include "host/analysis/identify/motion_buffer.hpp"
#include "host/analysis/identify/phase_drift.hpp"
#include "host/analysis/identify/section_buffer.hpp"

namespace roadbalance {

/// The moments of a section, and what its unbalance equations can be weighed anew from.
struct DrivenSection : DriveMoments {
  HarmonicReading reading;  ///< empty from the body alone
  LineMoments lines;        ///< of its channels
  SpectralMoments spectra;  ///< of its channels' motion, what the section before has not; a running one: none
  double cut_s = 0.0;       ///< that joints and potholes shook
};

/// Cuts the drive into sections of steady speed and turns each into its moments.
///
/// Contents and overlap of sections: see SectionBuffer.  A section is looked at
/// in ten parts: one that a hole or a change of speed ends early counts as it is if it has half of them, and
/// one that is still being driven can be asked for as far as it goes.
class SectionBuilder {
 public:
  using Emit = std::function<void(const DrivenSection&)>;

  /// @param sensors  [channel x 7] reading of each vertical channel per unit of z''; no rows: no sensor sits
  ///                 on some wheel's carrier, and the moments are BodyMoments
  SectionBuilder(const VehicleConfig& vehicle, Emit emit, const Eigen::MatrixXd& sensors);
  void consume(const IdentificationSample& sample);

  /// The section being driven, as far as whole parts go; nothing: too short yet, or a wheel lacks its angle.
  std::optional<DrivenSection> running();
  /// Its lines alone, where sensors sit on all carriers: of the moments only sections, seconds and harmonic.
  std::optional<DrivenSection> running_lines();
  /// Grows whenever running() changes.
  std::int64_t news() const { return news_; }

  /// A wheel whose encoder gave no angle in some section, which was therefore not used; nothing: none.
  std::optional<int> missing_reference() const { return missing_reference_; }
  /// Drift over the sections so far.
  const PhaseDrift& phase_drift() const { return phase_drift_; }
  /// Driving below the least speed since the last section.
  double slow_seconds() const { return slow_s_; }

  /// Present knowledge of the car, for the weights of the sections to come.
  void set_parameters(const ParameterVector& parameters) { parameters_ = parameters; }
  /// Weighs a section's unbalance equations by present knowledge of car and road.
  void weigh_anew(DrivenSection& section) const;

 private:
  void weigh(DrivenSection& section, const RoadSpectrum& density) const;
  void check_steadiness();
  void begin_anew(Eigen::Index count);
  void finish_section();
  bool take(Eigen::Index samples);
  Eigen::Index whole_parts(Eigen::Index samples) const;
  std::optional<int> wheel_without_angle(Eigen::Index samples) const;
  enum class Part { kAll, kMoments, kLines };  ///< kMoments: all but spectra
  std::optional<DrivenSection> running(Part part);
  DrivenSection section(Eigen::Index samples, Part part);
  DrivenSection section_of_body(Eigen::Index samples, const Eigen::Vector4d& omega, double speed_m_s);
  bool has_reference(int wheel, Eigen::Index first, Eigen::Index count) const;
  std::optional<int> speed_wheel(Eigen::Index first, Eigen::Index count) const;
  double mean_rotation(int wheel, Eigen::Index first, Eigen::Index count) const;

  double rate_hz_;
  double least_speed_m_s_;
  std::array<double, kWheels> rolling_radius_m_;
  std::array<bool, kWheels> has_encoder_;
  Eigen::Index part_;  ///< of a section, between checks of steadiness
  SectionBuffer buffer_;
  const VehicleConfig vehicle_;
  const Geometry geometry_;
  std::optional<MotionBuffer> motion_;           ///< none: from the body alone
  std::map<Eigen::Index, BodyInstrument> body_;  ///< in place of the buffer's moments, by samples
  PhaseDrift phase_drift_;
  ParameterVector parameters_;
  RoadSpectrum road_, newest_road_;  ///< density of the sections taken; with that of the newest moments
  std::int64_t news_ = 0;
  double slow_s_ = 0.0;
  std::optional<int> missing_reference_;
  Eigen::Index settling_ = 0;  ///< samples still to skip until the filters have settled
  Emit emit_;
};

}  // namespace roadbalance
