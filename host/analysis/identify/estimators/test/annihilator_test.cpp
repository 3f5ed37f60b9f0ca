#include "host/analysis/identify/estimators/annihilator.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <stdexcept>

namespace roadbalance {
namespace {

/// Distance of the spaces that the rows span: largest part of a unit row of A that B does not hold.
double distance(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  const auto basis = [](const Eigen::MatrixXd& rows) -> Eigen::MatrixXd {
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(rows.transpose());
    return qr.householderQ() * Eigen::MatrixXd::Identity(rows.cols(), rows.rows());
  };
  const Eigen::MatrixXd a = basis(A), b = basis(B);
  return (a - b * (b.transpose() * a)).colwise().norm().maxCoeff();
}

TEST(Annihilator, NumericAndClosedFormSpanTheSameSpace) {
  for (const int order : {3, 4, 5, 8, 12})
    for (const double cutoff_hz : {15.0, 30.0, 100.0}) {
      const ContinuousFilter filter = butterworth(order, cutoff_hz);
      const Annihilator numeric = annihilator(filter), closed = companion_annihilator(filter);
      ASSERT_EQ(numeric.instruments(), order - 2);
      EXPECT_LT(distance(closed.w2, numeric.w2), 1e-12) << order << " at " << cutoff_hz;
      EXPECT_LT(distance(numeric.w2, closed.w2), 1e-12) << order << " at " << cutoff_hz;
    }
}

/// A filter that is nothing like a companion form.
TEST(Annihilator, AnnihilatesForAnyRegularFilter) {
  ContinuousFilter filter{Eigen::MatrixXd::Zero(4, 4), Eigen::VectorXd(4)};
  filter.F << -30, 80, 0, 5, -80, -20, 7, 0, 0, 3, -50, 120, 2, 0, -110, -60;
  filter.G << 3, -20, 11, 40;
  const Annihilator H = annihilator(filter);
  ASSERT_EQ(H.instruments(), 2);
  const Eigen::MatrixXd inverse = filter.F.inverse();
  EXPECT_LT((H.w2 * H.w2.transpose() - Eigen::Matrix2d::Identity()).norm(), 1e-12);
  EXPECT_LT((H.w2 * inverse * filter.G).norm(), 1e-13 * (inverse * filter.G).norm());
  EXPECT_LT((H.w2 * inverse * inverse * filter.G).norm(), 1e-13 * (inverse * inverse * filter.G).norm());
  EXPECT_LT((H.w1 * filter.F - H.w2).norm(), 1e-12);
  EXPECT_LT((H.w0 * filter.F - H.w1).norm(), 1e-12 * H.w1.norm());
}

TEST(Annihilator, ClosedFormIsMadeOfTheSameProducts) {
  const ContinuousFilter filter = butterworth(5, 30.0);
  const Annihilator H = companion_annihilator(filter);
  EXPECT_LT((H.w1 * filter.F - H.w2).norm(), 1e-14);
  EXPECT_LT((H.w0 * filter.F - H.w1).norm(), 1e-14 * H.w1.norm());
}

TEST(Annihilator, RefusesAFilterOfTwoStates) {
  EXPECT_THROW(annihilator(butterworth(2, 30.0)), std::invalid_argument);
  EXPECT_THROW(companion_annihilator(butterworth(2, 30.0)), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
