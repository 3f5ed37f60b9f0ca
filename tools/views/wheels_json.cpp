#include "tools/views/wheels_json.hpp"

#include <numbers>

namespace roadbalance {
namespace {

const char* name_of(ForceState state) {
  switch (state) {
    case ForceState::kNotJudged:
      return "not_judged";
    case ForceState::kSeparated:
      return "separated";
    case ForceState::kNotSeparable:
      return "not_separable";
  }
  return "unknown";
}

nlohmann::ordered_json rows_of(const Eigen::Matrix2d& matrix) {
  auto rows = nlohmann::ordered_json::array();
  for (int i = 0; i < 2; ++i) rows.push_back({matrix(i, 0), matrix(i, 1)});
  return rows;
}

}  // namespace

nlohmann::ordered_json wheels_json(const Identification& identification,
                                   const std::array<Balance, kWheels>& balance) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  auto wheels = nlohmann::ordered_json::array();
  for (std::size_t w = 0; w < kWheels; ++w) {
    const auto known = [](bool is_known, double value) {
      return is_known ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
    };
    const bool weighed = balance[w].state == Unknown::kNone;
    const bool judged = weighed && balance[w].force_state != ForceState::kNotJudged;
    const bool pressed = identification.state == Unknown::kNone;
    wheels.push_back(
        {{"name", kWheelNames[w]},
         {"unbalance_g", known(weighed, balance[w].unbalance_g)},
         {"angle_deg", known(weighed, balance[w].angle_rad * kDegrees)},
         {"sigma_g", known(weighed, balance[w].sigma_g)},
         {"sigma_deg", known(weighed, balance[w].sigma_rad * kDegrees)},
         {"covariance_g2", weighed ? rows_of(balance[w].covariance_g2) : nullptr},
         {"force_state", weighed ? nlohmann::ordered_json(name_of(balance[w].force_state)) : nullptr},
         {"alone_g", known(judged, balance[w].alone_g)},
         {"alone_deg", known(judged, balance[w].alone_angle_rad * kDegrees)},
         {"sigma_alone_g", known(judged, balance[w].sigma_alone_g)},
         {"force_n", known(judged, balance[w].force_n)},
         {"force_deg", known(judged, balance[w].force_angle_rad * kDegrees)},
         {"sigma_force_n", known(judged, balance[w].sigma_force_n)},
         {"tyre_stiffness_n_m", known(pressed, identification.tyre_n_m[w])},
         {"sigma_tyre_stiffness_n_m", known(pressed, identification.sigma_tyre_n_m[w])}});
  }
  return wheels;
}

void add_truth(nlohmann::ordered_json& wheels, const sim::Truth& truth) {
  for (std::size_t w = 0; w < kWheels; ++w) {
    wheels[w]["truth_g"] = truth.wheel[w].unbalance_g;
    wheels[w]["truth_deg"] = truth.wheel[w].angle_deg;
    wheels[w]["truth_tyre_stiffness_n_m"] = truth.wheel[w].tyre_stiffness_n_m;
  }
}

}  // namespace roadbalance
