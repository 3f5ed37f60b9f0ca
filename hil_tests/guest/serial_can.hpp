#pragma once

#include <mutex>
#include <string>
#include <thread>

namespace roadbalance::test {

/// A CAN adapter on a serial line, played by the test; its interface is one of the kernel's driver slcan,
/// with the controller states of a real one.  Gone at the end.
class SerialCan {
 public:
  /// @throws std::system_error
  SerialCan();
  SerialCan(const SerialCan&) = delete;
  SerialCan& operator=(const SerialCan&) = delete;
  ~SerialCan();

  const std::string& interface() const { return interface_; }
  /// Sends a report of the adapter, in its own words: "t1002AABB" a frame, "sb256256" bus-off.
  void report(const std::string& words) const;
  /// All that the kernel sent it, words parted by '|'.
  std::string told() const;

 private:
  int adapter_, line_;
  std::string interface_;
  mutable std::mutex mutex_;
  std::string reported_;
  std::jthread listener_;
};

}  // namespace roadbalance::test
