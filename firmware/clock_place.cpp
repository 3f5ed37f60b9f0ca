#include "firmware/clock_place.hpp"

#include <system_error>
#include <utility>

namespace roadbalance {

std::string ClockPlace::follow() {
  const std::uint32_t address = address_now_();
  if (socket_ && (address == 0 || address == socket_->address().address)) return {};
  std::string why = "there is no address on the bus";
  try {
    if (address != 0) {
      socket_ = std::make_unique<ClockSocket>(address);
      reported_ = std::uint64_t{address} << 16 | socket_->address().port;
      refused_.reset();
      return {};
    }
  } catch (const std::system_error& error) {
    why = error.what();
  }
  return std::exchange(refused_, address) == address ? std::string() : why;
}

UdpAddress ClockPlace::address() const {
  const std::uint64_t address_and_port = reported_;
  return {static_cast<std::uint32_t>(address_and_port >> 16),
          static_cast<std::uint16_t>(address_and_port & 0xFFFF)};
}

}  // namespace roadbalance
