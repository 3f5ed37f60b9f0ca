#include "tools/study/clock_skew.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/process/parallel.hpp"
#include "common/record/record_reader.hpp"
#include "embedded/demo_vehicle.hpp"
#include "firmware/node.hpp"
#include "host/recorder/recorder.hpp"
#include "sim/front_end.hpp"
#include "tools/study/statistics.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kLookPeriod{50};
constexpr std::chrono::seconds kSettling{2};
constexpr std::chrono::seconds kPatience{20};  // for the first fits

/// The demo's car, whose two nodes take turns as patterns for as many as are wanted.
VehicleConfig vehicle_with(int nodes) {
  auto vehicle = VehicleConfig::parse(std::string(embedded::kDemoVehicle), "sim/demo/vehicle.toml");
  const auto pattern = vehicle.node;
  vehicle.node.clear();
  for (int n = 0; n < nodes; ++n) {
    NodeConfig node = pattern[static_cast<std::size_t>(n) % pattern.size()];
    node.id = n + 1;
    node.name = "clock" + std::to_string(n + 1);
    vehicle.node.push_back(node);
  }
  return vehicle;
}

/// One node with a clock of its own, running as a thread.
struct Node {
  std::unique_ptr<FrontEnd> front_end;
  std::optional<ClockFit> fit;
  bool inside = true;  ///< no error of the present window was larger than stated
};

std::string address_of(int n, double seconds, WallTime start) {
  constexpr std::array<double, 4> kPpm{40.0, -60.0, 5.0, -25.0};
  const auto i = static_cast<std::size_t>(n) % kPpm.size();
  char text[200];
  std::snprintf(
      text, sizeof text,
      "?rate=1&seed=1&seconds=%.1f&start_ns=%lld&clock_offset_s=%.6f&clock_ppm=%.1f&converter_ppm=%.1f",
      seconds, static_cast<long long>(start.time_since_epoch().count()), 3600.123456 * (n - 1), kPpm[i],
      -kPpm[(i + 1) % kPpm.size()]);
  return text;
}

class ClockComparison {
 public:
  ClockComparison(const std::string& bus_url, std::map<std::int32_t, Node>& nodes)
      : nodes_(nodes), bus_(bus_url) {
    bus_.subscribe("RB_CLOCK_.*", [this](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto fit = decode_clock_fit(bytes)) take(*fit);
    });
  }

  /// True once every node has had a fit.
  bool look() {
    bus_.handle(kLookPeriod);
    std::vector<double> errors_s;
    for (auto& [id, node] : nodes_) {
      if (!node.fit) return false;
      const MachineTime now = MachineClock::now();
      const double error_s = error_of(*node.fit, node.front_end->node_time(now), now);
      node.inside = node.inside && std::abs(error_s) <= node.fit->uncertainty_s;
      errors_s.push_back(error_s);
    }
    if (!counting_) return true;
    for (std::size_t i = 0; i < errors_s.size(); ++i) {
      error_us_.push_back(1e6 * std::abs(errors_s[i]));
      for (std::size_t j = 0; j < i; ++j) skew_us_.push_back(1e6 * std::abs(errors_s[i] - errors_s[j]));
    }
    return true;
  }

  void begin_to_count() { counting_ = true; }

  nlohmann::ordered_json result() {
    const double covered = 100.0 * static_cast<double>(covered_) / static_cast<double>(std::max(windows_, 1));
    const double p99_us = quantile(skew_us_, 0.99);
    return {{"skew_p50_us", quantile(skew_us_, 0.5)},
            {"skew_p99_us", p99_us},
            {"skew_max_us", quantile(skew_us_, 1.0)},
            {"error_p99_us", quantile(error_us_, 0.99)},
            {"uncertainty_p50_us", quantile(uncertainty_us_, 0.5)},
            {"windows", windows_},
            {"covered_percent", covered},
            {"met", windows_ > 0 && p99_us <= 50.0 && covered >= 99.9}};
  }

 private:
  static double error_of(const ClockFit& fit, NodeTime truth, MachineTime now) {
    return 1e-9 * static_cast<double>(fit.host_time_ns(to_ns(truth)) - to_ns(now));
  }

  void take(const ClockFit& fit) {
    const auto found = nodes_.find(fit.node);
    if (found == nodes_.end() || !fit.is_known()) return;
    Node& node = found->second;
    if (counting_ && node.fit) {
      ++windows_;
      covered_ += node.inside ? 1 : 0;
      uncertainty_us_.push_back(1e6 * node.fit->uncertainty_s);
    }
    node.fit = fit;
    node.inside = true;
  }

  std::map<std::int32_t, Node>& nodes_;
  Bus bus_;
  bool counting_ = false;
  std::vector<double> skew_us_, error_us_, uncertainty_us_;
  int windows_ = 0, covered_ = 0;
};

/// How many of the recorded instants are the kernel's own, in percent.
double kernel_stamps_percent(const std::filesystem::path& folder) {
  int kernel = 0, all = 0;
  RecordReader reader(folder);
  reader.finish();
  while (const auto event = reader.next())
    if (const auto exchange = decode_clock_exchange(event->data))
      for (int k = 0; k < 4; ++k, ++all) kernel += (exchange->kernel_stamps >> k) & 1U;
  return 100.0 * kernel / std::max(all, 1);
}

}  // namespace

nlohmann::ordered_json clock_skew(const ClockSkewOptions& options) {
  const VehicleConfig vehicle = vehicle_with(options.nodes);
  std::map<std::int32_t, Node> nodes;
  const WallTime start = WallClock::now();
  for (int n = 0; n < options.nodes; ++n) {
    const NodeConfig& node = vehicle.node[static_cast<std::size_t>(n)];
    const double drive_s = options.seconds + 600.0;  // longer than anybody waits
    nodes[node.id].front_end = sim::open_sim_front_end({address_of(n, drive_s, start), vehicle, node});
  }
  ClockComparison comparison(options.bus_url, nodes);
  Parallel recorder, team;
  recorder.run([&](std::stop_token stop) {
    RecorderOptions record;
    record.url = options.bus_url;
    record.folder = options.folder;
    run_recorder(stop, record);
  });
  for (const NodeConfig& node : vehicle.node)
    team.run([&](std::stop_token stop) {
      NodeOptions how;
      how.bus_url = options.bus_url;
      run_node(stop, vehicle, node, *nodes.at(node.id).front_end, how);
    });

  const auto look_for = [&](std::chrono::duration<double> time) {
    const WallTime begin = WallClock::now();
    bool all = false;
    while (WallClock::now() - begin < time) {
      all = comparison.look();
      if (team.stop_token().stop_requested()) team.wait();  // throws the failure
      if (recorder.stop_token().stop_requested()) recorder.wait();
    }
    return all;
  };
  for (const WallTime begin = WallClock::now(); !comparison.look();)
    if (WallClock::now() - begin > kPatience)
      throw std::runtime_error("not every node's clock could be asked for");
  look_for(kSettling);
  comparison.begin_to_count();
  look_for(std::chrono::duration<double>(options.seconds));

  recorder.request_stop();  // stops the nodes and waits for their ends
  recorder.wait();
  team.wait();
  nlohmann::ordered_json result{{"nodes", options.nodes}, {"seconds", options.seconds}};
  result.update(comparison.result());
  result["kernel_stamps_percent"] = kernel_stamps_percent(options.folder);
  return result;
}

}  // namespace roadbalance
