// A set-up that all nodes have taken, and whose file the disk does not take.
#include <gtest/gtest.h>

#include <cerrno>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/control_messages.hpp"
#include "common/record/folder.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "common/test/source.hpp"
#include "common/types/text_crc.hpp"
#include "host/recorder/control/set_up.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;

/// A set-up on a disk that fails as the test wants; its two nodes take every text.
class SetUpDiskTest : public testing::Test {
 protected:
  using Fault = std::function<bool(test::DiskCall)>;
  SetUpDiskTest() {
    const std::string car = test::read_source("sim/demo/vehicle.toml");
    disk.mkdir("/cars", 0755);
    disk.put("/cars/car.toml", {car.begin(), car.end()});
    disk.put("/cars/other.toml", {car.begin(), car.end()});
    disk.mkdir("/recordings", 0755);
    sync_folder("/", disk);  // names of folders are lost by a power cut, too
    set_up.emplace("/cars/car.toml", "/recordings", 1, disk);
  }
  void fail(Fault fault) {
    disk.set_fault([this, fault](test::DiskCall call, std::int64_t, const std::string&) {
      tries += call == test::DiskCall::kRename;
      return test::SimulatedDisk::Outcome{.error = fault(call) ? EIO : 0};
    });
  }
  Answer ask(Operation operation = Operation::kRange) {
    return set_up->take({.asker = 1,
                         .request = 1,
                         .operation = operation,
                         .node = 1,
                         .channel = 0,
                         .value = {50, 0},
                         .text = "other.toml"},
                        {1, 2}, 1'000'000, now);
  }
  /// @return the last word, if it comes within so many seconds
  std::optional<Answer> wait(double seconds) {
    std::vector<Reply> replies;
    const Publish publish = [&](const std::string& channel, std::span<const std::uint8_t> bytes) {
      const auto command = decode_command(bytes);
      if (!channel.starts_with("RB_COMMAND_") || !command) return true;
      measures_by[command->node] = command->vehicle_crc32c;
      replies.push_back({.node = command->node, .epoch = 1, .request = command->request, .sequence = 1});
      return true;
    };
    for (const WallTime end = now + milliseconds(std::llround(1000 * seconds)); now < end;) {
      const auto answer = set_up->turn(publish, 1'000'000, now += milliseconds(50));
      if (answer) return answer;
      for (const Reply& reply : std::exchange(replies, {})) set_up->take(reply);
    }
    return std::nullopt;
  }
  std::string on_disk(const char* path = "/cars/car.toml") {
    const auto bytes = disk.content(path);
    return {bytes.begin(), bytes.end()};
  }
  /// The text that a recorder after this one would lead.
  std::uint32_t led_after_a_kill() {
    disk.kill();
    disk.set_fault({});
    const class SetUp next("/cars/car.toml", "/recordings", 2, disk);
    return next.crc32c();
  }
  void expect_nodes_measure_by(std::uint32_t crc) {
    EXPECT_EQ(measures_by, (std::map<std::int32_t, std::uint32_t>{{1, crc}, {2, crc}}));
  }

  test::SimulatedDisk disk;
  std::optional<class SetUp> set_up;
  WallTime now{};
  int tries = 0;
  std::map<std::int32_t, std::uint32_t> measures_by;  // [node] CRC of the text
};

TEST_F(SetUpDiskTest, IsUnderWayUntilTheDiskTakesTheFile) {
  const std::string before = on_disk();
  ASSERT_EQ(ask().state, AnswerState::kUnderWay);
  fail([](test::DiskCall call) { return call == test::DiskCall::kRename; });
  EXPECT_FALSE(wait(10)) << "nothing is done that the disk does not have";
  EXPECT_GE(tries, 9);
  EXPECT_LE(tries, 11) << "a disk in distress is not hammered";
  EXPECT_EQ(on_disk(), before);
  disk.set_fault({});
  const auto answer = wait(2);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->state, AnswerState::kDone) << answer->text;
  EXPECT_NE(on_disk(), before);
  expect_nodes_measure_by(crc32c(on_disk()));
  EXPECT_EQ(led_after_a_kill(), crc32c(on_disk()));
}

