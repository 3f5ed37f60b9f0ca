#include "host/analysis/twin/twin.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {
namespace {

/// From an instant to the meeting with the other axle, samples: what both the newest F and the interpolation
/// leave of kBehind.
constexpr int kFarthest = Twin::kBehind - SampleHistory::kHalfRate - FractionalDelay::kAfter - 2;

}  // namespace

Twin::Twin(const TwinChannels& channels, const TwinCar& car, double rate_hz)
    : channels_(channels),
      car_(car),
      rate_hz_(rate_hz),
      model_(linear_model(car.geometry, car.parameters)),
      history_(channels, rate_hz),
      body_(make(body_motion(model_))),
      axle_{{{make(axle_motion(model_, 0))}, {make(axle_motion(model_, 1))}}},
      axle_input_(Eigen::VectorXd::Zero(kAxleInputs)) {
  out_.measured.setZero(channels_.wheels_from.cols());
  out_.predicted.setZero(channels_.wheels_from.cols());
  restart();
}

MotionFilter Twin::make(const MotionEquation& equation) const {
  return MotionFilter(equation, 1.0 / rate_hz_);
}

void Twin::change(const TwinCar& car) {
  const bool other = greatest_difference(car, car_) > kOtherCar;
  const LinearModel model = linear_model(car.geometry, car.parameters);
  const auto renewed = [&](const MotionFilter& filter, const MotionEquation& equation) {
    MotionFilter one = make(equation);
    one.go_on_from(filter);
    return one;
  };
  MotionFilter body = renewed(body_, body_motion(model)),
               front = renewed(axle_[0].filter, axle_motion(model, 0)),
               rear = renewed(axle_[1].filter, axle_motion(model, 1));
  // From here on nothing throws: a car that is refused has changed nothing.
  car_ = car;
  model_ = model;
  body_ = std::move(body);
  axle_[0].filter = std::move(front);
  axle_[1].filter = std::move(rear);
  if (!other) return;
  body_fed_ = 0;
  for (Axle& axle : axle_) axle.fed = 0;
}

double Twin::settling_s() const {
  return std::max({body_.settling_s(kSettled), axle_[0].filter.settling_s(kSettled),
                   axle_[1].filter.settling_s(kSettled)});
}

TwinState Twin::state(const MotionFilter& filter, std::int64_t fed) const {
  const bool settled = static_cast<double>(fed) > filter.settling_s(kSettled) * rate_hz_;
  return settled ? TwinState::kPredicted : TwinState::kSettling;
}

void Twin::restart() {
  history_.restart();
  body_.reset();
  body_fed_ = 0;
  for (Axle& axle : axle_) {
    axle.filter.reset();
    axle.fed = 0;
  }
}

const TwinSample* Twin::consume(const SensorSample& sample) {
  if (sample.restart) restart();
  history_.add(sample, car_);
  const std::int64_t next = history_.end() - kBehind;
  if (next < 1) return nullptr;
  step(next);
  return &out_;
}

/// Feeds what acts at `next` and puts out the sample before it.
void Twin::step(std::int64_t next) {
  coordinates_.head<kBodyCoordinates>() = body_.update(history_.wheels(next));
  out_.state[static_cast<std::size_t>(TwinPart::kBody)] = state(body_, ++body_fed_);
  for (int a = 0; a < kAxles; ++a) {
    step_axle(a, next);
    const Axle& axle = axle_[static_cast<std::size_t>(a)];
    coordinates_.segment<2>(kBodyCoordinates + 2 * a) = axle.wheels;
    out_.state[static_cast<std::size_t>(TwinPart::kFront) + static_cast<std::size_t>(a)] = axle.refusal;
  }
  const std::int64_t now = next - 1;
  out_.time_ns = history_.time_ns(now);
  out_.measured = history_.sensors(now);
  out_.predicted.noalias() = channels_.from_coordinates * coordinates_;
  const double rolled_m = history_.rolled_m(next + SampleHistory::kHalfRate, 0) +
                          history_.rolled_m(next + SampleHistory::kHalfRate, 1) - history_.rolled_m(now, 0) -
                          history_.rolled_m(now, 1);
  out_.speed_m_s = 0.5 * rolled_m * rate_hz_ / (SampleHistory::kHalfRate + 1);
}

void Twin::step_axle(int a, std::int64_t next) {
  Axle& axle = axle_[static_cast<std::size_t>(a)];
  for (int side = 0; side < 2; ++side)
    if (const TwinState why = meet(a, side, next, axle.meeting[static_cast<std::size_t>(side)]);
        why != TwinState::kPredicted) {
      if (axle.fed > 0) axle.filter.reset();
      axle.fed = 0;
      axle.refusal = why;
      return;
    }
  const int own = 2 * a, other = 2 * (1 - a);
  axle_input_.segment<2>(kOtherNow) = history_.wheels(next).segment<2>(other);
  axle_input_.segment<2>(kForceNow) = history_.forces(next).segment<2>(own);
  for (int side = 0; side < 2; ++side) {
    const Meeting& meeting = axle.meeting[static_cast<std::size_t>(side)];
    const auto then = history_.drive_at(meeting.n, meeting.fraction);
    axle_input_(kWheelsThen + side) = then(side);
    axle_input_(kWheelsThen + 2 + side) = then(2 + side);
    axle_input_(kOtherForceThen + side) = then(kWheels + other + side);
  }
  axle.wheels = axle.filter.update(axle_input_).segment<2>(kAxleWheels);
  axle.refusal = state(axle.filter, ++axle.fed);
}

/// Goes on from where the meeting was: the car rolls little from sample to sample.
TwinState Twin::meet(int a, int side, std::int64_t next, Meeting& meeting) const {
  if (!history_.rolls(next)) return TwinState::kNoSpeed;
  const auto own = static_cast<std::size_t>(2 * a + side),
             other = static_cast<std::size_t>(2 * (1 - a) + side);
  const double ahead_m = car_.geometry.x_m[own] - car_.geometry.x_m[other];
  const double wanted_m = history_.rolled_m(next, side) + ahead_m;
  // Before the first F, and where the interpolation finds nothing, there is no meeting.
  const std::int64_t first =
      std::max({history_.oldest() + FractionalDelay::kBefore,
                std::int64_t{SampleHistory::kHalfRate + FractionalDelay::kBefore}, next - kFarthest});
  const std::int64_t last = next + kFarthest - 1;
  std::int64_t n = std::clamp(meeting.n, first, last);
  while (n < last && history_.rolled_m(n + 1, side) <= wanted_m) ++n;
  while (n > first && history_.rolled_m(n, side) > wanted_m) --n;
  const double at_m = history_.rolled_m(n, side), step_m = history_.rolled_m(n + 1, side) - at_m;
  if (!(at_m <= wanted_m && wanted_m < at_m + step_m))
    return next < 2 * kFarthest ? TwinState::kSettling : TwinState::kTooSlow;
  meeting = {n, (wanted_m - at_m) / step_m};
  return TwinState::kPredicted;
}

}  // namespace roadbalance
