#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include "common/types/device_report.hpp"

namespace roadbalance {

/// A USB device that cannot be used now; the text holds why, and the remedy if there is one.
class UsbError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The machine's USB, as it is found when the object is made: devices plugged in later are seen by a new one.
///
/// It and its devices belong to one thread.
class UsbBus {
 public:
  /// @throws UsbError if the system has no USB
  UsbBus();
  UsbBus(const UsbBus&) = delete;
  UsbBus& operator=(const UsbBus&) = delete;
  ~UsbBus();

  /// Waits for transfers and serves them: their devices' functions are called from here.
  void serve(std::chrono::milliseconds at_most);

 private:
  friend class UsbDevice;
  struct State;
  std::unique_ptr<State> state_;
};

/// A vendor-class device with one bulk endpoint that sends; no other program can use it meanwhile.
class UsbDevice {
 public:
  /// @param serial  empty: the only one of its kind
  /// @throws UsbError naming what is there, the udev rule that is missing, or the process that has it
  UsbDevice(UsbBus& bus, std::uint16_t vendor, std::uint16_t product, const std::string& serial);
  UsbDevice(const UsbDevice&) = delete;
  UsbDevice& operator=(const UsbDevice&) = delete;
  ~UsbDevice();

  /// A vendor request.  False or nothing: the device answers that it refuses.
  /// @throws UsbError if the device does not answer
  [[nodiscard]] bool put(std::uint8_t request, std::span<const std::uint8_t> data);
  [[nodiscard]] std::optional<std::size_t> get(std::uint8_t request, std::span<std::uint8_t> reply);

  /// Receives from the bulk endpoint from now on, several transfers at a time.
  /// @param received  what one transfer brought; of one that failed nothing
  /// @param report    counts stalls, and as refused packets transfers longer than their buffer
  /// @throws UsbError if the system takes no transfers
  void stream(std::function<void(std::span<const std::uint8_t>)> received, DeviceReport& report);

  /// After each UsbBus::serve(): starts again what the device halted.
  void maintain();

  /// It was pulled, or a transfer failed in a way that only opening it again mends.
  bool gone() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roadbalance
