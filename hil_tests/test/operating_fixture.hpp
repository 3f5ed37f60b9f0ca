#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/test/source.hpp"
#include "hil_tests/measurement.hpp"
#include "tools/rb/asking.hpp"

namespace roadbalance {

inline constexpr std::chrono::milliseconds kPatience{60'000};

namespace test {

/// Real nodes and a real recorder that starts and stops on request.
class Operating : public Measurement {
 protected:
  Operating() { make_vehicles(); }
  explicit Operating(const std::string& bus_url) : Measurement(bus_url) { make_vehicles(); }
  void make_vehicles() const {
    std::filesystem::create_directories(vehicles);
    write_vehicle("car.toml", test::read_source("sim/demo/vehicle.toml"));
  }

  void write_vehicle(const std::string& name, const std::string& text) const {
    std::ofstream(vehicles / name) << text;
  }
  /// @param said  as of test::Program
  test::Program operated_recorder(const std::filesystem::path& said = {}) const {
    return test::Program("rb-recorder",
                         {"--url", url, "--recordings", recordings.string(), "--vehicle",
                          (vehicles / "car.toml").string(), "--segment-mib", "0.25"},
                         said);
  }
  /// @param scenario  empty: the demonstration drive
  test::Program staying(const std::string& name, const std::string& scenario = "") const {
    return test::Program("rb-node",
                         {"--url", url, "--vehicle", (vehicles / "car.toml").string(), "--node", name,
                          "--front-end", "sim:" + scenario + "?seed=1&rate=1&seconds=10000", "--stay"});
  }

  Answer ask(Operation operation, const std::string& text = "", Request more = {}) {
    more.operation = operation;
    more.text = text;
    const auto answer = asking.ask(more, kPatience);
    EXPECT_TRUE(answer) << asking.silence();
    return answer.value_or(Answer{});
  }
  /// Asks until both nodes are there.
  void start(const std::string& name) {
    ASSERT_TRUE(test::wait_until(
        [&] {
          bus.listen(0.05);
          // So the recorder has heard them, too: a start without one of them is partial.
          return bus.heartbeat(kFront).epoch != 0 && bus.heartbeat(kRear).epoch != 0 && bus.recorder() &&
                 (bus.recorder()->nodes == 2 || bus.recorder()->state == RecorderState::kRecording);
        },
        60));
    Answer answer;
    ASSERT_TRUE(test::wait_until(
        [&] {
          answer = ask(Operation::kStart, name);
          return answer.reason != RefusalReason::kNoNode;
        },
        60));
    ASSERT_EQ(answer.state, AnswerState::kDone) << answer.text;
  }
  /// And judges the receipt.
  void stop() {
    ASSERT_EQ(ask(Operation::kStop).state, AnswerState::kDone);
    const auto receipts = asking.receipts(kPatience);
    ASSERT_EQ(receipts.size(), 2u);
    for (const auto& [place, receipt] : receipts) {
      EXPECT_GT(receipt.samples_recorded, 0);
      EXPECT_EQ(receipt.samples_recorded, receipt.samples_sent);
      EXPECT_EQ(receipt.gaps, 0);
      EXPECT_EQ(receipt.open_epochs, 0);
      EXPECT_EQ(receipt.sums_agree, true);
    }
  }
  void expect_whole(const std::string& name) { expect_complete(recordings / name, 2); }
  std::vector<std::string> notes(const std::string& name) const {
    return verify_record(recordings / name).notes;
  }
  std::ptrdiff_t count(const std::string& name, const std::string& ending) const {
    const auto all = notes(name);
    return std::ranges::count_if(all, [&](const auto& note) { return note.ends_with(ending); });
  }

  const std::filesystem::path recordings = work.path() / "recordings", vehicles = work.path() / "vehicles";
  Asking asking{url};
};

}  // namespace test

using test::Operating;

}  // namespace roadbalance
