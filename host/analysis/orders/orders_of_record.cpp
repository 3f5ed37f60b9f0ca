#include "host/analysis/orders/orders_of_record.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/angle/own_mark.hpp"
#include "common/angle/wanted_signal.hpp"
#include "common/config/section.hpp"
#include "host/recording/recorded_vehicle.hpp"

namespace roadbalance {
namespace {

[[noreturn]] void refuse_wheel(const VehicleConfig& vehicle, const std::string& name) {
  const char* why = ": there is no such wheel";
  std::string there;
  for (const WheelConfig& wheel : vehicle.wheel) {
    if (!wheel.node.empty()) there += " " + wheel.name;
    if (wheel.name == name) why = ": vehicle.toml gives it no encoder";
  }
  throw ConfigError("--wheel " + name + why + "; allowed:" + (there.empty() ? " none" : there));
}

[[noreturn]] void refuse_rotor(const VehicleConfig& vehicle, const std::string& name) {
  std::string there;
  for (const RotorConfig& rotor : vehicle.rotor) there += " " + rotor.name;
  throw ConfigError("--rotor " + name + ": there is no such rotor; allowed:" +
                    (there.empty() ? " none: vehicle.toml has no [[rotor]]" : there));
}

[[noreturn]] void refuse_channel(const VehicleConfig& vehicle, const std::string& name) {
  std::string there;
  for (const NodeConfig& node : vehicle.node)
    for (const ChannelConfig& channel : node.channel)
      if (there.find(" " + channel.name + " ") == std::string::npos) there += " " + channel.name + " ";
  throw ConfigError("--channel " + name + ": no node has such a channel; allowed:" + there);
}

std::vector<Rotor> rotors(const VehicleConfig& vehicle, const WantedOrders& wanted) {
  if (wanted.rotor) {
    const RotorConfig* const rotor = vehicle.rotor_named(*wanted.rotor);
    if (!rotor) refuse_rotor(vehicle, *wanted.rotor);
    return {rotor_of(vehicle, *rotor)};
  }
  std::vector<Rotor> all;
  for (const WheelConfig& wheel : vehicle.wheel)
    if (!wheel.node.empty() && (!wanted.wheel || wheel.name == *wanted.wheel))
      all.push_back(rotor_of(vehicle, wheel));
  if (all.empty() && wanted.wheel) refuse_wheel(vehicle, *wanted.wheel);
  if (all.empty())
    throw ConfigError("vehicle.toml of the recording gives no wheel an encoder: no angle, no orders");
  return all;
}

bool reads_encoder(const VehicleConfig& vehicle, const Rotor& rotor, const NodeConfig& node) {
  return std::ranges::any_of(
      rotor.wheel, [&](int w) { return vehicle.wheel[static_cast<std::size_t>(w)].node == node.name; });
}

/// Places of the accelerations in a node's channels.
std::vector<std::size_t> accelerations_of(const NodeConfig& node) {
  std::vector<std::size_t> channels;
  for (std::size_t c = 0; c < node.channel.size(); ++c)
    if (node.channel[c].role == ChannelRole::kAcceleration) channels.push_back(c);
  return channels;
}

struct Place {
  int node;
  std::vector<std::size_t> channel;
};

/// The first of that name, in a node that reads the rotor's encoders if one has it.
std::vector<Place> place_of(const VehicleConfig& vehicle, const Rotor& rotor, const std::string& name) {
  for (const bool own : {true, false})
    for (std::size_t n = 0; n < vehicle.node.size(); ++n) {
      const NodeConfig& node = vehicle.node[n];
      if (reads_encoder(vehicle, rotor, node) != own) continue;
      const auto found = std::ranges::find(node.channel, name, &ChannelConfig::name);
      if (found != node.channel.end())
        return {{static_cast<int>(n), {static_cast<std::size_t>(found - node.channel.begin())}}};
    }
  refuse_channel(vehicle, name);
}

std::vector<Place> places(const VehicleConfig& vehicle, const Rotor& rotor, const WantedOrders& wanted) {
  if (wanted.channel) return place_of(vehicle, rotor, *wanted.channel);
  std::vector<Place> all;
  for (std::size_t n = 0; n < vehicle.node.size(); ++n) {
    if (!wanted.all_nodes && !reads_encoder(vehicle, rotor, vehicle.node[n])) continue;
    auto channels = accelerations_of(vehicle.node[n]);
    if (!channels.empty()) all.push_back({static_cast<int>(n), std::move(channels)});
  }
  return all;
}

/// The analyses that are wanted of a vehicle's recording.
/// @throws ConfigError naming what cannot be analysed, and what can
std::vector<std::unique_ptr<RotorOrders>> wanted_rotors(const VehicleConfig& vehicle,
                                                        const WantedOrders& wanted) {
  std::vector<std::unique_ptr<RotorOrders>> all;
  for (const Rotor& rotor : rotors(vehicle, wanted))
    for (Place& place : places(vehicle, rotor, wanted)) try {
        all.push_back(std::make_unique<RotorOrders>(vehicle, rotor, place.node, std::move(place.channel),
                                                    wanted.order,
                                                    RotorOrders::Effort{.vector_turns = wanted.block_turns}));
      } catch (const std::invalid_argument& error) {
        throw ConfigError("--order: " + std::string(error.what()));
      }
  if (all.empty()) throw ConfigError("no node that reads an encoder has a channel of role acceleration");
  return all;
}

/// Analyses of one reading, and the vehicle whose angles they take.
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
    jobs.back().wanted.vold_kalman_hz.reset();  // its angle is not known
  }
  if (jobs.empty()) jobs.push_back({vehicle, wanted});  // which reports what is wrong
  return jobs;
}

/// A wheel whose zero marks do not show where it stands is as good as one without.
bool forget_useless_marks(AngleReprocessor& angles, VehicleConfig& vehicle) {
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

/// For each node of the rotors; only all wheels together can be separated.
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
  const bool few_pulses = std::ranges::any_of(job.vehicle.wheel, [](const WheelConfig& wheel) {
    return !wheel.node.empty() && is_own_mark(wheel.encoder);
  });
  AngleReprocessor angles(job.vehicle, AngleReprocessor::WithoutMark::kTurned,
                          few_pulses ? AngleReprocessor::Teeth::kAgain : AngleReprocessor::Teeth::kAsLive);
  if (angles.wanted()) {
    read_recording(
        folder, [](const VehicleConfig&) {}, [&](const SealedBlock& block) { angles.learn(block); });
    if (forget_useless_marks(angles, job.vehicle)) rotors = wanted_rotors(job.vehicle, job.wanted);
  }
  auto crossing = crossings(job, rotors);
  result.defects = read_recording(
      folder, [](const VehicleConfig&) {},
      [&](const SealedBlock& block) {
        const SealedBlock& reprocessed = angles.reprocess(block);
        for (const auto& rotor : rotors) rotor->consume(reprocessed);
        for (const auto& one : crossing) one->consume(reprocessed);
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
