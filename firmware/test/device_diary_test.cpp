#include "firmware/device_diary.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

TEST(DeviceDiary, SaysWhatHasMovedSinceItWasLastAskedAndOnlyThat) {
  DeviceReport can("can:can0"), gpio("gpio:gpiochip0");
  DeviceDiary diary({&can, &gpio});
  std::vector<std::string> sentences;
  const auto look = [&] {
    sentences.clear();
    diary.look([&](const std::string& sentence) { sentences.push_back(sentence); });
  };
  look();
  EXPECT_TRUE(sentences.empty());
  can.count(DeviceCounter::kGone);
  look();
  EXPECT_EQ(sentences, (std::vector<std::string>{"can:can0: was unplugged or went down (1 time by now)"}));
  look();
  EXPECT_TRUE(sentences.empty());
  can.count(DeviceCounter::kGone, 2);
  can.count(DeviceCounter::kReturned, 3);
  gpio.count(DeviceCounter::kEdgesLost, 70);
  look();
  EXPECT_EQ(sentences,
            (std::vector<std::string>{"can:can0: was unplugged or went down (3 times by now)",
                                      "can:can0: is there again (3 times by now)",
                                      "gpio:gpiochip0: encoder edges are missing (70 times by now)"}));
}

// A counter without words would be reported as nothing.
TEST(DeviceReport, HasANameAndASentenceOfItsOwnForEveryCounter) {
  for (std::size_t k = 0; k < kDeviceCounters; ++k) {
    const auto counter = static_cast<DeviceCounter>(k);
    EXPECT_FALSE(std::string(name_of(counter)).empty()) << k;
    EXPECT_FALSE(std::string(sentence(counter)).empty()) << k;
    for (std::size_t other = 0; other < k; ++other)
      EXPECT_STRNE(name_of(counter), name_of(static_cast<DeviceCounter>(other)));
  }
}

}  // namespace
}  // namespace roadbalance
