#include "host/recorder/control/set_up.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "common/bus/bus.hpp"
#include "common/bus/control_messages.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;

constexpr int kChannel = 2;
constexpr double kTrueScale = 2.4e-5, kZero_counts = 5000.0;  // of the sensor at node 1, channel 3

/// The demonstration car's file, its front node on the bus, and a person who asks.
class SetUpTest : public testing::Test {
 protected:
  /// Three seconds of rest: the channel reads so many g, the others nothing.
  void lie(double g) {
    for (int b = 0; b < 320; ++b) {
      ScanBlock block{.header = {.node = 1, .epoch = 7, .scans = 20}};
      for (auto& row : block.counts)
        row[kChannel] = static_cast<std::int32_t>(std::lround(kZero_counts + g * 9.80665 / kTrueScale));
      now += milliseconds(10);
      set_up.take(block, now);
    }
  }
  Answer read(double arrow) {
    const Request request{.asker = 1,
                          .request = ++requests,
                          .operation = Operation::kScale,
                          .node = 1,
                          .channel = kChannel,
                          .value = {arrow, 0}};
    return set_up.take(request, {1}, 1'000'000, now);
  }
  /// The node takes every text.
  Answer obeyed() {
    const Publish publish = [this](const std::string& channel, std::span<const std::uint8_t> bytes) {
      if (channel != command_channel(1)) return true;
      const auto command = decode_command(bytes);
      if (command)
        replies.push_back({.node = 1,
                           .epoch = 7,
                           .request = command->request,
                           .result = CommandError::kNone,
                           .sequence = 1});
      return true;
    };
    for (int k = 0; k < 10; ++k) {
      const auto answer = set_up.turn(publish, 1'000'000, now += milliseconds(10));
      if (answer) return *answer;
      for (const Reply& reply : replies) set_up.take(reply);
    }
    ADD_FAILURE() << "no last word";
    return {};
  }
  ChannelConfig in_file() const { return VehicleConfig::read_file(file.string()).node[0].channel[kChannel]; }

  test::TemporaryDirectory folder;
  const std::filesystem::path file = folder.path() / "car.toml";
  struct Written {
    explicit Written(const std::filesystem::path& path) {
      std::ofstream(path) << test::read_source("sim/demo/vehicle.toml");
    }
  } written{file};
  class SetUp set_up {
    file, folder.path(), 1
  };  // testing::Test has a function of this name
  WallTime now{};
  std::int64_t requests = 0;
  std::vector<Reply> replies;
};

TEST_F(SetUpTest, ASensorTurnedOverGivesItsChannelScaleAndElectricalZero) {
  lie(1.0);
  const Answer first = read(1.0);
  EXPECT_EQ(first.state, AnswerState::kDone) << first.text;
  EXPECT_NE(first.text.find("arrow down"), std::string::npos) << first.text;
  EXPECT_FALSE(set_up.is_under_way()) << "one reading changes nothing";
  lie(-1.0);
  const Answer second = read(-1.0);
  ASSERT_EQ(second.state, AnswerState::kUnderWay) << second.text;
  const Answer done = obeyed();
  EXPECT_EQ(done.state, AnswerState::kDone) << done.text;
  // A count of the mean is 1e-6 of the difference; the zero is written to a tenth of a count.
  EXPECT_NEAR(in_file().scale_m_s2_per_count, kTrueScale, 3e-6 * kTrueScale);
  EXPECT_NEAR(in_file().offset_counts, kZero_counts, 1.0);
}

TEST_F(SetUpTest, ASensorThatWasNotTurnedOverChangesNothing) {
  const double before = in_file().scale_m_s2_per_count;
  lie(1.0);
  read(1.0);
  lie(1.0);
  const Answer second = read(-1.0);
  EXPECT_EQ(second.state, AnswerState::kRefused);
  EXPECT_NE(second.text.find("Begin again"), std::string::npos) << second.text;
  EXPECT_EQ(in_file().scale_m_s2_per_count, before);
}

TEST_F(SetUpTest, AScaleWantsAChannelAndAWay) {
  lie(1.0);
  EXPECT_EQ(read(0.5).reason, RefusalReason::kBadArgument);
  const Request nowhere{
      .asker = 1, .request = 99, .operation = Operation::kScale, .node = 9, .channel = 0, .value = {1, 0}};
  EXPECT_EQ(set_up.take(nowhere, {1}, 1, now).reason, RefusalReason::kBadArgument);
}

TEST_F(SetUpTest, ADatumIsInForceAtTheNodesAndInTheFile) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  const Request request{.asker = 1,
                        .request = 7,
                        .operation = Operation::kDatum,
                        .channel = 0,
                        .value = {31.5 * kDegree, 0.8 * kDegree}};
  ASSERT_EQ(set_up.take(request, {1}, 1'000'000, now).state, AnswerState::kUnderWay);
  EXPECT_NEAR(VehicleConfig::read_file(file.string()).wheel[0].encoder.datum_rad, 30.0 * kDegree, 1e-12)
      << "not before the node has it";
  const Answer done = obeyed();
  EXPECT_EQ(done.state, AnswerState::kDone) << done.text;
  EXPECT_EQ(done.text.rfind(
                "front_left: its zero mark fires at 31.50 ± 0.80 deg (at node 1; not on the bus: node 2", 0),
            0U)
      << done.text;
  const EncoderConfig encoder = VehicleConfig::read_file(file.string()).wheel[0].encoder;
  EXPECT_NEAR(encoder.datum_rad, 31.5 * kDegree, 1e-12);
  EXPECT_NEAR(encoder.datum_sigma_rad, 0.8 * kDegree, 1e-12);
}

}  // namespace
}  // namespace roadbalance
