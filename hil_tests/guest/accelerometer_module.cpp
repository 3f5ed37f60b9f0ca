#include "hil_tests/guest/accelerometer_module.hpp"

#include "firmware/backends/socketcan/accelerometer_frame.hpp"

namespace roadbalance::test {

void AccelerometerModule::convert() {
  AccelerometerFrame frame{.sequence = number_, .part = {}};
  for (std::size_t k = 0; k < frame.sample.size(); ++k)
    frame.sample[k] = static_cast<std::int16_t>(number_ + 1'000 * k);
  ++number_;
  if (is_fd_) return player_.send(write_accelerometer(frame, kFirstId));
  for (int part = 0; part < AccelerometerFrame::kParts; ++part) {
    frame.part = part;
    player_.send(write_accelerometer(frame, kFirstId));
  }
}

}  // namespace roadbalance::test
