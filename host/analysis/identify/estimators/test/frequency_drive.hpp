#pragma once

#include <complex>
#include <numbers>
#include <vector>

#include <Eigen/LU>

#include "host/analysis/identify/estimators/relation_covariances.hpp"
#include "host/analysis/identify/signals.hpp"
#include "host/analysis/identify/test/reference_car.hpp"
#include "tools/study/cramer_rao.hpp"

namespace roadbalance::test {

/// Result of RelationFilter after infinitely long driving of the reference car over roads that its wheels
/// share: midpoint sums over frequency of response times the roads' spectral matrix, the filter by its poles.
inline RelationCovariances frequency_covariances(double speed_m_s, const RoadStatistics& road,
                                                 const RelationFilter::Options& filter) {
  using Complex = std::complex<double>;
  using std::numbers::pi;
  constexpr double kGrid_hz = 0.1, kMost_hz = 1000.0;
  const LinearModel model = linear_model(kReferenceGeometry, reference_car());
  const double wc = 2.0 * pi * filter.cutoff_hz;
  const int states = filter.order - 2;
  const auto instruments = [&](double om) {  // w''_j
    const Complex p = kJ * om / wc;
    Complex D = 1.0;
    for (int k = 0; k < filter.order; ++k)
      D *= p - std::polar(1.0, pi * (2.0 * k + filter.order + 1.0) / (2.0 * filter.order));
    Eigen::VectorXcd h(states);
    for (int j = 0; j < states; ++j) h(j) = std::pow(p, j + 2) / D;
    return h;
  };
  const auto response = [&](double om, const auto& force) {
    const Eigen::Matrix<Complex, kCoordinates, kCoordinates> D =
        model.Q.cast<Complex>() + kJ * om * model.P.cast<Complex>() - (om * om * model.M).cast<Complex>();
    return (-om * om * D.partialPivLu().solve(force)).eval();
  };

  RelationCovariances sums;
  sums.seconds = 1.0;
  sums.metres = speed_m_s;
  const Eigen::Index rows = states * kRelationSignals;
  sums.power = Eigen::VectorXd::Zero(rows);
  const LaggedCovariances none{
      Eigen::MatrixXd::Zero(rows, kCoordinates), Eigen::MatrixXd::Zero(rows, kCoordinates),
      Eigen::MatrixXd::Zero(rows, kCoordinates), Eigen::MatrixXd::Zero(rows, 2 * kWheels),
      Eigen::MatrixXd::Zero(rows, kWheels)};
  sums.lag.assign(filter.lags_s.size(), none);
  // Adds an instrument's covariances with z'' and others, cross [signal x what is measured] of the inputs.
  const auto add = [&](double om, double weight, const Eigen::MatrixXcd& with_z,
                       const Eigen::MatrixXcd& with_d, const Eigen::MatrixXcd& with_u,
                       const Eigen::VectorXd& power) {
    const Eigen::VectorXcd h = instruments(om);
    for (int j = 0; j < states; ++j) {
      const Eigen::Index first = j * kRelationSignals;
      sums.power.segment<kRelationSignals>(first) += weight * std::norm(h(j)) * power;
      for (std::size_t l = 0; l < sums.lag.size(); ++l) {
        const Complex w2 = weight * std::conj(h(j)) * std::polar(1.0, om * filter.lags_s[l]);
        const Complex w1 = w2 / (-kJ * om), w0 = -w2 / (om * om);
        LaggedCovariances& c = sums.lag[l];
        c.w2_z.middleRows<kRelationSignals>(first) += (w2 * with_z).real();
        c.w1_z.middleRows<kRelationSignals>(first) += (w1 * with_z).real();
        c.w0_z.middleRows<kRelationSignals>(first) += (w0 * with_z).real();
        c.w2_d.middleRows<kRelationSignals>(first) += (w2 * with_d).real();
        c.w2_u.middleRows<kRelationSignals>(first) += (w2 * with_u).real();
      }
    }
  };
  for (double f = 0.5 * kGrid_hz; f < kMost_hz; f += kGrid_hz) {
    const double om = 2.0 * pi * f;
    const Eigen::MatrixXcd z = response(om, (model.S + Complex(0.0, om) * model.Sd).eval());
    Eigen::MatrixXcd signals = Eigen::MatrixXcd::Zero(kRelationSignals, kWheels);
    signals.topRows<kCoordinates>() = z;
    signals.bottomRows<kWheels>().setIdentity();
    const Eigen::MatrixXcd roads =
        signals.conjugate() * road.coherence(kReferenceGeometry, om, speed_m_s).conjugate();
    add(om, 2.0 * kGrid_hz * road.density(om, speed_m_s), roads * z.transpose(),
        Eigen::MatrixXcd::Zero(kRelationSignals, 2 * kWheels), roads,
        (roads * signals.transpose()).diagonal().real());
  }
  for (int i = 0; i < kWheels; ++i) {
    const double om = speed_m_s / 0.30 * (1.0 + 0.003 * i);  // no two wheels in step
    sums.turned_rad(i) = om;
    Eigen::VectorXcd signals = Eigen::VectorXcd::Zero(kRelationSignals);
    signals.head<kCoordinates>() =
        response(om, (model.W.col(i) * kReferenceUnbalance[static_cast<std::size_t>(i)] * om * om).eval());
    signals(cosine_row(i)) = 1.0;
    signals(sine_row(i)) = -kJ;
    Eigen::RowVectorXcd d = Eigen::RowVectorXcd::Zero(2 * kWheels);
    d(2 * i) = om * om;
    d(2 * i + 1) = -kJ * om * om;
    add(om, 0.5, signals.conjugate() * signals.head<kCoordinates>().transpose(), signals.conjugate() * d,
        Eigen::MatrixXcd::Zero(kRelationSignals, kWheels), signals.cwiseAbs2());
  }
  return sums;
}

}  // namespace roadbalance::test
