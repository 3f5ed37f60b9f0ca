#include "common/gpio/gpio_chip.hpp"

#include <gtest/gtest.h>

#include <string>

namespace roadbalance {
namespace {

std::string refusal(const std::string& chip) {
  try {
    const GpioChip opened(chip);
  } catch (const GpioError& error) {
    return error.what();
  }
  return "";
}

// Chips that are there are tested in the guest machine: gpio_source_test and power_line_test of
// hil_tests/guest.
TEST(GpioChip, NamesTheChipThatIsNotThereAndTheFileThatIsNone) {
  EXPECT_EQ(refusal("gpiochip99999"), "GPIO chip gpiochip99999: No such file or directory");
  EXPECT_NE(refusal("null").find("GPIO chip null: "), std::string::npos)
      << "/dev/null is a device, but no chip";
}

}  // namespace
}  // namespace roadbalance
