#pragma once

#include <array>
#include <complex>
#include <vector>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/spectral_moments.hpp"
#include "host/analysis/identify/strut_motion.hpp"

namespace roadbalance {

/// What is taken for known of a car and its sensors before it is driven.
struct CarPrior {
  Geometry geometry;
  ParameterVector value;
  /// One standard deviation each, as a part of the value; of tyre dampers in N s/m.  0: it is known exactly.
  ParameterVector sigma;
  Eigen::MatrixXd sensors;     ///< [channel x 7] reading of each vertical channel per unit of z''
  Eigen::VectorXd gain_sigma;  ///< [channel] of their gains, 1
  double noise_m2_s4_hz;       ///< of a channel, two-sided density: the body's equations fit no better
  /// Of the struts' dry friction about 0 N, and of by how much of its mean a damper is harder in rebound.
  /// 0: there is none.
  double friction_sigma_n = 0.0, rebound_sigma = 0.0;
  /// Of a factor of what friction and rebound are beyond linear elements, in the wheels' rows.  Noise in the
  /// rates makes the road rougher by it, and less of it smoother: without the factor all of the struts'
  /// forces shrink, and with them the ratio of body to wheel masses, by 5 % in the world of `rb study
  /// real-road`.
  double strut_sigma = 0.0;
  /// Of a channel's bracket, by which it reads 1 / (1 - b f^2) of what it is meant to: b = 1 / (its
  /// resonance)^2, 1/Hz^2.
  double bracket_sigma_s2 = 0.0;
  /// Of the time from front to rear wheels, as a part of what rolling radius and wheelbase make it: tyres
  /// wear, and grow with speed.  0: it is known exactly.
  double delay_sigma = 0.0;

  /// As vehicle.toml has it.  Springs and tyres are good to 30 %, dampers and stabilisers to 50 %.
  /// @throws ConfigError as SensorMap::from
  static CarPrior of(const VehicleConfig& vehicle);
};

/// Factors of the motion's rows [3 m + n] that take a bracket's share off at that frequency: 1 - b f^2.
/// @param brackets_s2  [channel]
Eigen::ArrayXd unbracketed(const Eigen::VectorXd& brackets_s2, Eigen::Index motion, double omega);

/// A quantity of car or sensors that CarPosterior does not know exactly.
struct UncertainQuantity {
  enum class Kind { kParameter, kGain, kFriction, kRebound, kStruts, kBracket };
  Kind kind;
  Eigen::Index index;  ///< parameter, channel or wheel
};

/// A speed, and the road it was driven on.
struct SpeedOnRoad {
  const SpectralMoments* spectra;
  int road = 0;  ///< roads are numbered from 0
};

/// The posterior of a car, its sensors and the shape of the road, by the spectra of a drive, or of several.
///
/// Motion are the spectra's rows: accelerations, velocities and displacements of m channels, and
/// kStrutSignals, which enter the rows of (1) as forces of the struts, F_i tanh(v / v0) + b_i ds_i |v|.
///
/// In each bin m channels give the body's residuals e = R y, which nothing shakes but noise (three equations,
/// and m - 7 that say that the body is rigid), and the road u = U y under the four wheels, each wheel's row
/// of (1) solved for it, the rear ones advanced by wheelbase / V, which each speed knows to delay_sigma only:
///
///     u_i = z_i + F_i / c_i,   c_i = ct_i + j om dt_i.
///
/// The road is Gaussian.  W diag(phi)^-1/2 u has the covariance L_s, real and free for each speed s; phi_i(n)
/// is the shape of wheel i's side, one for each road, and W(n) = exp(t X + r Y) lets the coherence of the
/// sides (X swaps left and right) and of the axles (Y: front and rear) change.  All are free but smooth in
/// the logarithm of the wave number n = om / (2 pi V):
///
///     log phi = -(2 + a) log(n / 0.6) - log(1 + (n / 4)^2) + b(log n),    t, r = -a log(n / 0.6) + b(log n),
///
/// b piecewise linear between knots, 0 at its ends; what is constant in t and r is in L_s, and det W = 1.  e
/// is of one level in each band of 4 Hz.  With n_sk
/// independent segments in bin k, and N_s their sum,
///
///     J = sum_k n_k e^H (s^2 R R^H)^-1 e + (m - 4) n_k log s^2
///       + sum_s N_s log det L_s + sum_sk n_sk (sum_i log phi_i + log det R R^H - 2 log |det [U; R]|)
///       + 1/2 |x|^2 + 1/2 |a|^2 + 1/2 |second differences of b|^2
///
/// is what the posterior's negative logarithm is but for a constant.
///
/// Source: P. Whittle, The analysis of multiple stationary time series, J. R. Stat. Soc. B 15 (1953) 125; of
/// R R^H and the determinant: errors in variables, W. A. Fuller, Measurement Error Models, Wiley 1987, ch. 3.
class CarPosterior {
 public:
  /// @param speeds  at least one, of the same bins; they outlive this
  CarPosterior(const CarPrior& prior, std::vector<SpeedOnRoad> speeds);

