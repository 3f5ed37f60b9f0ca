#include "host/recorder/power/power_line.hpp"

#include <charconv>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "common/gpio/gpio_chip.hpp"

namespace roadbalance {
namespace {

class SupplyState final : public PowerLine {
 public:
  SupplyState(std::string address, std::filesystem::path file)
      : address_(std::move(address)), file_(std::move(file)) {}

  std::optional<bool> is_good() noexcept override {
    try {
      int online = -1;
      if (!(std::ifstream(file_) >> online) || online < 0) return std::nullopt;
      return online > 0;  // 2 is a supply that could give more
    } catch (const std::exception&) {
      return std::nullopt;  // no memory for the stream's buffer
    }
  }
  const std::string& name() const override { return address_; }

 private:
  const std::string address_;
  const std::filesystem::path file_;
};

// A chip or line that is not there, or goes, is no error: it is tried again at each reading.
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

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> words(1);
  for (const char c : text)
    if (c == ':')
      words.emplace_back();
    else
      words.back() += c;
  return words;
}

bool is_file_name(const std::string& name) {
  return !name.empty() && name != "." && name != ".." && name.find('/') == std::string::npos;
}

std::optional<unsigned> line_number(const std::string& text) {
  unsigned number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace

std::unique_ptr<PowerLine> open_power_line(const std::string& address, const std::filesystem::path& sys) {
  const auto words = split(address);
  if (words[0] == "supply" && words.size() == 2 && is_file_name(words[1]))
    return std::make_unique<SupplyState>(address, sys / "class/power_supply" / words[1] / "online");
  if (words[0] == "gpio" && (words.size() == 3 || (words.size() == 4 && words[3] == "low")) &&
      is_file_name(words[1]))
    if (const auto line = line_number(words[2]))
      return std::make_unique<GpioPowerLine>(address, words[1], *line, words.size() == 4);
  throw std::invalid_argument("power line " + address +
                              ": neither supply:NAME nor gpio:CHIP:LINE nor gpio:CHIP:LINE:low");
}

}  // namespace roadbalance
