#pragma once

#include <complex>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace roadbalance {

/// One run of a rotor with known weights in its planes, and what was observed of it.
struct InfluenceRun {
  Eigen::VectorXcd weight;       ///< [plane] mass at its angle, in any unit; 0: none
  Eigen::VectorXcd observed;     ///< [channel and speed] order vector: amplitude at its phase
  Eigen::VectorXd variance;      ///< [channel and speed] of the observed vector, both parts together; > 0
  double phase_sigma_rad = 0.0;  ///< by which all its phases may be off together; beside the variance
};

/// Effect of weights on a rotor, and the weights that quieten it.
struct InfluenceBalance {
  Eigen::MatrixXcd influence;    ///< [channel and speed x plane] per unit of weight
  Eigen::VectorXcd bare;         ///< [channel and speed] of the rotor without any weight
  Eigen::VectorXcd correction;   ///< [plane] weights to put on the bare rotor
  Eigen::VectorXd sigma;         ///< [plane] of each part of a correction, by the runs' variances and phases
  Eigen::VectorXcd residual;     ///< [channel and speed] that will be left
  double rms_before, rms_after;  ///< of the amplitudes, over channels and speeds
  /// Runs beyond those needed check the others: that a linear rotor whose runs scatter so shows
  /// contradictions as large as these; 1 if there is none beyond.
  double chance = 1.0;
  /// Largest through least singular value of the influence: so many times a relative error of what is
  /// observed may count in the weights; 1 is best.
  double condition = 1.0;
};

/// The weight that quietens a plane.
struct PlaneCorrection {
  double mass_g = 0.0,
         angle_rad = 0.0;  ///< from the rotor's own mark in the direction of rotation, 0 .. 2 pi
  double mass_sigma_g = 0.0, angle_sigma_rad = 0.0;
};

/// @param sigma_g  of each part of the weight
PlaneCorrection plane_correction(std::complex<double> weight_g, double sigma_g);

/// w = -(A* A)^-1 A* bare; nothing if the influences A [observation x plane] do not determine the weights.
std::optional<Eigen::VectorXcd> correction_by_influence(const Eigen::MatrixXcd& influence,
                                                        const Eigen::VectorXcd& bare);

/// Correction weights by influence coefficients, least squares.
///
/// The rotor answers linearly: observed = bare + influence weight.  Both are fitted to the runs, channel by
/// channel, each run by its variance; then the weights w minimise sum |bare + influence w|^2:
///
///     w = -(A* A)^-1 A* bare
///
/// As many runs as planes and one more are needed, whose weights differ in all planes: one without weights,
/// and one with a trial weight in each; a trial weight may stay on for the runs that follow, which then list
/// it. All must have the same phase reference and speed.
///
/// Source: T. P. Goodman, A Least-Squares Method for Computing Balance Corrections, J. Engineering for
/// Industry 86 (1964) 273-279.
/// @throws std::invalid_argument if runs have different sizes or a variance is not positive, a phase sigma
///         negative
/// @return nothing if the runs do not determine the influences, which must stand out of their variances, or
/// the observations not the weights
std::optional<InfluenceBalance> balance_by_influence(const std::vector<InfluenceRun>& runs);

}  // namespace roadbalance
