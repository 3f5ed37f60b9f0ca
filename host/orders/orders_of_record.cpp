#include "host/orders/orders_of_record.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include "common/config/section.hpp"
#include "common/wheel_counter/wanted_signal.hpp"
#include "host/analyser/recorded_vehicle.hpp"
#include "host/orders/wanted_rotors.hpp"

namespace roadbalance {
namespace {

/// What is read in one go: analyses, and the vehicle whose angles they take.
struct Job {
  VehicleConfig vehicle;
  WantedOrders wanted;
};

/// The vehicle as if the node that hears the wheel's speed read an encoder of it, without zero mark.
std::optional<VehicleConfig> with_speed_of_bus(const VehicleConfig& vehicle, const WheelConfig& wheel) {
  for (const NodeConfig& node : vehicle.node) {
    if (!speed_signal(node.wiring, wheel.name)) continue;
    VehicleConfig seen = vehicle;
    for (WheelConfig& other : seen.wheel) other.node.clear();
    WheelConfig& own = seen.wheel[static_cast<std::size_t>(vehicle.place_of(wheel))];
    own.node = node.name;
    own.line = 0;
    own.encoder = {.zero_mark = false};
    return seen;
  }
  return std::nullopt;
}

std::vector<Job> jobs_of(const VehicleConfig& vehicle, const WantedOrders& wanted) {
  std::vector<Job> jobs;
  const auto is_wanted = [&](const WheelConfig& wheel) {
    return !wanted.wheel || wheel.name == *wanted.wheel;
  };
  const bool encoder = std::ranges::any_of(
      vehicle.wheel, [&](const WheelConfig& wheel) { return !wheel.node.empty() && is_wanted(wheel); });
  if (encoder || wanted.rotor) jobs.push_back({vehicle, wanted});
  for (const WheelConfig& wheel : vehicle.wheel) {
    if (!wheel.node.empty() || wanted.rotor || !is_wanted(wheel)) continue;
    auto seen = with_speed_of_bus(vehicle, wheel);
    if (!seen) continue;
    jobs.push_back({std::move(*seen), wanted});
    jobs.back().wanted.wheel = wheel.name;
    jobs.back().wanted.vold_kalman_hz.reset();  // nobody knows where it stands
  }
  if (jobs.empty()) jobs.push_back({vehicle, wanted});  // which says what is wrong
  return jobs;
}

/// A wheel whose zero marks do not say where it stands is as good as one without.
bool forget_useless_marks(AngleAgain& angles, VehicleConfig& vehicle) {
  bool any = false;
  for (int w = 0; w < kWheels; ++w) {
    bool& marked = vehicle.wheel[static_cast<std::size_t>(w)].encoder.zero_mark;
    const auto quality = angles.quality(w);
    if (!marked || !quality || quality->located) continue;
    marked = false;
    any = true;
  }
  return any;
}

/// For each node of the rotors; only all wheels together can be told apart.
std::vector<std::unique_ptr<CrossingOrders>> crossings(
    const Job& job, const std::vector<std::unique_ptr<RotorOrders>>& rotors) {
  std::vector<std::unique_ptr<CrossingOrders>> all;
  if (!job.wanted.vold_kalman_hz) return all;
  std::vector<Rotor> together;
  for (const WheelConfig& wheel : job.vehicle.wheel)
    if (!wheel.node.empty() && wheel.encoder.zero_mark) together.push_back(rotor_of(job.vehicle, wheel));
  if (job.wanted.rotor) together.push_back(rotors.front()->rotor());
  if (together.empty()) throw ConfigError("--vold-kalman: no wheel has an angle against a zero mark");
  for (const auto& rotor : rotors) {
    const auto& node = rotor->node();
    if (std::ranges::any_of(all, [&](const auto& one) { return one->node().id == node.id; })) continue;
    const auto place =
        std::ranges::find(job.vehicle.node, node.id, &NodeConfig::id) - job.vehicle.node.begin();
    try {
      all.push_back(std::make_unique<CrossingOrders>(job.vehicle, together, static_cast<int>(place),
                                                     rotor->channel(), rotor->order(),
                                                     *job.wanted.vold_kalman_hz));
    } catch (const std::invalid_argument& error) {
      throw ConfigError("--vold-kalman: " + std::string(error.what()));
    }
  }
  return all;
}

void analyse(const std::filesystem::path& folder, Job job, RecordOrders& result) {
  auto rotors = wanted_rotors(job.vehicle, job.wanted);
  AngleAgain angles(job.vehicle, AngleAgain::WithoutMark::kTurned);
  if (angles.wanted()) {
    read_recording(
        folder, [](const VehicleConfig&) {}, [&](const SealedBlock& block) { angles.learn(block); });
    if (forget_useless_marks(angles, job.vehicle)) rotors = wanted_rotors(job.vehicle, job.wanted);
  }
  auto crossing = crossings(job, rotors);
  result.defects = read_recording(
      folder, [](const VehicleConfig&) {},
      [&](const SealedBlock& block) {
        const SealedBlock& again = angles.again(block);
        for (const auto& rotor : rotors) rotor->consume(again);
        for (const auto& one : crossing) one->consume(again);
      },
      [&](const ClockFit& fit) {
        for (const auto& rotor : rotors) rotor->consume(fit);
        for (const auto& one : crossing) one->consume(fit);
      });
  for (auto& one : crossing) {
    one->finish();
    result.crossing.push_back(std::move(one));
  }
  for (int wheel = 0; wheel < kWheels; ++wheel)
    if (const auto quality = angles.quality(wheel)) result.angle.emplace(wheel, *quality);
  for (auto& rotor : rotors) result.rotor.push_back(std::move(rotor));
}

}  // namespace

RecordOrders orders_of_record(const std::filesystem::path& folder, const WantedOrders& wanted) {
  RecordOrders result{.vehicle = vehicle_of_recording(folder)};
  for (const Job& job : jobs_of(result.vehicle, wanted)) analyse(folder, job, result);
  return result;
}

}  // namespace roadbalance
