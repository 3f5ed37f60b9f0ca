#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace roadbalance {

/// Reads whether the supply is there: 12 V on board, 220 V at the bench.
class PowerLine {
 public:
  PowerLine() = default;
  PowerLine(const PowerLine&) = delete;
  PowerLine& operator=(const PowerLine&) = delete;
  virtual ~PowerLine() = default;

  /// Nothing if it cannot be read now: the chip is unplugged, the file is gone.  Never waits.
  virtual std::optional<bool> is_good() noexcept = 0;
  /// As given on the command line.
  virtual const std::string& name() const = 0;
};

/// "supply:NAME": class/power_supply/NAME/online below `sys` holds 1.
/// "gpio:CHIP:LINE" or "gpio:CHIP:LINE:low": the line of a GPIO chip is high, or low, while the supply is
/// there; a chip or line that is not there, or goes, is no error: it is tried again at each reading.
/// @param sys  where the kernel's tree of devices is
/// @throws std::invalid_argument naming the address if it is neither of these
std::unique_ptr<PowerLine> open_power_line(const std::string& address,
                                           const std::filesystem::path& sys = "/sys");

}  // namespace roadbalance
