#include "host/recorder/operating.hpp"

#include <gtest/gtest.h>

#include "common/bus/bus.hpp"
#include "common/bus/control.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr std::int64_t kNow = 1'769'860'805'000'000;
constexpr std::int64_t kBefore = kNow / 1000 + 3'600'000;  // incarnations of "drive": the clock was ahead

/// A recording that runs until it is destroyed.
class Running final : public Session {
 public:
  void stop() override {}
  void note(NoteToRecord) override {}
  View view() const override { return {.report = {}, .status = RecorderStatus{}, .error = ""}; }
};

/// One that has ended with a higher number than it last said.
class Ended final : public Session {
 public:
  void stop() override {}
  void note(NoteToRecord) override {}
  View view() const override {
    return {.report = {.node = {}, .incarnation = kRaised},
            .status = RecorderStatus{.incarnation = kRaised - 1},
            .is_over = true,
            .error = ""};
  }
  static constexpr std::int64_t kRaised = kBefore + 5000;
};

class OperatingTest : public ::testing::Test {
 protected:
  OperatingTest() {
    options.recordings = work.path();
    std::filesystem::create_directory(work.path() / "drive");
    DeskBook book;
    book.over = {{"drive", kBefore, kBefore + 100}};
    write_desk_book(work.path(), book);
  }
  Operating::Time time() const { return {.now = now, .utc_us = utc_us}; }
  /// A node that was started for "drive" is heard.
  void run(milliseconds length) {
    const Heartbeat beat{
        .node = 2, .epoch = 77, .base = 1, .next = 9, .state = NodeState::kStarted, .owner = kBefore + 50};
    for (const WallTime end = now + length; now < end; now += milliseconds(100), utc_us += 100'000) {
      operating->take(heartbeat_channel(2), encode(beat), time());
      (void)operating->turn(false, time(), [](const std::string&, auto) { return true; });
    }
  }

  test::TemporaryDirectory work;
  OperateOptions options;
  WallTime now{std::chrono::hours(1)};
  std::int64_t utc_us = kNow;
  std::vector<RecorderOptions> begun;
  std::optional<Operating> operating;
};

TEST_F(OperatingTest, ANodeThatIsBackDuringTheNextRecordingIsFetchedIntoItsOwn) {
  options.start = "next";
  operating.emplace(options,
                    Operating::World{.disk = kernel_disk(),
                                     .begin =
                                         [this](RecorderOptions of) {
                                           begun.push_back(std::move(of));
                                           return std::make_unique<Running>();
                                         },
                                     .seed = 1},
                    time());
  ASSERT_EQ(begun.size(), 1u);
  EXPECT_EQ(begun[0].folder.filename(), "next");
  EXPECT_TRUE(begun[0].scope.is_former(kBefore + 50));
  EXPECT_GT(begun[0].first_incarnation, kBefore + 100) << "else nobody could tell whose a node's samples are";
  EXPECT_FALSE(begun[0].scope.is_former(begun[0].first_incarnation));
  run(milliseconds(4000));
  ASSERT_EQ(begun.size(), 2u);
  EXPECT_EQ(begun[1].folder.filename(), "drive");
  EXPECT_FALSE(begun[1].start);
  EXPECT_EQ(begun[1].scope.only, (std::vector<NodeEpoch>{{2, 77}}));
}

TEST_F(OperatingTest, ANumberThatWasRaisedAtTheLastMomentIsOfItsRecording) {
  options.start = "next";
  operating.emplace(options,
                    Operating::World{.disk = kernel_disk(),
                                     .begin = [](RecorderOptions) { return std::make_unique<Ended>(); },
                                     .seed = 1},
                    time());
  (void)operating->turn(false, time(), [](const std::string&, auto) { return true; });
  const DeskBook book = read_desk_book(work.path());
  ASSERT_FALSE(book.over.empty());
  EXPECT_EQ(book.over.back().recording, "next");
  EXPECT_EQ(book.over.back().last_incarnation, Ended::kRaised);
}

// A folder that is gone is not asked for again and again: the book is written with two syncs.
TEST_F(OperatingTest, ARestOfARecordingThatWasMovedAwayIsNotOwed) {
  std::filesystem::remove(work.path() / "drive");
  int warnings = 0;
  options.recorder.on_warning = [&warnings](const std::string&) { ++warnings; };
  operating.emplace(options,
                    Operating::World{.disk = kernel_disk(),
                                     .begin = [](RecorderOptions) { return std::make_unique<Running>(); },
                                     .seed = 1},
                    time());
  run(milliseconds(10'000));
  EXPECT_EQ(warnings, 0);
  EXPECT_TRUE(read_desk_book(work.path()).rest.empty());
  std::filesystem::create_directory(work.path() / "drive");  // moved back
  run(milliseconds(10'000));
  EXPECT_EQ(read_desk_book(work.path()).rest.size(), 1u);
}

}  // namespace
}  // namespace roadbalance
