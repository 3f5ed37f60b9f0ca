#include "tools/datum/vehicle_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/config/section.hpp"
#include "common/config/text_file.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

class VehicleFile : public testing::Test {
 protected:
  VehicleFile() { std::ofstream(file_) << text_; }

  const test::TemporaryDirectory folder_;
  const std::string file_ = folder_ / "car.toml";
  const std::string text_ = test::read_source("sim/demo/vehicle.toml");
  const TablePath encoder_{{"wheel", "rear_left"}, {"encoder"}};
};

TEST_F(VehicleFile, ChangesWhatIsSaidAndKeepsTheOldFileBesideIt) {
  std::filesystem::permissions(file_, std::filesystem::perms(0640));
  const std::string link = folder_ / "link.toml";
  std::filesystem::create_symlink("car.toml", link);
  check_vehicle_file(link, {{encoder_, "datum_deg", "76.25"}});
  EXPECT_EQ(read_text_file(file_), text_);
  set_in_vehicle_file(link, {{encoder_, "datum_deg", "76.25"}, {encoder_, "datum_sigma_deg", "0.5"}});
  std::string expected = text_;
  expected.replace(expected.find("datum_deg = 75"), 14, "datum_deg = 76.25\ndatum_sigma_deg = 0.5");
  EXPECT_EQ(read_text_file(file_), expected);
  EXPECT_EQ(read_text_file(file_ + ".bak"), text_);
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(std::filesystem::status(file_).permissions(), std::filesystem::perms(0640));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 3);
}

TEST_F(VehicleFile, WritesNothingThatTheProgramsWouldRefuse) {
  for (const ValueToSet& bad : {ValueToSet{encoder_, "datum_deg", "400"}, ValueToSet{encoder_, "datum", "4"},
                                ValueToSet{{{"wheel", "spare"}}, "line", "1"}}) {
    EXPECT_THROW(check_vehicle_file(file_, {bad}), ConfigError) << bad.key;
    EXPECT_THROW(set_in_vehicle_file(file_, {bad}), ConfigError) << bad.key;
  }
  EXPECT_EQ(read_text_file(file_), text_);
  EXPECT_FALSE(std::filesystem::exists(file_ + ".bak"));
  EXPECT_THROW(set_in_vehicle_file(folder_ / "none.toml", {}), std::system_error);
}

}  // namespace
}  // namespace roadbalance
