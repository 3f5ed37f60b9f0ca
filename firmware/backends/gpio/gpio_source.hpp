#pragma once

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/frontend/registry.hpp"
#include "common/frontend/side_source.hpp"
#include "firmware/backends/gpio/edge_pump.hpp"

namespace roadbalance {

/// Encoder edges from the inputs of a GPIO chip, stamped by the kernel.
class GpioSource final : public SideSource {
 public:
  using Warn = EdgePump::Warn;

  /// @param warn  gets, from the thread, what the system refuses of its real-time priority, and why a chip
  ///              that went cannot be had again
  /// @throws ConfigError naming the key of vehicle.toml whose line cannot be had, GpioError naming the chip
  GpioSource(const std::string& chip, std::vector<GpioInput> inputs, Warn warn);

  SideRead take(std::span<Edge> edges, std::span<SignalSample> signals) noexcept override;
  std::vector<const DeviceReport*> reports() const override { return {&store_.report}; }

 private:
  EdgeStore store_;
  EdgePump pump_;
  std::jthread thread_;
};

/// "gpio:gpiochip0": the inputs of [[node.line]] on that chip.
/// @param warn  gets what will not do what may be expected, and what the system refuses
/// @throws as GpioSource and gpio_inputs()
std::unique_ptr<SideSource> open_gpio(const FrontEndRequest& request, const GpioSource::Warn& warn);

}  // namespace roadbalance
