#include "hil_tests/guest/device_measurement.hpp"

#include <algorithm>
#include <fstream>

#include "common/config/text_file.hpp"
#include "common/test/source.hpp"

namespace roadbalance::test {

void DeviceMeasurement::wire(const std::string& wiring, int rate_hz) const {
  std::string text = read_source("sim/demo/vehicle.toml");
  const std::string rate = "rate_hz = 2000";
  for (std::size_t at; (at = text.find(rate)) != std::string::npos;)
    text.replace(at, rate.size(), "rate_hz=" + std::to_string(rate_hz));
  text.insert(text.find("[[node.channel]]"), wiring);
  std::ofstream(vehicle_file) << text;
}

Program DeviceMeasurement::device_node(const std::vector<std::string>& devices) const {
  std::vector<std::string> words{"--vehicle", vehicle_file, "--node", "front", "--url", url};
  for (const std::string& device : devices) words.insert(words.end(), {"--front-end", device});
  return {"rb-node", words, said_file};
}

std::int64_t DeviceMeasurement::count_of(DeviceCounter counter) const {
  return bus.heartbeat(kFront).device_counts[static_cast<std::size_t>(counter)];
}

bool DeviceMeasurement::counted(DeviceCounter counter, std::int64_t times) {
  return bus.wait([&] { return count_of(counter) == times; });
}

std::string DeviceMeasurement::said() const {
  return read_text_file(said_file);
}

void DeviceMeasurement::expect_said(const std::string& device,
                                    const std::vector<std::string>& sentences) const {
  const std::string printed = said();
  const std::vector<std::string> notes = verify_record(record).notes;
  for (const std::string& sentence : sentences) {
    EXPECT_NE(printed.find(device + ": " + sentence), std::string::npos)
        << sentence << " is not in: " << printed;
    const auto says_it = [&](const std::string& note) {
      return note.find("devices of node 1") != std::string::npos && note.find(sentence) != std::string::npos;
    };
    EXPECT_TRUE(std::ranges::any_of(notes, says_it)) << sentence << " is no note of the record";
  }
}

std::vector<VerifiedGap> DeviceMeasurement::gaps() const {
  const Verification verified = verify_record(record);
  EXPECT_EQ(verified.verdict, Verdict::kIncomplete) << verdict_text(verified);
  EXPECT_EQ(verified.epoch.size(), 1U);
  if (verified.epoch.size() != 1) return {};
  EXPECT_FALSE(verified.epoch[0].is_damaged());
  return verified.epoch[0].gaps;
}

}  // namespace roadbalance::test
