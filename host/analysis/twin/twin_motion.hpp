#pragma once

#include <array>

#include "common/dsp/motion_filter.hpp"
#include "host/analysis/twin/twin_car.hpp"

namespace roadbalance {

/// The car's equations of motion, differentiated twice so that only accelerations occur.  With D = M s^2 + P
/// s
/// + Q of linear_model, b the body's three coordinates, a the wheels', F the vertical forces of unbalance:
///
///     D_bb b'' + D_bw a = 0                                  no road acts on the body
///     D_wb b'' + D_ww a = S u'' + s^2 F                      u the road under the wheels
///
/// Body from the accelerations of the four carriers, [heave'', roll'', pitch'']: 6 states, no road, no speed.
/// Inputs: the wheels' z'' [4].
MotionEquation body_motion(const LinearModel& model);

/// Inputs of axle_motion.  "Then": at the instant at which the other axle stood, or will stand, where this
/// one stands now, of each side its own.
enum AxleInput : int {
  kOtherNow = 0,        ///< z'' of the other axle's wheels, left and right
  kWheelsThen = 2,      ///< z'' of all four wheels
  kOtherForceThen = 6,  ///< F of the other axle's wheels, N
  kForceNow = 8,        ///< F of this axle's wheels, N
  kAxleInputs = 10,
};
/// First of its outputs z'' of this axle's wheels; before them are the body then [3] and the body now [3].
inline constexpr int kAxleWheels = 2 * kBodyCoordinates;

/// The wheels p of one axle from those q of the other, with no sensor of p's but as the road then was known
/// (through the body, on which they act):
///
///     D_bb b_then = -D_bw a_then
///     D_bb b + D_bp a_p = -D_bq a_q
///     D_pb b + D_pp a_p = R (D_qb b_then + D_qw a_then - s^2 F_q,then) + s^2 F_p - D_pq a_q,   R = S_p / S_q
///
/// Everything is proper: mass on both sides.  16 states.  Tyres with damping are in D; R is S_p / S_q then,
/// too, exact where damping and stiffness of front and rear tyres have one ratio.
///
/// @param axle  that is predicted, 0 front, 1 rear
MotionEquation axle_motion(const LinearModel& model, int axle);

}  // namespace roadbalance