  /// Unknowns: each of the car's parameters, then each gain, then friction and rebound of each strut, that is
  /// not known exactly, x in standard
  /// deviations of its prior (value e^(sigma x), of tyre dampers value + sigma x); then for each road of the
  /// shape of the left side, of the right one, and of the mixing of sides and of axles, a and b at its inner
  /// knots; then each speed's delay, if it is not known exactly.
  Eigen::Index size() const { return size_; }
  ParameterVector parameters(const Eigen::VectorXd& v) const;
  Eigen::VectorXd gains(const Eigen::VectorXd& v) const;
  /// Place of a parameter of the car among the unknowns; -1: it is known exactly.
  Eigen::Index place(int parameter) const { return place_.at(static_cast<std::size_t>(parameter)); }

  /// [unknown of car and sensors]
  std::vector<UncertainQuantity> quantities() const;
  Eigen::Vector4d friction_n(const Eigen::VectorXd& v) const;
  Eigen::Vector4d rebound(const Eigen::VectorXd& v) const;      ///< share that a damper has more in rebound
  Eigen::VectorXd brackets_s2(const Eigen::VectorXd& v) const;  ///< [channel] b
  Eigen::Index first_bracket() const { return bracket_; }       ///< of the unknowns; -1: there is none
  double strut_factor(const Eigen::VectorXd& v) const;  ///< of their non-linear rest, in the wheels' rows
  /// Rows of (1) of the four wheels, tyres included, on accelerations, velocities and displacements of the
  /// channels and the struts' signals [4 x motion]: what they leave is the unbalances' force and ct_i + j om
  /// dt_i times the road.  On motion of which the brackets' share is taken off (unbracketed).
  Eigen::MatrixXd wheel_forces(const Eigen::VectorXd& v) const;
  /// Unknowns of the car and its sensors; those of the road's curves follow.
  Eigen::Index known() const { return known_; }
  Eigen::Index channels() const { return channels_; }
  /// By which share of it the time from front to rear wheels is longer at a speed.
  /// @param speed  place among those of construction
  double delay_share(const Eigen::VectorXd& v, Eigen::Index speed) const;
  const CarPrior& prior() const { return prior_; }

  /// Takes what the struts' signals do for linear elements of the road that the equations of a place show.
  ///
  /// A signal s of a strut's rate r is c r and a rest that the road does not make, c = a + j om b by least
  /// squares over the road's bins with the road u as instrument: c = S_su S_uu^-1 S_ur / (S_ru S_uu^-1 S_ur).
  /// The regression on the rate itself is too small, by half at 40 Hz: friction's rest moves the wheel as
  /// well, against it.  Of what is linear the determinants in J are made; until this is called, of that
  /// regression.
  ///
  /// Source: R. Pintelon, J. Schoukens, System Identification, 2nd ed., Wiley 2012, ch. 3 (best linear
  /// approximation of a system in feedback).
  void linearise_struts(const Eigen::VectorXd& v);

  /// J; infinite where the car cannot be.
  double value(const Eigen::VectorXd& v) const;
  /// J with its gradient.
  double value(const Eigen::VectorXd& v, Eigen::VectorXd& gradient) const;
  /// Expected second derivatives of J, from the signal alone: noise in it would give masses false curvature.
  Eigen::MatrixXd information(const Eigen::VectorXd& v) const;

