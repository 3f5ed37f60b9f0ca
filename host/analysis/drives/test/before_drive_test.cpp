#include "host/analysis/drives/before_drive.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/record_writer.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

const std::string kDemo = test::read_source("sim/demo/vehicle.toml");

/// The demonstration car with a weight on its first wheel.
std::string with_weight(double grams) {
  const std::size_t wheel = kDemo.find("[[wheel]]"), next = kDemo.find("[[wheel]]", wheel + 1);
  return kDemo.substr(0, next) + "[[wheel.weight]]\nmass_g = " + std::to_string(grams) +
         "\nangle_deg = 37\n\n" + kDemo.substr(next);
}

class BeforeDrive : public testing::Test {
 protected:
  /// A recording that begins with this vehicle.toml; each later than the one before.
  void record(const std::string& name, const std::string& vehicle) {
    {
      RecordWriter writer({.folder = folder.path() / name});
      std::int64_t sequence = 0;
      const auto header = [&](std::int64_t scans) {
        return BlockHeader{
            .node = 1, .epoch = 7, .sequence = ++sequence, .first_scan = 0, .scans = scans, .time_ns = 0};
      };
      SealedBlock sealed;
      for (MetaBlock& meta : split_text(MetaKind::kVehicleToml, vehicle)) {
        meta.header = header(0);
        seal(meta, sealed);
        writer.append(block_channel(1, sealed.kind), sealed.bytes(), 0);
      }
      ScanBlock scans;
      scans.header = header(20);
      scans.period_ps = 500'000'000;
      seal(scans, sealed);
      writer.append(block_channel(1, sealed.kind), sealed.bytes(), 1);
      writer.close();
    }
    fs::last_write_time(folder.path() / name, begin_ + ++recorded_ * std::chrono::hours(1));
  }
  std::string found(const std::string& name, const std::string& vehicle) const {
    const auto before =
        drive_before_weights(folder.path() / name, VehicleConfig::parse(vehicle, "vehicle.toml"));
    return before ? before->filename().string() : "none";
  }

  test::TemporaryDirectory folder;
  const fs::file_time_type begin_ = fs::file_time_type::clock::now() - std::chrono::hours(100);
  int recorded_ = 0;
};

TEST_F(BeforeDrive, IsTheNewestWithOtherWeights) {
  record("bare", kDemo);
  record("bare again", kDemo);
  EXPECT_EQ(found("bare again", kDemo), "none") << "nothing was fitted";
  record("weighted", with_weight(30));
  EXPECT_EQ(found("weighted", with_weight(30)), "bare again");
  record("weighted again", with_weight(30));
  EXPECT_EQ(found("weighted again", with_weight(30)), "bare again");
  record("more", with_weight(35));
  EXPECT_EQ(found("more", with_weight(35)), "weighted again");
}

TEST_F(BeforeDrive, IsNoneThatCannotBeCompared) {
  std::string other = kDemo;
  const std::string datum = "datum_deg = 30";
  other.replace(other.find(datum), datum.size(), "datum_deg = 12");
  record("another mark", other);
  record("weighted", with_weight(30));
  fs::create_directories(folder.path() / "no recording");
  std::ofstream(folder.path() / "a file") << "x";
  EXPECT_EQ(found("weighted", with_weight(30)), "none");
}

}  // namespace
}  // namespace roadbalance
