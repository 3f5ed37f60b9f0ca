#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/config/section.hpp"
#include "common/record/record_reader.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "tools/import/import_samples.hpp"

namespace roadbalance {

namespace fs = std::filesystem;
inline constexpr double kRate_hz = 500.0;

class ImportSamples : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  fs::path data(const std::string& name) { return test::source_path("tools/rb/test/data/" + name); }

  std::string error_of(const std::string& samples, const VehicleConfig& vehicle,
                       const std::string& pulses = "") {
    try {
      SampleImport import{.samples = write("s.csv", samples), .pulses = {}, .folder = folder_ / "record"};
      if (!pulses.empty()) import.pulses = write("p.csv", pulses);
      import_samples(import, vehicle);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  }

  std::vector<SealedBlock> blocks_of_record() {
    RecordReader reader(folder_ / "record");
    std::vector<SealedBlock> blocks;
    while (const auto event = reader.next()) {
      SealedBlock block;
      if (accept(event->data, block) == Refusal::kNone && block.header.sequence > 0) blocks.push_back(block);
    }
    return blocks;
  }

  test::TemporaryDirectory directory_;
  const fs::path folder_ = directory_.path();
};

inline VehicleConfig two_nodes() {
  VehicleConfig vehicle{};
  for (std::size_t w = 0; w < kWheels; ++w) vehicle.wheel[w].name = kWheelNames[w];
  vehicle.wheel[0].node = "second";
  vehicle.wheel[0].line = 1;
  vehicle.wheel[0].encoder.pulses_per_turn = 4;
  int id = 1;
  for (const char* name : {"first", "second"}) {
    ChannelConfig channel;
    channel.name = std::string(name) + "_up";
    channel.mount = "body";
    channel.range_m_s2 = 50.0;
    channel.scale_m_s2_per_count = 50.0 / kFullScaleCounts;
    channel.offset_counts = 1000.0;
    vehicle.node.push_back({.name = name, .id = id++, .rate_hz = kRate_hz, .channel = {channel}});
  }
  vehicle.text = "# two nodes";
  return vehicle;
}

/// Two channels, value = row and 1000 + row in milli-units, with time by `stamp`.
inline std::string samples(std::size_t rows, const std::function<double(std::size_t)>& stamp_s) {
  std::string text = "time_s,second_up,first_up\ns,g,m/s^2\n";
  char line[80];
  for (std::size_t i = 0; i < rows; ++i) {
    std::snprintf(line, sizeof line, "%.6f,%.4f,%.4f\n", stamp_s(i), 0.001 * static_cast<double>(i % 1000),
                  0.002 * static_cast<double>(i % 1000));
    text += line;
  }
  return text;
}

inline double uniform(std::size_t i) {
  return 2.0 + static_cast<double>(i) / kRate_hz;
}

}  // namespace roadbalance
