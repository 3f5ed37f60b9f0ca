#include <atomic>
#include <memory>
#include <optional>
#include <stop_token>
#include <utility>

#include "common/process/parallel.hpp"
#include "firmware/node.hpp"
#include "host/analyser/analyser.hpp"
#include "sim/front_end.hpp"
#include "tools/demonstration/demo_team.hpp"

namespace roadbalance {
namespace {

class Threads final : public DemoTeam {
 public:
  explicit Threads(const DemoPlan& plan) : plan_(plan), at_work_(1 + std::ssize(plan.vehicle().node)) {
    recorder_.run([this](std::stop_token stop) {
      RecorderOptions options;
      options.url = plan_.url();
      options.folder = plan_.record();
      report_ = run_recorder(stop, options);
    });
    others_.run([this](std::stop_token stop) {
      run_analyser(stop, {.url = plan_.url(), .record = plan_.record(), .exit_at_end = true});
      --at_work_;
    });
    for (const NodeConfig& node : plan.vehicle().node)
      others_.run([this, &node](std::stop_token stop) {
        const auto front_end = sim::open_sim_front_end({plan_.front_end_address(), plan_.vehicle(), node});
        NodeOptions options;
        options.bus_url = plan_.url();
        run_node(stop, plan_.vehicle(), node, *front_end, options);
        --at_work_;
      });
  }

  bool working() override {
    // A thread that failed stops its parallel; wait() then throws the reason.
    if (others_.stop_token().stop_requested()) others_.wait();
    if (recorder_.stop_token().stop_requested()) recorder_.wait();
    return at_work_ > 0;
  }

  std::vector<NodeReport> finish() override {
    others_.wait();
    recorder_.request_stop();
    recorder_.wait();
    return report_.node;
  }

 private:
  const DemoPlan& plan_;
  std::atomic<std::ptrdiff_t> at_work_;
  RecorderReport report_;
  Parallel recorder_;
  Parallel others_;
};

}  // namespace

std::unique_ptr<DemoTeam> start_threads(const DemoPlan& plan) {
  return std::make_unique<Threads>(plan);
}

}  // namespace roadbalance