 private:
  struct Equations;
  struct Bin;
  struct System;
  struct Band;
  struct Roads;
  struct Slopes;
  void linearise_struts_by_rates();
  void scale_strut_rests(Eigen::MatrixXd& rows, double factor) const;
  Eigen::MatrixXd strut_columns(const Eigen::Vector4d& force) const;
  Eigen::MatrixXcd integrals(double omega) const;
  Equations equations(const Eigen::VectorXd& v) const;
  Eigen::MatrixXd equations_by(const Eigen::VectorXd& v, const Equations& of, Eigen::Index unknown) const;
  System system(const Eigen::VectorXd& v) const;
  Eigen::MatrixXd rows_at(const System& of, const std::vector<Eigen::MatrixXd>& rows_by, Eigen::Index unknown,
                          Eigen::Index bin) const;
  Eigen::MatrixXd curves(const Eigen::VectorXd& v, const SpeedOnRoad& speed) const;
  std::vector<Eigen::ArrayXd> curve_by(const SpectralMoments& speed) const;
  std::vector<Band> bands(const System& of) const;
  Roads roads(const System& of, const Eigen::VectorXd& v, const SpeedOnRoad& speed) const;

  double evaluate(const Eigen::VectorXd& v, Eigen::VectorXd* gradient) const;
  double body_value(const System& of, Slopes* slopes) const;
  double road_value(const System& of, const Eigen::VectorXd& v, const SpeedOnRoad& speed, Slopes* slopes,
                    Eigen::VectorXd* gradient) const;
  void add_road_slopes(const System& of, const SpeedOnRoad& speed, const Roads& roads, Slopes& slopes,
                       Eigen::VectorXd& gradient) const;
  void add_slopes(const System& of, const Eigen::VectorXd& v, const Slopes& slopes,
                  Eigen::VectorXd& gradient) const;
  double prior_value(const Eigen::VectorXd& v, Eigen::VectorXd* gradient) const;
  std::complex<double> stiffness_step(const Equations& of, int parameter, double omega) const;
  Eigen::MatrixXcd road_by(const System& of, Eigen::Index bin, const Eigen::MatrixXd& rows,
                           Eigen::Index unknown) const;
  void add_body_information(const System& of, const std::vector<Eigen::MatrixXd>& rows_by,
                            Eigen::MatrixXd& information) const;
  void add_road_information(const System& of, const Eigen::VectorXd& v, const SpeedOnRoad& speed,
                            const std::vector<Eigen::MatrixXd>& rows_by, Eigen::MatrixXd& information) const;
  void add_prior_information(Eigen::MatrixXd& information) const;
  bool is_of_body(Eigen::Index bin) const;
  bool is_of_road(Eigen::Index bin) const;
  double omega(Eigen::Index bin) const { return speeds_.front().spectra->omega(bin); }
  Eigen::Index curves_of(int road) const;
  Eigen::Index delay_of(Eigen::Index speed) const;
  Eigen::Index index_of(const SpeedOnRoad& speed) const { return &speed - speeds_.data(); }

  CarPrior prior_;
  std::vector<SpeedOnRoad> speeds_;
  int roads_ = 0;
  std::vector<Eigen::MatrixXcd> same_;  ///< of all speeds, in the bins of the body
  Eigen::ArrayXd count_;                ///< of all speeds
  Eigen::Index channels_, motion_, bins_, residuals_, known_, size_;
  Eigen::Index friction_ = -1, rebound_ = -1, strut_ = -1,
               bracket_ = -1;  ///< first of them among the unknowns; -1: there is none
  Eigen::Matrix<double, kWheels, kCoordinates> stretch_;
  /// Of the struts' signals by their rates: a and b of linearise_struts.
  Eigen::Matrix<double, kStrutSignals, kWheels> linear_, leading_;
  std::vector<int> parameter_;         ///< of the car that are unknown
  std::vector<Eigen::Index> channel_;  ///< whose gains are
  std::array<Eigen::Index, kParameters> place_;
  std::array<LinearModel, kParameters> unit_;  ///< the model's matrices of each parameter
  Eigen::MatrixXd coordinates_;                ///< [7 x channel] least squares
  Eigen::MatrixXd rigid_;                      ///< [channel - 7 x channel] what a rigid body leaves 0
  Eigen::Vector3d scale_;                      ///< of the body's equations
};

/// The most probable car.
struct PosteriorMode {
  Eigen::VectorXd v;
  Eigen::MatrixXd covariance;
  double value = 0.0;
  int steps = 0;
  bool converged = false;
};

/// Searched by Fisher scoring from `start`, steps halved until J falls.
/// @param enough  twice what J gains by the last step: by default that of a tenth of a standard deviation
PosteriorMode posterior_mode(const CarPosterior& posterior, const Eigen::VectorXd& start,
                             double enough = 1e-2);

}  // namespace roadbalance
