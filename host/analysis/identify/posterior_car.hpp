#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/analysis/identify/car_posterior.hpp"
#include "host/analysis/identify/estimate.hpp"
#include "host/analysis/identify/posterior_sums.hpp"
#include "host/analysis/identify/unbalance_posterior.hpp"

namespace roadbalance {

/// How far a quantity of car or sensors is from what was taken for known of it.
struct Deviation {
  UncertainQuantity quantity;
  double value;  ///< found: of parameters in their units, of gains 1, of friction N, of rebound a share
  double sigma;  ///< of it
  /// Of what was taken for known together with what the drive tells: where all is as it is taken for, a
  /// standard normal variable, or less where the drive tells little.
  double sigmas;
};

/// The most probable car that drives were driven with.
struct PosteriorCar {
  ParameterVector parameters = ParameterVector::Zero();
  ParameterVector sigma = ParameterVector::Zero();  ///< of them, in their units; 0: known exactly
  std::vector<Deviation> deviations;                ///< of all that is uncertain
  std::array<WheelFirstOrder, kWheels> wheel;
  /// Standard deviation of an error that all wheels' masses share, and of one that all gains share, 1.
  double mass_scale_sigma = 0.0, gain_scale_sigma = 0.0;

  UnknownVector unknowns() const;  ///< of the car; unbalances are the corrections
};

/// A car, its sensors' gains and the roads' shapes by the spectra of drives: what the lines of its wheels are
/// then heard with.
class SolvedCar {
 public:
  /// @param drives  at least one speed in all; what was driven on one road each
  SolvedCar(const CarPrior& prior, std::vector<PosteriorSums> drives);

  /// Nothing: the search came to no end.
  /// @param lines  of the wheels, each of about one speed
  std::optional<PosteriorCar> with(std::span<const LineMoments> lines) const;

 private:
  Deviation measured(const UncertainQuantity& of, const Eigen::VectorXd& v, double sigma) const;

  std::vector<PosteriorSums> drives_;
  CarPosterior car_;
  PosteriorMode mode_;
};

}  // namespace roadbalance
