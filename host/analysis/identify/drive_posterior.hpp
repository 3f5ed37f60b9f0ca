#pragma once

#include <map>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "host/analysis/identify/car_posterior.hpp"
#include "host/analysis/identify/line_moments.hpp"
#include "host/analysis/identify/stretch.hpp"
#include "host/analysis/identify/unbalance_posterior.hpp"

namespace roadbalance {

/// The most probable car that a drive was driven with.
struct PosteriorCar {
  ParameterVector parameters;
  ParameterVector sigma;                ///< of them, in their units; 0: known exactly
  Eigen::VectorXd gains, sigma_gains;   ///< [channel]
  Eigen::Vector4d friction_n, rebound;  ///< of the struts (CarPosterior)
  std::array<WheelFirstOrder, kWheels> wheel;
  int steps = 0;       ///< that the search took
  double cut_s = 0.0;  ///< left out for transients
};

/// A car, its sensors' gains, the road's shape and the first-order forces of its wheels from one drive, as
/// one posterior: spectra of the channels (CarPosterior), then the lines of the wheels (unbalance_posterior),
/// both without what joints and potholes shake.
///
/// Memory: spectra of each class of speed (5 MB each), and 2 kB for ten seconds of driving.
class DrivePosterior {
 public:
  explicit DrivePosterior(const CarPrior& prior) : prior_(prior) {}

  /// Of one rate, with readings of the prior's channels; in any order.
  void add(const Stretch& stretch);
  /// From all that was added; nothing: too little, or the search came to no end.
  std::optional<PosteriorCar> solve() const;

 private:
  /// Sections of one stretch: one road.
  struct Lines {
    int speed_class;
    RoadSpectrum density;
    std::vector<LineReading> sections;
  };
  void add_lines(const Stretch& stretch, const Eigen::MatrixXd& signals, const Eigen::ArrayXd& quiet,
                 Eigen::Index settling);
  std::map<int, LineMoments> weighed(const ParameterVector& parameters) const;

  CarPrior prior_;
  std::optional<SpectralGatherer> spectra_;
  std::optional<HarmonicReader> reader_;
  std::map<int, SpectralMoments> speeds_;  ///< by class
  std::vector<Lines> lines_;
  double cut_s_ = 0.0;
};

}  // namespace roadbalance
