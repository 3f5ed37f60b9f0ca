#pragma once

#include <string>
#include <vector>

#include "common/dbc/can_frame.hpp"

namespace roadbalance::test {

/// Runs "ip" with these words, separated by blanks.  @throws std::runtime_error if it fails
void ip(const std::string& words);

/// True if the interface is there.
bool has_interface(const std::string& name);

/// A CAN interface of the guest for the time of a test: made, up, able to carry CAN FD; deleted at the end.
class VirtualCan {
 public:
  explicit VirtualCan(std::string name);
  /// One end of a cable between two interfaces.
  VirtualCan(std::string name, const std::string& other_end);
  VirtualCan(const VirtualCan&) = delete;
  VirtualCan& operator=(const VirtualCan&) = delete;
  ~VirtualCan();
  const std::string& name() const { return name_; }

 private:
  std::string name_;
};

/// Another device on the bus: what the product has not, it sends.
class CanPlayer {
 public:
  /// @throws std::system_error
  explicit CanPlayer(const std::string& interface);
  CanPlayer(const CanPlayer&) = delete;
  CanPlayer& operator=(const CanPlayer&) = delete;
  ~CanPlayer();

  /// Waits while the interface has no room.  @throws std::system_error
  void send(const CanFrame& frame);
  /// An error frame, as a controller reports it: on a virtual interface only.
  /// @param error  CAN_ERR_...; `controller` is its byte 1
  void send_error(std::uint32_t error, std::uint8_t controller = 0);

 private:
  void send_bytes(const void* bytes, std::size_t size);
  int descriptor_;
};

}  // namespace roadbalance::test
