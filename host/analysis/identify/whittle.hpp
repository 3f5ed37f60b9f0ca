#pragma once

#include <array>
#include <bitset>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/whittle_moments.hpp"

namespace roadbalance {

/// Tyre stiffness by the likelihood of the road that it leaves.
struct WhittleTyres {
  Eigen::Vector4d tyre_n_m;    ///< as known where it was not free
  Eigen::Matrix4d covariance;  ///< of the free ones; suspension taken for exact
  double exponent = 2.0;       ///< of the road: spectrum of its height ~ om^-exponent
  double exponent_sigma = 0.0;
};

/// Each wheel's row of relation (1) gives the road under it from the measured accelerations,
///
///     u_i(om) = z_i + F_i / c_i,    c_i = ct_i + j om dt_i,    z = -Z''/om^2,
///
/// F_i the force that the row leaves without its tyre.  The four roads, the rear ones advanced by
/// wheelbase / V, v = [u_FL, u_FR, e^{j om L/V} u_RL, e^{j om L/V} u_RR], are Gaussian with the spectral
/// matrix
///
///     E[v v^H] = phi(om) L_s,    phi = om^-w / (1 + (om / (w2 V))^2),
///
/// w the road's exponent, one for all wheels and speeds, L_s real and free for each speed s, and the contact
/// patch's corner w2 = 2 pi 4 1/m.  Minimised over ct and w, with n_sk the independent segments in bin k and
/// N_s their sum over the bins,
///
///     sum_s N_s log det L_s + sum_sk n_sk (4 log phi_k + 2 log |det Gu(om_k)|),
///     L_s = Re sum_k V_sk / (phi_k N_s),    |det Gu| = prod |c_i| |det D_cc| / |det D|
///
/// (V_sk the sum of v v^H, D = Q + j om P - om^2 M, D_cc its body block; factors that no unknown is in are
/// left out).  det L_s is the product of one wheel's level and those of the others given it, so every wheel
/// is conditioned on its partner of the other axle: none takes the road that both share for its own, and what
/// is shared determines both stiffnesses against one another.
///
/// Searched by Fisher scoring; with S_a the change of E[v v^H] / phi by unknown a, the information is
///
///     I_ab = sum_s [sum_k n_sk tr(L_s^-1 S_a L_s^-1 S_b) - N_s tr(L_s^-1 S'_a L_s^-1 S'_b)],
///
/// S' = Re of the mean of S over the bins: what could as well be a change of L_s is taken off.  Stiffnesses
/// stay within 30 % of where the search begins.
///
/// Source: P. Whittle, The analysis of multiple stationary time series, J. R. Stat. Soc. B 15 (1953) 125.
///
/// @param speeds      moments of each speed
/// @param parameters  the car's; tyres are where the search begins
/// @param free        wheels whose tyre is unknown
/// Returns nothing if the moments do not determine them, or the search ran into its bounds.
std::optional<WhittleTyres> whittle_tyres(std::span<const WhittleMoments* const> speeds,
                                          const Geometry& geometry, const ParameterVector& parameters,
                                          const std::bitset<kWheels>& free);

}  // namespace roadbalance
