#include "tools/doctor/accuracy.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>

#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

class Accuracy : public testing::Test {
 protected:
  void replace(const std::string& pattern, const std::string& by) {
    const std::string before = text_;
    text_ = std::regex_replace(text_, std::regex(pattern), by);
    EXPECT_NE(text_, before) << pattern;
  }
  /// The same for the first only.
  void replace_first(const std::string& what, const std::string& by) {
    const auto at = text_.find(what);
    ASSERT_NE(at, std::string::npos) << what;
    text_.replace(at, what.size(), by);
  }
  /// The demonstration's car as a careful owner would describe it.
  void SetUp() override {
    replace("\\n[a-z0-9_]*sigma[a-z0-9_]* = 0(?=\\n)", "");
    replace("datum_deg = ([-0-9]+)\\n", "datum_deg = $1\ndatum_sigma_deg = 0.5\n");
  }
  std::string names() {
    std::string all;
    reported_.clear();
    for (const Finding& finding : accuracy_findings(VehicleConfig::parse(text_, "car.toml"), "car.toml")) {
      EXPECT_EQ(finding.state == Finding::kWell, finding.remedy.empty()) << finding.sentence;
      static constexpr const char* kMark[] = {"+", "-", "!"};
      all += (all.empty() ? "" : " ") + std::string(kMark[finding.state]) + finding.name;
      reported_ += finding.sentence + " " + finding.remedy + "\n";
    }
    return all;
  }
  bool says(const std::string& words) const { return reported_.find(words) != std::string::npos; }

  std::string text_ = test::read_source("sim/demo/vehicle.toml"), reported_;
};

TEST_F(Accuracy, OfACarefullyDescribedCarIsWell) {
  EXPECT_EQ(names(), "+accuracy") << reported_;
}

TEST_F(Accuracy, IsNotKnownWhereASigmaOfTheSimulatedCarWasLeft) {
  replace_first("mass_kg = 34\n", "mass_kg = 34\nmass_sigma_kg = 0\n");
  EXPECT_EQ(names(), "-sigma");
  EXPECT_TRUE(says("mass_sigma_kg")) << reported_;
  EXPECT_FALSE(says("body_mass_sigma_kg")) << reported_;
  text_ = test::read_source("sim/demo/vehicle.toml");
  EXPECT_EQ(names(), "-datum -sigma");
  EXPECT_TRUE(
      says("body_mass_sigma_kg, roll_inertia_sigma_kg_m2, pitch_inertia_sigma_kg_m2, "
           "tyre_damper_sigma_n_s_m, mass_sigma_kg"))
      << reported_;
}

TEST_F(Accuracy, OfAnAngleTakesAZeroMarkAndItsDatum) {
  replace_first("datum_deg = 30\ndatum_sigma_deg = 0.5\n", "");
  replace_first("datum_deg = 75\ndatum_sigma_deg = 0.5\n", "datum_deg = 75\n");
  EXPECT_EQ(names(), "-datum -datum");
  EXPECT_TRUE(says("front_left: nobody has found")) << reported_;
  EXPECT_TRUE(says("rear_left: how well")) << reported_;
  EXPECT_TRUE(says("rb datum --vehicle car.toml --wheel front_left")) << reported_;
  replace_first("zero_mark = true\n", "zero_mark = false\n");
  EXPECT_EQ(names(), "-angle -datum");
  EXPECT_TRUE(says("front_left: its encoder has no zero mark")) << reported_;
}

TEST_F(Accuracy, TheRemedyOfExactSigmasMendsThem) {
  const test::TemporaryDirectory folder;
  const std::string file = folder / "car.toml";
  for (const std::string zero : {"0", "0.0", "0.00  # exactly"}) {
    std::string text = text_;
    text.insert(text.find("mass_kg = 34\n"), "mass_sigma_kg = " + zero + "\n");
    std::ofstream(file) << text;
    const auto found = accuracy_findings(VehicleConfig::parse(text, file), file);
    ASSERT_EQ(found.size(), 1u) << zero;
    EXPECT_EQ(found[0].name, "sigma");
    ASSERT_EQ(std::system(found[0].remedy.c_str()), 0);
    std::stringstream mended;
    mended << std::ifstream(file).rdbuf();
    EXPECT_EQ(accuracy_findings(VehicleConfig::parse(mended.str(), file), file)[0].name, "accuracy") << zero;
  }
}

TEST_F(Accuracy, NamesAWheelWithoutEncoder) {
  replace_first(
      "node = \"rear\"\nline = 1\n[wheel.encoder]\npulses_per_turn = 96\nzero_mark = true\n"
      "datum_deg = 140\ndatum_sigma_deg = 0.5\n",
      "");
  EXPECT_EQ(names(), "-angle");
  EXPECT_TRUE(says("rear_right: no node reads an encoder")) << reported_;
}

TEST_F(Accuracy, NamesWhereSensorsAreMissing) {
  replace_first("name = \"fl_carrier_z\"\n", "name = \"fl_carrier_z\"\nrole = \"unused\"\n");
  EXPECT_EQ(names(), "-sensors");
  EXPECT_TRUE(says("do not determine: front_left: unbalances come from the body alone")) << reported_;
  for (const char* name : {"fl_strut_z", "fr_strut_z", "rl_strut_z"})
    replace_first("name = \"" + std::string(name) + "\"\n",
                  "name = \"" + std::string(name) + "\"\nrole = \"unused\"\n");
  EXPECT_EQ(names(), "!sensors");
  EXPECT_TRUE(says("nothing can be identified")) << reported_;
}

TEST_F(Accuracy, NamesWheelsWithoutPlacesForWeights) {
  replace("\\[\\[wheel.place\\]\\]\\nradius_m = [0-9.]+\\nkind = \"clip\"\\nplane = \"(inner|outer)\"\\n",
          "");
  EXPECT_EQ(names(), "-places");
  EXPECT_TRUE(says("front_left, front_right, rear_left, rear_right: nobody said where weights go"))
      << reported_;
}

}  // namespace
}  // namespace roadbalance
