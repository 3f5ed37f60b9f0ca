#include "firmware/backends/gpio/gpio_source.hpp"

#include <algorithm>
#include <latch>
#include <memory>
#include <utility>

#include "common/process/realtime.hpp"

namespace roadbalance {

GpioSource::GpioSource(const std::string& chip, std::vector<GpioInput> inputs, Warn warn)
    : store_("gpio:" + chip), pump_(chip, std::move(inputs), store_, warn) {
  // To keep memory in RAM takes long when there is much of it: the edges that matter come afterwards.
  std::latch ready(1);
  thread_ = std::jthread([this, &ready, warn = std::move(warn)](const std::stop_token& stop) {
    for (const std::string& refused : enter_realtime(kDevicePriority))
      warn(store_.report.device() + ": " + refused);
    ready.count_down();
    while (!stop.stop_requested()) pump_.turn();
  });
  ready.wait();
}

SideRead GpioSource::take(std::span<Edge> edges, std::span<SignalSample>) noexcept {
  SideRead read;
  std::int64_t complete_ns = store_.complete_ns.load(std::memory_order_acquire);
  const Edge* next = store_.edges.front();
  for (; next && read.edges < edges.size(); next = store_.edges.front()) {
    edges[read.edges++] = *next;
    store_.edges.pop();
  }
  if (next) complete_ns = std::min(complete_ns, to_ns(next->time));
  read.complete_until = node_time_from_ns(complete_ns);
  return read;
}

std::unique_ptr<SideSource> open_gpio(const FrontEndRequest& request, const GpioSource::Warn& warn) {
  const std::string device = "gpio:" + request.address;
  return std::make_unique<GpioSource>(request.address,
                                      gpio_inputs(device, request.vehicle, request.node, warn), warn);
}

}  // namespace roadbalance
