#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace roadbalance {

/// "1209:0001"
std::string usb_name(std::uint16_t vendor, std::uint16_t product);

/// Which USB board, or which two boards, a node reads.
struct UsbAddress {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  /// One for each board: the first is the master.  Empty: the one board of this kind there is.
  std::vector<std::string> serial;

  std::size_t boards() const { return serial.empty() ? 1 : serial.size(); }
  /// "usb:1209:0001:A17", of board k.
  std::string of_board(std::size_t k) const;

  /// @param address  "VENDOR:PRODUCT", "VENDOR:PRODUCT:SERIAL" or "VENDOR:PRODUCT:SERIAL+SERIAL", both
  /// numbers
  ///                 hexadecimal
  /// @throws ConfigError
  static UsbAddress parse(const std::string& address);
};

}  // namespace roadbalance
