#include "firmware/backends/usb/usb_address.hpp"

#include <array>
#include <charconv>
#include <cstdio>

#include "common/config/section.hpp"
#include "firmware/board/protocol.hpp"

namespace roadbalance {
namespace {

[[noreturn]] void refuse(const std::string& address, const std::string& reason) {
  throw ConfigError("front end \"usb:" + address + "\": " + reason +
                    "; allowed: usb:VENDOR:PRODUCT, usb:VENDOR:PRODUCT:SERIAL or "
                    "usb:VENDOR:PRODUCT:SERIAL+SERIAL, numbers hexadecimal, e.g. usb:1209:0001");
}

std::uint16_t parse_number(const std::string& address, const std::string& text) {
  std::uint16_t number = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, number, 16);
  if (text.size() > 4 || error != std::errc() || end != last)
    refuse(address, "'" + text + "' is no number of up to four hexadecimal digits");
  return number;
}

}  // namespace

UsbAddress UsbAddress::parse(const std::string& address) {
  const auto first = address.find(':');
  if (first == std::string::npos) refuse(address, "no product");
  const auto second = address.find(':', first + 1);
  UsbAddress usb;
  usb.vendor = parse_number(address, address.substr(0, first));
  usb.product = parse_number(address, address.substr(first + 1, second - first - 1));
  if (second == std::string::npos) return usb;
  for (std::size_t begin = second + 1; begin <= address.size();) {
    const auto end = std::min(address.find('+', begin), address.size());
    usb.serial.push_back(address.substr(begin, end - begin));
    if (usb.serial.back().empty() || usb.serial.back().size() > board::kSerialBytes)
      refuse(address, "'" + usb.serial.back() + "' is no serial number of 1 to 16 characters");
    begin = end + 1;
  }
  if (usb.serial.size() > 2)
    refuse(address, std::to_string(usb.serial.size()) + " boards; a node reads at most two");
  if (usb.serial.size() == 2 && usb.serial[0] == usb.serial[1])
    refuse(address, "board " + usb.serial[0] + " stands twice");
  return usb;
}

std::string usb_name(std::uint16_t vendor, std::uint16_t product) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%04x:%04x", vendor, product);
  return text.data();
}

std::string UsbAddress::of_board(std::size_t k) const {
  return "usb:" + usb_name(vendor, product) + (k < serial.size() ? ":" + serial[k] : "");
}

}  // namespace roadbalance
