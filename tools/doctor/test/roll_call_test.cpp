#include "tools/doctor/roll_call.hpp"

#include <gtest/gtest.h>

#include "common/bus/recorder_status.hpp"
#include "common/bus/test/foreign_message.hpp"
#include "common/test/bus_url.hpp"
#include "common/test/source.hpp"
#include "common/types/text_crc.hpp"

namespace roadbalance {
namespace {

class Roll : public testing::Test {
 protected:
  Heartbeat beat(std::int32_t node, std::int64_t epoch = 1) const {
    Heartbeat one;
    one.node = node;
    one.epoch = epoch;
    one.vehicle_crc32c = crc32c(car_.text);
    return one;
  }
  void send(const Heartbeat& one) { speaker_.publish(heartbeat_channel(one.node), encode(one)); }
  void send_recorder(std::int64_t number) {
    RecorderStatus status;
    status.recorder = number;
    speaker_.publish(kRecorderChannel, encode(status));
  }
  /// "+nodes -recorder": what is well, and what is not.
  std::string names(const VehicleConfig* vehicle) {
    roll_.listen(std::chrono::milliseconds(0));
    std::string all;
    for (const Finding& finding : roll_.findings(vehicle, "car.toml")) {
      EXPECT_EQ(finding.state == Finding::kWell, finding.remedy.empty()) << finding.sentence;
      static constexpr const char* kMark[] = {"+", "-", "!"};
      all += (all.empty() ? "" : " ") + std::string(kMark[finding.state]) + finding.name;
      reported_ += finding.sentence + finding.remedy + "\n";
    }
    return all;
  }
  const VehicleConfig car_ = VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "vehicle.toml");
  const std::string url_ = test::bus_url();
  Bus speaker_{url_};
  RollCall roll_{url_};
  std::string reported_;
};

TEST_F(Roll, HasAllNodesOfTheCarAndARecorder) {
  send(beat(1));
  send(beat(2));
  send_recorder(7);
  EXPECT_EQ(names(&car_), "+nodes +recorder");
  EXPECT_NE(reported_.find("front (1), rear (2)"), std::string::npos) << reported_;
  EXPECT_EQ(names(nullptr), "+nodes +recorder");
}

TEST_F(Roll, NamesANodeThatIsMissingAndOneThatIsNotOfTheCar) {
  send(beat(1));
  send(beat(9));
  EXPECT_EQ(names(&car_), "!nodes -strangers -recorder");
  EXPECT_NE(reported_.find("Node rear (2) was not heard"), std::string::npos) << reported_;
  EXPECT_NE(reported_.find("rb-node --vehicle car.toml --node rear --url '" + url_), std::string::npos)
      << reported_;
  EXPECT_NE(reported_.find("not in car.toml: node 9"), std::string::npos) << reported_;
}

TEST_F(Roll, OfASilentBusSaysSo) {
  EXPECT_EQ(names(nullptr), "-nodes -recorder");
  EXPECT_EQ(names(&car_), "!nodes !nodes -recorder");
}

TEST_F(Roll, TellsTwoNodesOfOneNumberFromOneThatWasStartedAgain) {
  for (const std::int64_t epoch : {11, 11, 12, 12}) send(beat(1, epoch));
  send(beat(2));
  send_recorder(7);
  EXPECT_EQ(names(&car_), "+nodes +recorder");
  send(beat(1, 11));
  EXPECT_EQ(names(&car_), "!two_nodes +recorder");
}

// A node that was started again may speak of its former epoch until all of that is recorded.
TEST_F(Roll, OfAnEpochThatIsOverIsNoSecondNode) {
  Heartbeat over = beat(1, 11);
  over.state = NodeState::kEnded;
  for (const Heartbeat& one : {over, beat(1, 12), over, beat(1, 12), beat(2)}) send(one);
  EXPECT_EQ(names(&car_), "+nodes -recorder");
}

TEST_F(Roll, NamesWhoIsOfAnotherVersionOfTheWire) {
  send(beat(1));
  speaker_.publish(heartbeat_channel(2), test::of_another_version(encode(beat(2))));
  EXPECT_EQ(names(&car_), "!other_version -recorder");
  EXPECT_NE(reported_.find("node rear (2)"), std::string::npos) << reported_;
}

TEST_F(Roll, NamesWhoMeasuresByAnotherFileAndASecondRecorder) {
  Heartbeat other = beat(1);
  ++other.vehicle_crc32c;
  send(other);
  send(beat(2));
  send_recorder(7);
  send_recorder(8);
  EXPECT_EQ(names(&car_), "-vehicle_file -recorder");
  EXPECT_NE(reported_.find("node front (1)"), std::string::npos) << reported_;
}

}  // namespace
}  // namespace roadbalance
