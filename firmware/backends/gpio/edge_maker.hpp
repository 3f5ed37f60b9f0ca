#pragma once

#include <array>
#include <span>
#include <vector>

#include "common/types/device_report.hpp"
#include "common/types/scan.hpp"
#include "firmware/backends/gpio/gpio_input.hpp"
#include "firmware/backends/gpio/input_event.hpp"
#include "firmware/backends/gpio/quadrature.hpp"

namespace roadbalance {

/// Events of the inputs, in order of time -> edges of the node's encoders, each later than the one before.
/// Stamps are of the machine's clock.  Never allocates after construction.
class EdgeMaker {
 public:
  static constexpr std::size_t kMost = 2;  ///< edges that one event can make

  /// @param report  counts what was lost; must outlive this
  EdgeMaker(std::vector<GpioInput> inputs, DeviceReport& report);

  /// @return how many of `edges` were filled
  std::size_t take(const InputEvent& event, std::span<Edge, kMost> edges) noexcept;
  /// Edges of this line may be missing before `time`; which are not counted here.
  Edge lost(std::uint8_t line, NodeTime time) noexcept;
  /// Levels of a line's tracks about now, if they could be read.
  void start(std::uint8_t line, std::optional<bool> tooth, std::optional<bool> direction) noexcept;

  /// The line has a second track: both edges of both tracks are needed.
  bool has_direction(std::uint8_t line) const noexcept { return has_direction_[line]; }
  const std::vector<GpioInput>& inputs() const noexcept { return inputs_; }

 private:
  Edge edge(std::uint8_t line, EdgeKind kind, NodeTime time) noexcept;

  const std::vector<GpioInput> inputs_;
  DeviceReport& report_;
  std::array<bool, kEncoderLines> has_direction_{};
  std::array<Quadrature, kEncoderLines> quadrature_;
  NodeTime last_ = NodeTime::min();
};

}  // namespace roadbalance
