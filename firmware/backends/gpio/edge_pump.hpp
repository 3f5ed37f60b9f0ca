#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/frontend/dropped_edges.hpp"
#include "common/frontend/lasting_reason.hpp"
#include "common/gpio/gpio_chip.hpp"
#include "common/process/spsc_queue.hpp"
#include "common/types/clocks.hpp"
#include "common/types/device_report.hpp"
#include "firmware/backends/gpio/edge_maker.hpp"
#include "firmware/backends/gpio/event_order.hpp"

namespace roadbalance {

/// Passes edges from the thread that reads the kernel to the one that takes them.
struct EdgeStore {
  static constexpr std::size_t kEdges = 1 << 15;  ///< 0.25 s of two 1000-pulse transducers at 60 turns/s

  explicit EdgeStore(const std::string& device) : report(device) {}

  SpscQueue<Edge> edges{kEdges};
  std::atomic<std::int64_t> complete_ns{0};  ///< all stamped before this instant is in `edges` or was taken
  DeviceReport report;
};

/// Events of a GPIO chip's lines -> edges in the store; one thread calls it again and again.
///
/// A chip that goes is counted and asked for twice a second until it is there again; why it cannot be had is
/// reported when that lasts.  Its edges in between are declared lost, as are those that come too late or that
/// the store has no room for.  16 events read of a line at once are all that the kernel keeps: then more may
/// have come and gone, and the line's edges are declared lost.  Never allocates, except to open a chip again.
class EdgePump {
 public:
  using Warn = std::function<void(const std::string&)>;

  /// @param warn  gets from turn() why a chip that went cannot be had again
  /// @throws ConfigError naming the key of vehicle.toml whose line cannot be had, GpioError naming the chip
  EdgePump(std::string chip, std::vector<GpioInput> inputs, EdgeStore& store, Warn warn);

  /// Waits until something comes, at most 5 ms, and puts it in the store.
  void turn() noexcept;

 private:
  static constexpr auto kPatience = std::chrono::milliseconds(5);
  /// An edge's interrupt thread may come so long after its interrupt.
  static constexpr std::int64_t kSettle_ns = 2'000'000;
  static constexpr std::int64_t kClockReading_ns = 2'000;  ///< two comparisons of clocks may differ so much
  static constexpr std::int64_t kRetry_ns = 500'000'000;

  void open();
  bool open_again() noexcept;
  void read_levels() noexcept;
  bool read_waiting() noexcept;
  void put_events(std::size_t input, std::size_t count) noexcept;
  void give_before(std::int64_t monotonic_ns) noexcept;
  void drop(std::uint8_t line, DeviceCounter why) noexcept;
  void store(const Edge& edge) noexcept;
  void wake() noexcept;
  void lose_all(std::int64_t monotonic_ns) noexcept;
  void chip_is_gone() noexcept;
  void complete_before(std::int64_t monotonic_ns) noexcept;

  const std::string chip_name_;
  GpioChip::Identity identity_;  ///< of the chip that was opened first
  EdgeStore& store_;
  const Warn warn_;
  EdgeMaker maker_;
  EventOrder order_;
  std::optional<GpioChip> chip_;
  std::vector<Waiting> waiting_;  ///< [input]
  std::vector<bool> was_full_;    ///< [input] in this drain the kernel had all it keeps
  DroppedEdges dropped_;
  std::array<GpioEvent, GpioChip::kKernelEvents> event_;
  std::int64_t machine_minus_monotonic_ns_ = 0;
  std::int64_t retry_ns_ = 0;
  LastingReason why_gone_;
};

}  // namespace roadbalance
