#include "host/analysis/twin/twin_motion.hpp"

namespace roadbalance {
namespace {

constexpr int kB = kBodyCoordinates;

/// The polynomials of D = M s^2 + P s + Q side by side, and those of an equation's left and right.
struct Terms {
  const Matrix7* of_model;
  Eigen::MatrixXd* left;
  Eigen::MatrixXd* right;
};

std::array<Terms, 3> terms(const LinearModel& model, MotionEquation& e) {
  return {{{&model.M, &e.M, &e.B2}, {&model.P, &e.P, &e.B1}, {&model.Q, &e.Q, &e.B0}}};
}

}  // namespace

MotionEquation body_motion(const LinearModel& model) {
  MotionEquation e = MotionEquation::zero(kB, kWheels);
  for (const Terms& t : terms(model, e)) {
    *t.left = t.of_model->topLeftCorner<kB, kB>();
    *t.right = -t.of_model->topRightCorner<kB, kWheels>();
  }
  return e;
}

MotionEquation axle_motion(const LinearModel& model, int axle) {
  const int p = kB + 2 * axle, q = kB + 2 * (1 - axle);
  constexpr int now = kB, own = kAxleWheels;  // rows after those of the body then
  const Eigen::Array2d ratio(model.S(p, p - kB) / model.S(q, q - kB),
                             model.S(p + 1, p + 1 - kB) / model.S(q + 1, q + 1 - kB));
  const Eigen::Matrix2d R = ratio.matrix().asDiagonal();
  MotionEquation e = MotionEquation::zero(own + 2, kAxleInputs);
  for (const Terms& t : terms(model, e)) {
    const Matrix7& D = *t.of_model;
    Eigen::MatrixXd& left = *t.left;
    Eigen::MatrixXd& right = *t.right;
    left.topLeftCorner<kB, kB>() = D.topLeftCorner<kB, kB>();
    right.block<kB, kWheels>(0, kWheelsThen) = -D.topRightCorner<kB, kWheels>();

    left.block<kB, kB>(now, now) = D.topLeftCorner<kB, kB>();
    left.block<kB, 2>(now, own) = D.block<kB, 2>(0, p);
    right.block<kB, 2>(now, kOtherNow) = -D.block<kB, 2>(0, q);

    left.block<2, kB>(own, 0) = -R * D.block<2, kB>(q, 0);
    left.block<2, kB>(own, now) = D.block<2, kB>(p, 0);
    left.block<2, 2>(own, own) = D.block<2, 2>(p, p);
    right.block<2, kWheels>(own, kWheelsThen) = R * D.block<2, kWheels>(q, kB);
    right.block<2, 2>(own, kOtherNow) = -D.block<2, 2>(p, q);
  }
  e.B2.block<2, 2>(own, kOtherForceThen) = -R;
  e.B2.block<2, 2>(own, kForceNow).setIdentity();
  return e;
}

}  // namespace roadbalance
