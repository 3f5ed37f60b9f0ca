#include "tools/study/wheels_json.hpp"

#include <numbers>

namespace roadbalance {

nlohmann::ordered_json wheels_json(const Identification& identification,
                                   const std::array<Balance, kWheels>& balance) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  auto wheels = nlohmann::ordered_json::array();
  for (std::size_t w = 0; w < kWheels; ++w) {
    const auto known = [](bool is_known, double value) {
      return is_known ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
    };
    const bool weighed = balance[w].state == Unknown::kNone;
    const bool apart = weighed && balance[w].force_state == ForceState::kSeparated;
    const bool pressed = identification.state == Unknown::kNone;
    wheels.push_back({{"name", kWheelNames[w]},
                      {"unbalance_g", known(weighed, balance[w].unbalance_g)},
                      {"angle_deg", known(weighed, balance[w].angle_rad * kDegrees)},
                      {"sigma_g", known(weighed, balance[w].sigma_g)},
                      {"sigma_deg", known(weighed, balance[w].sigma_rad * kDegrees)},
                      {"force_n", known(apart, balance[w].force_n)},
                      {"sigma_force_n", known(apart, balance[w].sigma_force_n)},
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