TEST_F(SetUpDiskTest, IsUndoneAtTheNodesIfTheDiskTakesTheFileNeither) {
  const std::uint32_t before = crc32c(on_disk());
  ASSERT_EQ(ask().state, AnswerState::kUnderWay);
  fail([](test::DiskCall) { return true; });
  const auto answer = wait(60);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->state, AnswerState::kRefused);
  EXPECT_EQ(answer->reason, RefusalReason::kDisk);
  EXPECT_NE(answer->text.find("could not be written"), std::string::npos) << answer->text;
  EXPECT_NE(answer->text.find("may be the new one"), std::string::npos)
      << "it cannot be read: " << answer->text;
  EXPECT_FALSE(set_up->is_under_way());
  EXPECT_EQ(set_up->crc32c(), before);
  expect_nodes_measure_by(before);
  EXPECT_EQ(led_after_a_kill(), before);
}

// The new name is there, and only its folder's sync fails: a recorder that is started next reads the new
// text, so the nodes must not get the old one back.
TEST_F(SetUpDiskTest, ANameThatIsThereAndNotSyncedIsInForceAndSaidToBeUnsure) {
  const std::string before = on_disk();
  ASSERT_EQ(ask().state, AnswerState::kUnderWay);
  bool of_a_folder = false;
  fail([&](test::DiskCall call) {
    if (call == test::DiskCall::kWrite || call == test::DiskCall::kRename)
      of_a_folder = call == test::DiskCall::kRename;
    return of_a_folder && call == test::DiskCall::kSync;
  });
  const auto answer = wait(60);
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->state, AnswerState::kDone) << answer->text;
  EXPECT_NE(answer->text.find("does not confirm"), std::string::npos) << answer->text;
  EXPECT_GE(tries, 20);
  ASSERT_NE(on_disk(), before);
  expect_nodes_measure_by(crc32c(on_disk()));
  EXPECT_EQ(led_after_a_kill(), crc32c(on_disk()));
}

// As above, but for so long that the file cannot even be read when it is decided: the file follows the nodes.
TEST_F(SetUpDiskTest, AFileThatTurnsOutToBeTheNewOneAfterTheNodesAreUndoneIsPutBack) {
  const std::uint32_t before = crc32c(on_disk());
  ASSERT_EQ(ask().state, AnswerState::kUnderWay);
  int failing_from = 0;  // the first rename works; what follows does not
  fail([&](test::DiskCall call) {
    if (failing_from > 0) return true;
    failing_from += call == test::DiskCall::kRename;
    return false;
  });
  EXPECT_FALSE(wait(5));
  EXPECT_NE(crc32c(on_disk()), before) << "the first try has renamed it";
  while (measures_by[1] != before && now < WallTime{} + std::chrono::seconds(60)) ASSERT_FALSE(wait(0.05));
  disk.set_fault({});
  const auto answer = wait(5);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->reason, RefusalReason::kDisk);
  expect_nodes_measure_by(before);
  EXPECT_EQ(led_after_a_kill(), before);
}

TEST_F(SetUpDiskTest, AChosenFileThatCannotBeRememberedIsUndone) {
  const std::string other = on_disk() + "\n# another car\n";
  disk.put("/cars/other.toml", {other.begin(), other.end()});
  const std::uint32_t before = crc32c(on_disk());
  ASSERT_EQ(ask(Operation::kVehicle).state, AnswerState::kUnderWay);
  fail([](test::DiskCall call) { return call == test::DiskCall::kWrite; });
  const auto answer = wait(60);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->reason, RefusalReason::kDisk) << answer->text;
  EXPECT_EQ(set_up->file(), "/cars/car.toml");
  expect_nodes_measure_by(before);
  EXPECT_EQ(led_after_a_kill(), before);
}

}  // namespace
}  // namespace roadbalance
