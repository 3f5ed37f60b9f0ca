#include "host/analysis/identify/estimators/unknown_road.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "host/analysis/identify/estimators/relation_least_squares.hpp"

namespace roadbalance {
namespace {

constexpr int kIterations = 30;
constexpr double kCloseEnough = 1e-6;  ///< of stiffness and unbalance
constexpr double kMostMove = 2.0;      ///< factor of a stiffness from one iteration to the next
/// Ends of a finite record leave up to 3 % of the scatter: equations that differ by no more are one.
constexpr double kEnds = 1e-3;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::complex<double> unbalance_of(const UnknownVector& x, int wheel) {
  return {x(kEstimatedUnbalance + 2 * wheel), x(kEstimatedUnbalance + 2 * wheel + 1)};
}

PredictedCar car_of(const Question& wheels, const UnknownVector& x) {
  ParameterVector parameters = wheels.known;
  PredictedCar car{wheels.geometry, {}, {}};
  for (int i = 0; i < kWheels; ++i) {
    if (const double tyre = x(kEstimatedTyre + i); std::isfinite(tyre)) parameters(kTyre + i) = tyre;
    if (std::isfinite(std::abs(unbalance_of(x, i))))
      car.unbalance_kg_m[static_cast<std::size_t>(i)] = unbalance_of(x, i);
  }
  car.model = linear_model(wheels.geometry, parameters);
  return car;
}

/// Largest change of what is determined, relative.
double change(const UnknownVector& from, const UnknownVector& to) {
  double largest = 0.0;
  for (int i = 0; i < kWheels; ++i) {
    if (const double tyre = to(kEstimatedTyre + i); std::isfinite(tyre))
      largest = std::max(largest, std::abs(from(kEstimatedTyre + i) / tyre - 1.0));
    if (const auto U = unbalance_of(to, i); std::abs(U) > 0.0)
      largest = std::max(largest, std::abs(unbalance_of(from, i) - U) / std::abs(U));
  }
  return largest;
}

}  // namespace

UnknownRoad::UnknownRoad(const Question& question, const RelationOptions& options)
    : question_(question), options_(options) {}

std::optional<Question> UnknownRoad::wheels_question(const BySpeed<RelationCovariances>& sums) const {
  Question wheels = question_;
  if (!question_.asks_for_suspension()) return wheels;
  Question suspension = question_;
  suspension.asked &= suspension_unknowns();
  wheels.asked &= ~suspension_unknowns();
  // With angles as instruments, and none asked for, only the body's rows are left.
  RelationOptions body = options_;
  body.instruments = RelationInstruments::kAngles;
  body.road = RelationRoad::kNone;
  const auto x = solve_relation(sums, suspension, body);
  if (!x) return std::nullopt;
  wheels.known.segment<kEstimatedTyre>(kSpring) = x->head<kEstimatedTyre>();
  return wheels;
}

void UnknownRoad::choose(const BySpeed<RelationCovariances>& sums, const Question& wheels,
                         const UnknownVector& start) {
  const RelationEquations relation(wheels, options_);
  const RelationCovariances& first = sums.at.begin()->second;
  for (int i = 0; i < kWheels; ++i) {
    Wheel wheel{i, {}, {}, {}};
    for (const int place : {kEstimatedTyre + i, kEstimatedUnbalance + 2 * i, kEstimatedUnbalance + 2 * i + 1})
      if (wheels.asked[static_cast<std::size_t>(place)] && std::isfinite(start(place)))
        wheel.unknown.push_back(place);
    if (wheel.unknown.empty()) continue;
    for (std::size_t lag = 0; lag < first.lag.size(); ++lag)
      for (int row = 0; row < first.power.size(); ++row)
        if (relation.uses(row, kBodyCoordinates + i) && first.power(row) > 0.0)
          wheel.instruments.push_back({lag, row});
    wheels_.push_back(std::move(wheel));
  }
}

bool UnknownRoad::weigh(const BySpeed<RelationCovariances>& sums, const Question& wheels,
                        const UnknownVector& x) {
  const PredictedCar car = car_of(wheels, x);
  std::map<int, RelationPrediction> predictions;
  for (const auto& [key, at] : sums.at)
    predictions.try_emplace(key, car, at, options_.filter, options_.road_exponent);
  for (Wheel& wheel : wheels_) {
    struct Speed {
      Eigen::VectorXd size;  ///< of an equation
      Eigen::LLT<Eigen::MatrixXd> V;
      Eigen::MatrixXd a;
      Eigen::VectorXd road;
    };
    std::map<int, Speed> speeds;
    const auto n = static_cast<Eigen::Index>(wheel.instruments.size());
    std::vector<Eigen::Index> accelerations;
    for (std::size_t e = 0; e < wheel.instruments.size(); ++e)
      if (wheel.instruments[e].row % kRelationSignals < kCoordinates)
        accelerations.push_back(static_cast<Eigen::Index>(e));
    const auto unknown_roads = static_cast<Eigen::Index>(accelerations.size());
    std::vector<int> columns;  // of RelationPrediction::harmonic()
    for (const int place : wheel.unknown)
      columns.push_back(place < kEstimatedUnbalance ? 0 : 1 + (place - kEstimatedUnbalance) % 2);

    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(unknown_roads, unknown_roads);
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(unknown_roads, static_cast<Eigen::Index>(columns.size()));
    for (const auto& [key, prediction] : predictions) {
      const Eigen::MatrixXd V = prediction.scatter(wheel.wheel, wheel.instruments);
      Speed speed;
      speed.size = V.diagonal().cwiseSqrt();
      if (!(speed.size.minCoeff() > 0.0) || !V.allFinite()) return false;
      const Eigen::VectorXd scale = speed.size.cwiseInverse();
      speed.V.compute(scale.asDiagonal() * V * scale.asDiagonal() + kEnds * Eigen::MatrixXd::Identity(n, n));
      speed.a = scale.asDiagonal() * prediction.harmonic(wheel.wheel, wheel.instruments)(Eigen::all, columns);
      speed.road = scale.cwiseProduct(prediction.road(wheel.wheel, wheel.instruments));
      Eigen::MatrixXd G = Eigen::MatrixXd::Zero(n, unknown_roads);
      for (Eigen::Index c = 0; c < unknown_roads; ++c)
        G(accelerations[static_cast<std::size_t>(c)], c) =
            speed.road(accelerations[static_cast<std::size_t>(c)]);
      normal += G.transpose() * speed.V.solve(G);
      right += G.transpose() * speed.V.solve(speed.a);
      speeds.emplace(key, std::move(speed));
    }
    Eigen::MatrixXd r = right;
    if (unknown_roads > 0) {
      const Eigen::VectorXd unit = normal.diagonal().cwiseSqrt().cwiseInverse();
      if (!unit.allFinite()) return false;
      r = unit.asDiagonal() *
          (unit.asDiagonal() * normal * unit.asDiagonal()).ldlt().solve(unit.asDiagonal() * right);
    }
    for (const auto& [key, speed] : speeds) {
      Eigen::MatrixXd rest = speed.a;
      for (Eigen::Index c = 0; c < unknown_roads; ++c) {
        const Eigen::Index e = accelerations[static_cast<std::size_t>(c)];
        rest.row(e) -= speed.road(e) * r.row(c);
      }
      wheel.weights[key] = speed.size.cwiseInverse().asDiagonal() * speed.V.solve(rest);
    }
  }
  return true;
}

std::optional<UnknownRoad> UnknownRoad::fit(const BySpeed<RelationCovariances>& sums,
                                            const Question& question, const RelationOptions& options) {
  if (sums.at.empty()) return std::nullopt;
  UnknownRoad road(question, options);
  const auto wheels = road.wheels_question(sums);
  if (!wheels) return std::nullopt;
  if (wheels->asked.none()) return road;
  // The angles alone need no lambda: they tell where to begin.
  RelationOptions angles = options;
  angles.instruments = RelationInstruments::kAngles;
  angles.road = RelationRoad::kNone;
  const auto start = solve_relation(sums, *wheels, angles);
  if (!start) return std::nullopt;
  UnknownVector x = *start;
  for (int i = 0; i < kWheels; ++i)
    if (x(kEstimatedTyre + i) <= 0.0) x(kEstimatedTyre + i) = question.known(kTyre + i);
  road.choose(sums, *wheels, x);
  for (int step = 0; step < kIterations; ++step) {
    if (!road.weigh(sums, *wheels, x)) return std::nullopt;
    auto next = road.solve(sums);
    if (!next) return std::nullopt;
    for (int i = kEstimatedTyre; i < kEstimatedTyre + kWheels; ++i)
      if (std::isfinite((*next)(i))) (*next)(i) = std::clamp((*next)(i), x(i) / kMostMove, x(i) * kMostMove);
    const double moved = change(x, *next);
    x = *next;
    if (moved < kCloseEnough) break;
  }
  return road;
}

std::optional<UnknownVector> UnknownRoad::solve(const BySpeed<RelationCovariances>& sums) const {
  const auto wheels = wheels_question(sums);
  if (!wheels || sums.at.empty()) return std::nullopt;
  UnknownVector x = known_unknowns(*wheels);
  for (int i = 0; i < kUnknowns; ++i)
    if (wheels->asked[static_cast<std::size_t>(i)]) x(i) = kNone;
  const RelationEquations relation(*wheels, options_);
  const std::vector<int>& places = relation.unknown();
  for (const Wheel& wheel : wheels_) {
    const auto n = static_cast<Eigen::Index>(wheel.unknown.size());
    std::vector<Eigen::Index> columns;
    for (const int place : wheel.unknown)
      columns.push_back(std::find(places.begin(), places.end(), place) - places.begin());
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
    for (const auto& [key, at] : sums.at) {
      const auto weights = wheel.weights.find(key);
      if (weights == wheel.weights.end()) continue;
      std::vector<RelationEquations::Equations> of_lag;
      for (const LaggedCovariances& c : at.lag)
        of_lag.push_back(relation.equations(at, c, kBodyCoordinates + wheel.wheel));
      for (std::size_t e = 0; e < wheel.instruments.size(); ++e) {
        const auto [lag, row] = wheel.instruments[e];
        const auto Z = weights->second.row(static_cast<Eigen::Index>(e)).transpose();
        A += Z * of_lag[lag].A.row(row)(columns);
        b += Z * of_lag[lag].b(row);
      }
    }
    const Eigen::VectorXd left = A.rowwise().norm(), right = A.colwise().norm();
    if (!A.allFinite() || !(left.minCoeff() > 0.0) || !(right.minCoeff() > 0.0)) return std::nullopt;
    const Eigen::VectorXd unit = right.cwiseInverse();
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(left.cwiseInverse().asDiagonal() * A *
                                                         unit.asDiagonal());
    if (qr.rank() < n) return std::nullopt;
    x(wheel.unknown) = unit.cwiseProduct(qr.solve(b.cwiseQuotient(left)));
  }
  return x;
}

}  // namespace roadbalance
