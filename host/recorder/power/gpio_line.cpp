#include <gpiod.h>

#include <utility>

#include "host/recorder/power/power_line.hpp"

namespace roadbalance {
namespace {

class GpioLine final : public PowerLine {
 public:
  GpioLine(std::string address, std::string chip, unsigned line, bool active_low)
      : address_(std::move(address)), chip_name_(std::move(chip)), number_(line), active_low_(active_low) {}
  ~GpioLine() override { close(); }

  std::optional<bool> is_good() noexcept override {
    if (!line_ && !open()) return std::nullopt;
    const int value = gpiod_line_get_value(line_);
    if (value >= 0) return value > 0;
    close();  // the chip is gone, or is another one when it comes back
    return std::nullopt;
  }
  const std::string& name() const override { return address_; }

 private:
  bool open() noexcept {
    chip_ = gpiod_chip_open_by_name(chip_name_.c_str());
    if (!chip_) return false;
    line_ = gpiod_chip_get_line(chip_, number_);
    const int flags = active_low_ ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
    if (line_ && gpiod_line_request_input_flags(line_, "roadbalance power", flags) == 0) return true;
    close();
    return false;
  }

  // Closing a chip releases its lines.
  void close() noexcept {
    if (chip_) gpiod_chip_close(chip_);
    chip_ = nullptr;
    line_ = nullptr;
  }

  const std::string address_;
  const std::string chip_name_;
  const unsigned number_;
  const bool active_low_;
  gpiod_chip* chip_ = nullptr;
  gpiod_line* line_ = nullptr;
};

}  // namespace

std::unique_ptr<PowerLine> open_gpio_line(std::string address, std::string chip, unsigned line,
                                          bool active_low) {
  return std::make_unique<GpioLine>(std::move(address), std::move(chip), line, active_low);
}

}  // namespace roadbalance
