#include "host/analysis/identify/estimators/relation_covariances.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/dsp/state_filter.hpp"
#include "common/dsp/taper.hpp"

namespace roadbalance {
namespace {

constexpr double kSettled = 1e-6;  ///< what is left of the filter's start where averages begin

/// Rows of kRelationSignals: what is filtered; references of wheels without one are 0.
Eigen::MatrixXd filtered_signals(const Stretch& stretch) {
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(kRelationSignals, stretch.signals.cols());
  x.topRows<kSignals>() = stretch.signals;
  for (int i = 0; i < kWheels; ++i)
    if (!(stretch.omega(i) > 0.0)) x.middleRows<2>(cosine_row(i)).setZero();
  if (stretch.road_m.cols() > 0) x.bottomRows<kWheels>() = stretch.road_m;
  return x;
}

double settling_s(const ContinuousFilter& filter) {
  const double slowest =
      -Eigen::EigenSolver<Eigen::MatrixXd>(filter.F, false).eigenvalues().real().maxCoeff();
  return -std::log(kSettled) / slowest;
}

/// A window that is 1 all along: plain averages.
Taper no_taper(Eigen::Index samples) {
  return {Eigen::ArrayXd::Ones(samples), Eigen::ArrayXd::Zero(samples), Eigen::ArrayXd::Zero(samples)};
}

/// All instruments of a part, [instrument x sample].
struct LaggedInstruments {
  Eigen::MatrixXd w2, w1, w0;
};
LaggedInstruments instruments(const std::vector<Eigen::MatrixXd>& y, const Annihilator& H,
                              const Taper& taper) {
  const Eigen::Index samples = y.front().cols(), signals = y.front().rows();
  const auto h = taper.value.matrix().asDiagonal();
  const auto h1 = taper.first.matrix().asDiagonal();
  const auto h2 = taper.second.matrix().asDiagonal();
  LaggedInstruments all;
  all.w2.resize(H.instruments() * signals, samples);
  all.w1.resizeLike(all.w2);
  all.w0.resizeLike(all.w2);
  for (Eigen::Index j = 0; j < H.instruments(); ++j) {
    const auto rows = [&](const Eigen::MatrixXd& of) {
      Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(signals, samples);
      for (std::size_t k = 0; k < y.size(); ++k)
        if (const double weight = of(j, static_cast<Eigen::Index>(k)); weight != 0.0) sum += weight * y[k];
      return sum;
    };
    const Eigen::MatrixXd w2 = rows(H.w2), w1 = rows(H.w1), w0 = rows(H.w0);
    all.w2.middleRows(j * signals, signals) = w2 * h + 2.0 * w1 * h1 + w0 * h2;
    all.w1.middleRows(j * signals, signals) = w1 * h + w0 * h1;
    all.w0.middleRows(j * signals, signals) = w0 * h;
  }
  return all;
}

}  // namespace

RelationCovariances& RelationCovariances::operator+=(const RelationCovariances& other) {
  if (lag.empty()) return *this = other;
  seconds += other.seconds;
  metres += other.metres;
  turned_rad += other.turned_rad;
  power += other.power;
  for (std::size_t k = 0; k < lag.size(); ++k) {
    lag[k].w2_z += other.lag[k].w2_z;
    lag[k].w1_z += other.lag[k].w1_z;
    lag[k].w0_z += other.lag[k].w0_z;
    lag[k].w2_d += other.lag[k].w2_d;
    lag[k].w2_u += other.lag[k].w2_u;
  }
  return *this;
}

RelationFilter::RelationFilter(Options options)
    : options_(std::move(options)),
      filter_(butterworth(options_.order, options_.cutoff_hz)),
      H_(companion_annihilator(filter_)) {}

void RelationFilter::parts(const Stretch& stretch, const Emit& emit) const {
  const double step_s = 1.0 / stretch.rate_hz;
  const Eigen::MatrixXd x = filtered_signals(stretch);
  Eigen::MatrixXd forces = x.middleRows<2 * kWheels>(kCoordinates);  // per unit of unbalance
  for (int i = 0; i < kWheels; ++i) forces.middleRows<2>(2 * i) *= stretch.omega(i) * stretch.omega(i);
  std::vector<Eigen::Index> shift;
  for (const double lag_s : options_.lags_s) shift.push_back(std::lround(lag_s * stretch.rate_hz));
  const auto [least, most] = std::minmax_element(shift.begin(), shift.end());

  // A window makes the filter's start an instrument as good as any; averages have to wait for its end.
  const auto settling = options_.windowed ? 0 : std::lround(settling_s(filter_) * stretch.rate_hz);
  const Eigen::Index first = std::max<Eigen::Index>(settling, -std::min<Eigen::Index>(0, *least));
  const Eigen::Index usable = x.cols() - std::max<Eigen::Index>(0, *most) - first;
  const auto count = std::max<Eigen::Index>(
      1, static_cast<Eigen::Index>(static_cast<double>(usable) * step_s / options_.part_s));
  const Eigen::Index samples = usable / count;
  if (samples < 2) return;
  const Taper taper =
      options_.windowed ? c2_taper(samples, options_.taper_fraction, step_s) : no_taper(samples);

  StateFilter filter(discretise_ramp_invariant(filter_, step_s), kRelationSignals);
  for (Eigen::Index t = 0; t < first; ++t) filter.update(x.col(t).array());
  std::vector<Eigen::MatrixXd> y(static_cast<std::size_t>(options_.order),
                                 Eigen::MatrixXd(kRelationSignals, samples));
  for (Eigen::Index part = 0; part < count; ++part) {
    const Eigen::Index from = first + part * samples;
    for (Eigen::Index t = 0; t < samples; ++t) {
      const auto& states = filter.update(x.col(from + t).array());
      for (std::size_t k = 0; k < y.size(); ++k) y[k].col(t) = states.col(static_cast<Eigen::Index>(k));
    }
    const LaggedInstruments w = instruments(y, H_, taper);
    RelationCovariances sum;
    sum.seconds = static_cast<double>(samples) * step_s;
    sum.metres = sum.seconds * stretch.speed_m_s;
    sum.turned_rad = sum.seconds * stretch.omega;
    sum.power = step_s * w.w2.rowwise().squaredNorm();
    for (const Eigen::Index tau : shift) {
      const auto later = [&](const auto& rows) { return rows.middleCols(from + tau, samples).transpose(); };
      const Eigen::MatrixXd z = step_s * later(x.topRows<kCoordinates>());
      sum.lag.push_back({w.w2 * z, w.w1 * z, w.w0 * z, step_s * (w.w2 * later(forces)),
                         step_s * (w.w2 * later(x.bottomRows<kWheels>()))});
    }
    emit(stretch.speed_m_s, sum);
  }
}

}  // namespace roadbalance
