#include <utility>

#include "common/gpio/gpio_chip.hpp"
#include "host/recorder/power/power_line.hpp"

namespace roadbalance {
namespace {

class GpioPowerLine final : public PowerLine {
 public:
  GpioPowerLine(std::string address, std::string chip, unsigned line, bool active_low)
      : address_(std::move(address)), chip_name_(std::move(chip)), number_(line), active_low_(active_low) {}

  std::optional<bool> is_good() noexcept override {
    if (!chip_ && !open()) return std::nullopt;
    const std::optional<bool> good = chip_->level(0);
    if (!good) chip_.reset();  // the chip is gone, or is another one when it comes back
    return good;
  }
  const std::string& name() const override { return address_; }

 private:
  bool open() noexcept {
    try {
      GpioChip chip(chip_name_, identity_);
      chip.take_level(number_, active_low_, "roadbalance power");
      if (identity_.label.empty()) identity_ = chip.identity();
      chip_ = std::move(chip);
      return true;
    } catch (const std::exception&) {
      return false;
    }
  }

  const std::string address_;
  const std::string chip_name_;
  const unsigned number_;
  const bool active_low_;
  GpioChip::Identity identity_;  // of the chip that was opened first
  std::optional<GpioChip> chip_;
};

}  // namespace

std::unique_ptr<PowerLine> open_gpio_line(std::string address, std::string chip, unsigned line,
                                          bool active_low) {
  return std::make_unique<GpioPowerLine>(std::move(address), std::move(chip), line, active_low);
}

}  // namespace roadbalance
