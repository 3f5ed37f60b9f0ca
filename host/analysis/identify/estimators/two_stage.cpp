#include "host/analysis/identify/estimators/two_stage.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <utility>

#include "host/analysis/identify/first_order.hpp"
#include "host/analysis/identify/unbalances.hpp"
#include "host/analysis/identify/whittle.hpp"

namespace roadbalance {
namespace {

constexpr double kSectionS = 10.0;
constexpr double kParameterDifference = 1e-3;  ///< of a parameter

/// Length of the equal sections that fill a stretch.
Eigen::Index section_samples(const Stretch& stretch) {
  const Eigen::Index room = stretch.signals.cols() - SectionBuffer::lag(stretch.rate_hz);
  const auto wanted = static_cast<Eigen::Index>(std::lround(kSectionS * stretch.rate_hz));
  const Eigen::Index overlap = SectionBuffer::overlap(stretch.rate_hz, std::min(wanted, room));
  const auto sections = static_cast<Eigen::Index>(
      std::lround(static_cast<double>(room - overlap) / static_cast<double>(wanted - overlap)));
  return (room - overlap) / std::max<Eigen::Index>(1, sections) + overlap;
}

DriveMoments total(const BySpeed<SectionMoments>& drive) {
  DriveMoments sum;
  for (const auto& [speed, moments] : drive.at) sum += moments.drive;
  return sum;
}

/// [Re, Im of each wheel] from circular complex numbers.
Eigen::Matrix<double, 2 * kWheels, 2 * kWheels> by_axes(const Eigen::Matrix4cd& covariance) {
  Eigen::Matrix<double, 2 * kWheels, 2 * kWheels> axes;
  for (int i = 0; i < kWheels; ++i)
    for (int j = 0; j < kWheels; ++j) {
      const std::complex<double> c = covariance(i, j) / 2.0;
      axes.block<2, 2>(2 * i, 2 * j) << c.real(), -c.imag(), c.imag(), c.real();
    }
  return axes;
}

}  // namespace

void TwoStage::add(const Stretch& stretch) {
  const Eigen::Index samples = section_samples(stretch);
  if (!buffer_ || buffer_->section().cols() != samples)
    buffer_.emplace(question_.geometry, stretch.rate_hz, samples);
  if (!road_) road_.emplace(question_.geometry, stretch.rate_hz);
  RoadSpectrum road;
  std::vector<std::pair<SectionMoments, SectionLines>> sections;
  buffer_->reset();
  for (Eigen::Index k = 0; k < stretch.signals.cols(); ++k) {
    buffer_->push(stretch.signals.col(k));
    if (!buffer_->full()) continue;
    const HarmonicReading reading = buffer_->harmonic(samples, stretch.omega, stretch.speed_m_s);
    road += reading.road;
    sections.push_back({{buffer_->moments(samples, stretch.omega, stretch.speed_m_s),
                         buffer_->seconds(samples) * stretch.omega},
                        reading.lines});
    buffer_->keep(buffer_->shared());
  }
  for (auto& [section, lines] : sections) {
    section.drive.harmonic =
        harmonic_moments(lines, question_.geometry, question_.known, road, options_.share);
    sections_.add(stretch.speed_m_s, section);
  }
  if (options_.tyre == TyreFrom::kWhittle)
    roads_.at[BySpeed<WhittleMoments>::key(stretch.speed_m_s)] +=
        road_->moments(stretch.signals, stretch.omega, stretch.speed_m_s);
}

EstimatorAnswer TwoStage::solve() const {
  if (options_.tyre == TyreFrom::kInstrument)
    return sections_.solve(question_, [this](const Drive& drive) {
      return roadbalance::solve(total(drive), question_.geometry, question_.known, question_.asked);
    });
  const Drive drive = sections_.all();
  const auto parameters = with_suspension(total(drive));
  auto solution = parameters ? solve_wheels(drive, *parameters) : std::nullopt;
  if (!solution) return judged(question_, std::nullopt, std::nullopt);
  if (question_.asks_for_suspension()) add_variance_of_suspension(drive, *parameters, *solution);
  std::vector<std::string> sentences;
  if (options_.separate_force) sentences = separate_forces(drive, *solution);
  EstimatorAnswer answer = judged(question_, solution->x, solution->covariance);
  answer.diagnostics.insert(answer.diagnostics.end(), sentences.begin(), sentences.end());
  return answer;
}

std::optional<ParameterVector> TwoStage::with_suspension(const DriveMoments& drive) const {
  ParameterVector parameters = question_.known;
  if (!question_.asks_for_suspension()) return parameters;
  const auto suspension = solve_suspension(drive, question_.geometry, question_.known);
  if (!suspension) return std::nullopt;
  for (int i = 0; i < kEstimatedTyre; ++i)
    if (question_.asked[static_cast<std::size_t>(i)]) parameters(kSpring + i) = (*suspension)(i);
  return parameters;
}

std::optional<TwoStage::Solution> TwoStage::solve_wheels(const Drive& drive,
                                                         const ParameterVector& parameters) const {
  WhittleTyres tyres{parameters.segment<kWheels>(kTyre), Eigen::Matrix4d::Zero()};
  std::bitset<kWheels> free;
  for (int i = 0; i < kWheels; ++i) free[static_cast<std::size_t>(i)] = question_.asks_for_tyre(i);
  if (options_.tyre == TyreFrom::kWhittle && free.any()) {
    std::vector<const WhittleMoments*> speeds;
    for (const auto& [speed, moments] : roads_.at) speeds.push_back(&moments);
    const auto found = whittle_tyres(speeds, question_.geometry, parameters, free);
    if (!found) return std::nullopt;
    tyres = *found;
  }
  ParameterVector without_tyres = parameters;
  without_tyres.segment<kWheels>(kTyre).setZero();
  const Unbalances unbalances = solve_unbalances(total(drive).harmonic, question_.geometry, without_tyres,
                                                 wheels_asked_for_unbalance(question_.asked));

  Solution solution;
  solution.x.head<kEstimatedUnbalance>() = parameters.segment<kEstimatedUnbalance>(kSpring);
  solution.x.segment<kWheels>(kEstimatedTyre) = tyres.tyre_n_m;
  put_unbalances(unbalances.at(tyres.tyre_n_m), unbalances.found, question_.asked, solution.x);

  Eigen::Matrix<double, 3 * kWheels, kWheels> slope;  // of tyres and unbalances by the tyres
  slope.topRows<kWheels>().setIdentity();
  for (int i = 0; i < kWheels; ++i) {
    slope.row(kWheels + 2 * i) = unbalances.per_tyre.row(i).real();
    slope.row(kWheels + 2 * i + 1) = unbalances.per_tyre.row(i).imag();
  }
  solution.covariance.setZero();
  solution.covariance.bottomRightCorner<3 * kWheels, 3 * kWheels>() =
      slope * tyres.covariance * slope.transpose();
  solution.covariance.bottomRightCorner<2 * kWheels, 2 * kWheels>() += by_axes(unbalances.covariance);
  return solution;
}

std::vector<std::string> TwoStage::separate_forces(const Drive& drive, Solution& solution) const {
  ParameterVector parameters = question_.known;
  parameters.segment<kEstimatedUnbalance>(kSpring) = solution.x.head<kEstimatedUnbalance>();
  std::array<std::vector<FirstOrderForce>, kWheels> forces;
  for (const auto& [speed, moments] : drive.at) {
    const auto at_speed = first_order_forces(moments.drive.harmonic, question_.geometry, parameters,
                                             moments.turned_rad / moments.drive.seconds,
                                             wheels_asked_for_unbalance(question_.asked));
    for (std::size_t i = 0; i < kWheels; ++i)
      if (at_speed[i].variance_n2 > 0.0) forces[i].push_back(at_speed[i]);
  }
  std::vector<std::string> sentences;
  std::string not_separable;
  for (std::size_t i = 0; i < kWheels; ++i) {
    if (forces[i].empty()) continue;
    const FirstOrderFit fit = fit_first_order(forces[i]);
    if (!fit.separable) {
      not_separable += (not_separable.empty() ? "" : ", ") + std::string(kWheelNames[i]);
      continue;
    }
    const auto place = static_cast<Eigen::Index>(kEstimatedUnbalance + 2 * i);
    solution.x.segment<2>(place) << fit.unbalance_kg_m.real(), fit.unbalance_kg_m.imag();
    // The uncertainty of tyres and suspension is small beside the cost of the force, and stays.
    const double grown = std::pow(fit.sigma_unbalance_kg_m, 2) - std::pow(fit.sigma_equivalent_kg_m, 2);
    solution.covariance.diagonal().segment<2>(place).array() += grown;
    sentences.push_back(std::string(kWheelNames[i]) + ": radial force variation " +
                        std::to_string(std::lround(std::abs(fit.force_n))) + " N +- " +
                        std::to_string(std::lround(fit.sigma_force_n)) + " N, separated from the unbalance");
  }
  if (!not_separable.empty())
    sentences.push_back(
        not_separable +
        ": unbalance and radial force variation are not separable at these speeds; told is the "
        "equivalent unbalance");
  return sentences;
}

void TwoStage::add_variance_of_suspension(const Drive& drive, const ParameterVector& parameters,
                                          Solution& solution) const {
  const auto suspension = sections_.covariance([this](const Drive& part) -> std::optional<UnknownVector> {
    const auto found = with_suspension(total(part));
    if (!found) return std::nullopt;
    UnknownVector x = UnknownVector::Zero();
    x.head<kEstimatedTyre>() = found->segment<kEstimatedTyre>(kSpring);
    return x;
  });
  Eigen::Matrix<double, kUnknowns, kEstimatedTyre> slope;
  for (int p = 0; p < kEstimatedTyre; ++p) {
    ParameterVector moved = parameters;
    const double step = kParameterDifference * question_.known(kSpring + p);
    moved(kSpring + p) += step;
    const auto found = solve_wheels(drive, moved);
    if (found)
      slope.col(p) = (found->x - solution.x) / step;
    else
      slope.col(p).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  if (suspension)
    solution.covariance +=
        slope * suspension->topLeftCorner<kEstimatedTyre, kEstimatedTyre>() * slope.transpose();
  else
    solution.covariance.setConstant(std::numeric_limits<double>::quiet_NaN());
}

namespace {

template <TyreFrom tyre, RoadShare share, bool separate_force = false>
std::unique_ptr<Estimator> make_two_stage(const Question& question) {
  return std::make_unique<TwoStage>(question, TwoStage::Options{tyre, share, separate_force});
}

}  // namespace

std::vector<EstimatorKind> two_stage_kinds() {
  using enum TyreFrom;
  using enum RoadShare;
  return {
      {"known-tyre", "tyre as known, unbalance by demodulation", false, make_two_stage<kKnown, kApart>},
      {"instrument", "tyre by its wheel's past acceleration (1 to 80 Hz, 4 ms), unbalance by demodulation",
       false, make_two_stage<kInstrument, kApart>},
      {"whittle", "tyre by the likelihood of the road, unbalance by demodulation", false,
       make_two_stage<kWhittle, kApart>},
      {"cancellation", "as whittle, and the road that wheels share cancelled", false,
       make_two_stage<kWhittle, kShared>},
      {"force-variation",
       "as cancellation, unbalance and speed-independent force separated where the speeds allow it", false,
       make_two_stage<kWhittle, kShared, true>},
  };
}

}  // namespace roadbalance
