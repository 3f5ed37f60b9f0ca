#include "host/recorder/device_notes.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;

class DeviceNotesTest : public ::testing::Test {
 protected:
  /// Texts of the notes that a heartbeat brings.
  std::vector<std::string> hear() {
    std::vector<DeviceNote> notes;
    watch.take(counts);
    watch.due(3, now, notes);
    return texts(notes);
  }
  static std::vector<std::string> texts(const std::vector<DeviceNote>& notes) {
    std::vector<std::string> all;
    for (const auto& note : notes) {
      EXPECT_EQ(note.node, 3);
      EXPECT_EQ(note.text.rfind(sentence(note.counter), 0), 0U) << note.text;
      all.push_back(note.text);
    }
    return all;
  }
  std::int64_t& count(DeviceCounter counter) { return counts[static_cast<std::size_t>(counter)]; }

  using Texts = std::vector<std::string>;
  DeviceNotes watch;
  std::array<std::int64_t, kDeviceCounters> counts{};
  WallTime now{};  // the first second of all counts like any other
};

TEST_F(DeviceNotesTest, NotesACounterThatMovesAtOnceAndOnce) {
  EXPECT_EQ(hear(), Texts{});
  count(DeviceCounter::kGone) = 1;
  EXPECT_EQ(hear(), Texts{"was unplugged or went down (1 time by now)"});
  for (int k = 0; k < 30; ++k, now += milliseconds(100)) EXPECT_EQ(hear(), Texts{});
  count(DeviceCounter::kReturned) = 1;
  EXPECT_EQ(hear(), Texts{"is there again (1 time by now)"});
}

TEST_F(DeviceNotesTest, NotesACounterThatRunsOnceASecondWithAllThatCameMeanwhile) {
  Texts all;
  for (int k = 0; k < 35; ++k, now += milliseconds(100)) {
    count(DeviceCounter::kBusErrors) += 2;
    for (auto& text : hear()) all.push_back(text);
  }
  EXPECT_EQ(all, (Texts{"the controller saw errors on the bus (2 times by now)",
                        "the controller saw errors on the bus (22 times by now)",
                        "the controller saw errors on the bus (42 times by now)",
                        "the controller saw errors on the bus (62 times by now)"}));
  std::vector<DeviceNote> notes;
  watch.finish(3, notes);
  EXPECT_EQ(texts(notes), Texts{"the controller saw errors on the bus (70 times by now)"});
  notes.clear();
  watch.finish(3, notes);
  EXPECT_TRUE(notes.empty());
}

TEST_F(DeviceNotesTest, LimitsEachCounterForItself) {
  count(DeviceCounter::kGone) = 1;
  EXPECT_EQ(hear().size(), 1U);
  now += milliseconds(100);
  count(DeviceCounter::kGone) = 2;
  count(DeviceCounter::kStalls) = 4;
  EXPECT_EQ(hear(), Texts{"the board halted its transfers (4 times by now)"});
  now += milliseconds(900);
  EXPECT_EQ(hear(), Texts{"was unplugged or went down (2 times by now)"});
}

TEST_F(DeviceNotesTest, IsNotConfusedByAHeartbeatThatComesLate) {
  count(DeviceCounter::kGone) = 2;
  EXPECT_EQ(hear().size(), 1U);
  now += milliseconds(1100);
  count(DeviceCounter::kGone) = 1;
  EXPECT_EQ(hear(), Texts{});
  now += milliseconds(1100);
  count(DeviceCounter::kGone) = 2;
  EXPECT_EQ(hear(), Texts{});
}

}  // namespace
}  // namespace roadbalance
