#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>

#include "common/bus/recorder_status.hpp"
#include "common/bus/test/foreign_message.hpp"
#include "common/config/text_file.hpp"
#include "common/record/log_event.hpp"
#include "common/record/segment.hpp"
#include "common/test/source.hpp"
#include "hil_tests/measurement.hpp"

namespace roadbalance {
namespace {

using test::of_another_version;
using test::Program;

/// Programs on one bus with those of another release: who is not understood is named once, and all others go
/// on.
class MixedReleases : public test::Measurement {
 protected:
  Program saying(const std::string& name, const std::vector<std::string>& arguments,
                 const std::string& command) {
    return {command, arguments, said_file(name)};
  }
  std::string said_file(const std::string& name) const { return work.path() / (name + ".said"); }
  std::string said(const std::string& name) const { return read_text_file(said_file(name)); }
  /// Messages that another release would send on this bus, once.
  void say_foreign() {
    Heartbeat beat;
    beat.node = kForeign;
    for (int k = 0; k < 3; ++k) {
      foreign.publish(heartbeat_channel(kForeign), of_another_version(encode(beat)));
      foreign.publish(kRecorderChannel, of_another_version(encode(RecorderStatus{.incarnation = 1})));
      foreign.publish(command_channel(kFront),
                      of_another_version(encode(Command{.node = kFront, .request = 1, .incarnation = 1})));
      foreign.publish(preview_channel(kForeign), of_another_version(encode(beat)));
    }
  }
  bool comes_to_be_said(const std::string& name, const std::string& sentence) {
    return bus.wait([&] {
      say_foreign();
      return said(name).find(sentence) != std::string::npos;
    });
  }
  static std::size_t times(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++count;
    return count;
  }

  static constexpr std::int32_t kForeign = 9;
  Bus foreign{url};
};

TEST_F(MixedReleases, EveryProgramNamesWhoIsOfAnotherReleaseOnceAndGoesOnWithTheOthers) {
  Program running = saying("recorder", {"--record", record, "--url", url}, "rb-recorder");
  Program front = saying("node",
                         {"--vehicle", test::source_path("sim/demo/vehicle.toml"), "--node", "front", "--url",
                          url, "--front-end", "sim:?seed=3&rate=5&seconds=10000"},
                         "rb-node");
  ASSERT_TRUE(more_are_durable(kFront, 20));
  Program analyser = saying("analyser", {"--record", record, "--url", url}, "rb-analyser");
  Program watch = saying("watch", {"watch", "--json", "--url", url}, "rb");

  const std::string node_9 = "node 9 is of another version of the wire (RB_HEARTBEAT_9: ";
  const std::string recorder_too = "a recorder is of another version of the wire (RB_RECORDER: ";
  const std::string commands =
      "a recorder that speaks to node 1 is of another version of the wire (RB_COMMAND_1: ";
  const std::string preview = "node 9 is of another version of the wire (RB_PREVIEW_9: ";
  EXPECT_TRUE(comes_to_be_said("recorder", node_9)) << said("recorder");
  EXPECT_TRUE(comes_to_be_said("node", recorder_too)) << said("node");
  EXPECT_TRUE(comes_to_be_said("node", commands)) << said("node");
  EXPECT_TRUE(comes_to_be_said("analyser", preview)) << said("analyser");
  EXPECT_TRUE(comes_to_be_said("watch", node_9)) << said("watch");

  for (int k = 0; k < 5; ++k) say_foreign();
  ASSERT_TRUE(more_are_durable(kFront, 100)) << "the nodes that are understood go on";
  watch.signal(SIGTERM);
  analyser.signal(SIGTERM);
  EXPECT_EQ(analyser.exit_code(bus.kPatience_s), 0);
  end_well(running, {&front});
  expect_complete(1);
  EXPECT_EQ(times(said("recorder"), node_9), 1U) << said("recorder");
  EXPECT_EQ(times(said("node"), recorder_too), 1U) << said("node");
  EXPECT_EQ(times(said("watch"), node_9), 1U) << said("watch");
  for (const char* name : {"recorder", "node", "analyser", "watch"})
    EXPECT_NE(said(name).find("install the same release of roadbalance"), std::string::npos) << name;
}

TEST_F(MixedReleases, ADemoEndsAndNamesTheOneOfAnotherRelease) {
  const std::string port = url.substr(url.rfind(':') + 1, url.find('?') - url.rfind(':') - 1);
  Program demo = saying(
      "demo", {"demo", "--headless", "--rate", "1", "--drive-seconds", "1000", "--bus-port", port}, "rb");
  ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kFront).node == kFront; })) << said("demo");
  EXPECT_TRUE(comes_to_be_said("demo", "node 9 is of another version of the wire")) << said("demo");
  EXPECT_EQ(demo.exit_code(bus.kPatience_s), 4);
}

/// The record as another release would have written it: every event with another fingerprint.
void write_as_of_another_release(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::filesystem::create_directory(to);
  std::ofstream segment(segment_path(to, 1), std::ios::binary);
  RecordReader reader(from);
  reader.finish();
  while (const auto event = reader.next()) {
    const auto data = of_another_version({event->data.begin(), event->data.end()});
    const auto header = encode_log_header(*event);
    segment.write(reinterpret_cast<const char*>(header.data()), header.size());
    segment << event->channel;
    segment.write(reinterpret_cast<const char*>(data.data()), static_cast<std::streamsize>(data.size()));
  }
}

TEST_F(MixedReleases, AnAnalyserEndsOnARecordOfAnotherRelease) {
  {
    Program running = recorder();
    Program front = node("front", "rate=max&seconds=2");
    EXPECT_EQ(front.exit_code(bus.kPatience_s), 0);
    end_well(running, {});
  }
  write_as_of_another_release(record, work.path() / "foreign");
  Program analyser =
      saying("analyser", {"--record", work.path() / "foreign", "--url", url, "--exit-at-end"}, "rb-analyser");
  EXPECT_EQ(analyser.exit_code(bus.kPatience_s), 4);
  EXPECT_NE(said("analyser").find("a recorder is of another version of the wire (RB_BLOCK_0_META: "),
            std::string::npos)
      << said("analyser");
}

}  // namespace
}  // namespace roadbalance
