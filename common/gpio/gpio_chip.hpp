#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

namespace roadbalance {

/// A GPIO chip or line that cannot be had.  The text names it and the reason.
class GpioError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An edge of a line as the kernel saw it.
struct GpioEvent {
  std::int64_t monotonic_ns = 0;  ///< CLOCK_MONOTONIC, taken by the interrupt
  bool rising = true;
};

/// The events of a line for its reader.
enum class Waiting : std::uint8_t { kNothing, kEvents, kGone };

/// Input lines of one GPIO chip; what is known of libgpiod is in its .cpp.
///
/// libgpiod 1.6 uses the kernel's first GPIO interface: a line keeps 16 events, and those that come while
/// they wait are lost without a sign; so is an edge that comes before the kernel's interrupt thread has taken
/// the one before.
class GpioChip {
 public:
  enum class Edges { kRising, kBoth };
  static constexpr std::size_t kKernelEvents = 16;  ///< of a line

  /// The properties that identify a chip.  Its number does not: the kernel numbers chips as they come.
  struct Identity {
    std::string label;         ///< what its driver calls it; empty: any
    std::string place;         ///< see device_place()
    bool is_the_only = false;  ///< no other chip at this place was called so
  };

  /// The chip of this name or, if one was opened before, that one, whatever its name is by now.
  /// @param name    of the character device, e.g. "gpiochip0"
  /// @param before  identity() of the chip that was opened first
  /// @throws GpioError
  explicit GpioChip(const std::string& name, const Identity& before);
  explicit GpioChip(const std::string& name) : GpioChip(name, Identity()) {}
  ~GpioChip();
  GpioChip(GpioChip&&) noexcept;
  GpioChip& operator=(GpioChip&&) noexcept;

  /// As it is now; of a chip that is gone: any.
  /// @throws GpioError naming another chip at its place that cannot be had
  Identity identity() const;

  /// Takes a line as an input whose edges are kept from now on.
  /// @param consumer  what others see as its user
  /// @return the line's number for the functions below: lines are counted from 0 as they are taken
  /// @throws GpioError, of a line that is in use with its user
  std::size_t take_edges(unsigned offset, Edges edges, const std::string& consumer);
  /// Takes a line as an input whose level is asked for.  @param active_low  its level counts upside down
  std::size_t take_level(unsigned offset, bool active_low, const std::string& consumer);

  /// Waits until a line has events or the chip is gone, and returns each line's, in the order they were
  /// taken; their levels are not asked for.  Never allocates.
  void wait(std::chrono::milliseconds at_most, std::span<Waiting> lines) noexcept;
  /// Events of a line that wait, oldest first, at most kKernelEvents; wait() must have reported some, else it
  /// waits.  Nothing if the chip is gone.  Never allocates.
  std::optional<std::size_t> read(std::size_t line, std::span<GpioEvent> events) noexcept;
  /// Nothing if the chip is gone.
  std::optional<bool> level(std::size_t line) noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roadbalance
