// rb start, stop, mark, configure, zero, vehicle: what they say and how they end; hil_tests has them at work.
#include <gtest/gtest.h>

#include <mutex>
#include <nlohmann/json.hpp>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/operation.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/test/bus_url.hpp"
#include "common/test/temporary_directory.hpp"
#include "tools/rb/test/run_rb.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;

/// A recorder that answers as it is told, not before it was asked twice: the first answer may be lost.
class Answering {
 public:
  Answering(const std::string& url, Answer answer, std::vector<Receipt> receipts = {})
      : thread_([=, this](std::stop_token stop) {
          Bus bus(url);
          int asked = 0;
          bus.subscribe(kRequestChannel, [&](std::string_view, auto bytes) {
            const auto request = decode_request(bytes);
            if (!request) return;
            const std::scoped_lock lock(mutex_);
            heard_ = *request;
            if (++asked < 2) return;
            Answer said = answer;
            said.asker = request->asker;
            said.request = request->request;
            said.operation = request->operation;
            bus.publish(kAnswerChannel, encode(said));
          });
          while (!stop.stop_requested()) {
            bus.handle(std::chrono::milliseconds(20));
            for (const Receipt& receipt : receipts) bus.publish(kReceiptChannel, encode(receipt));
          }
        }) {}

  /// The newest request.
  Request heard() const {
    const std::scoped_lock lock(mutex_);
    return heard_;
  }

 private:
  mutable std::mutex mutex_;
  Request heard_;
  std::jthread thread_;
};

class OperateCommand : public testing::Test {
 protected:
  test::Outcome rb(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--url", url_});
    return test::run_rb(arguments, folder_ / "rb.log");
  }
  const std::string url_ = test::bus_url();
  const test::TemporaryDirectory folder_;
};

Answer done(std::string text) {
  return {.state = AnswerState::kDone, .text = std::move(text)};
}

// The bus has no control characters: sent as blanks, they would make another name than was typed.
TEST_F(OperateCommand, ATextWithAHiddenCharacterIsRefusedBeforeItIsSent) {
  const Answering recorder(url_, done("recorded"));
  for (const std::vector<std::string>& words : {std::vector<std::string>{"start",
                                                                         "a\x1b"
                                                                         "b"},
                                                {"start", "a\nb"},
                                                {"mark", "a\tb"},
                                                {"vehicle", "a\u202E.toml"},
                                                {"start", "--nodes", "front\x01", "drive"}}) {
    const test::Outcome refused = rb(words);
    EXPECT_EQ(refused.code, 2) << refused.log;
    EXPECT_NE(refused.log.find("hidden character \\"), std::string::npos) << refused.log;
    EXPECT_EQ(refused.log.find_first_of("\x01\x1b"), std::string::npos) << refused.log;
  }
  EXPECT_EQ(recorder.heard().asker, 0) << "none was sent";
}

TEST_F(OperateCommand, AStartNamesItsNodesAndIsIncompleteWhereOneIsMissing) {
  Answer partial = done("\"drive\" is being recorded; PARTIAL: node 2 (rear) is not on the bus");
  partial.value[0] = 1.0;
  const Answering recorder(url_, partial);
  EXPECT_EQ(rb({"start", "--nodes", "front,2", "drive"}).code, 3);
  EXPECT_EQ(recorder.heard().nodes, "front,2");
  EXPECT_EQ(recorder.heard().text, "drive");
  EXPECT_NE(recorder.heard().who, "");
}

TEST_F(OperateCommand, SaysWhatIsDone) {
  const Answering recorder(url_, done("\"drive\" is being recorded"));
  const auto outcome = rb({"start", "drive"});
  EXPECT_EQ(outcome.code, 0) << outcome.log;
  EXPECT_EQ(outcome.output, "\"drive\" is being recorded\n");
  EXPECT_EQ(recorder.heard().operation, Operation::kStart);
  EXPECT_EQ(recorder.heard().text, "drive");
}

TEST_F(OperateCommand, ARefusalIsSaidAndEndsWithOne) {
  const Answering recorder(url_, {.state = AnswerState::kRefused,
                                  .reason = RefusalReason::kNotRecording,
                                  .text = "nothing is being recorded"});
  const auto outcome = rb({"stop"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.output, "");
  EXPECT_EQ(outcome.log, "rb: refused: nothing is being recorded\n");
  const auto json = Json::parse(rb({"stop", "--json"}).output);
  EXPECT_EQ(json.at("done"), false);
  EXPECT_EQ(json.at("reason"), "no recording is under way");
}

/// Of the first of two nodes, which lacks nothing.
Receipt whole_receipt() {
  return {.nodes = 2,
          .node = 1,
          .epochs = 1,
          .samples_sent = 100,
          .samples_recorded = 100,
          .blocks_crc32c = 0x12AB,
          .sums_agree = true,
          .name = "drive"};
}

TEST_F(OperateCommand, AStopGivesTheReceiptAndSaysByItsCodeWhatIsMissing) {
  const Receipt whole = whole_receipt();
  Receipt lossy = whole;
  lossy.index = 1;
  lossy.node = 2;
  lossy.samples_recorded = 60;
  lossy.gaps = 1;
  lossy.sums_agree.reset();
  {
    const Answering recorder(url_, done("\"drive\" is on the disk"), {whole, lossy});
    const auto outcome = rb({"stop", "--json"});
    EXPECT_EQ(outcome.code, 3) << outcome.log;
    const auto json = Json::parse(outcome.output);
    EXPECT_EQ(json.at("recording"), "drive");
    EXPECT_EQ(json.at("nodes").at(0).at("samples_lost"), 0);
    EXPECT_EQ(json.at("nodes").at(0).at("crc32c"), "000012ab");
    EXPECT_EQ(json.at("nodes").at(0).at("sums_agree"), true);
    EXPECT_EQ(json.at("nodes").at(1).at("samples_lost"), 40);
    EXPECT_TRUE(json.at("nodes").at(1).at("sums_agree").is_null());
  }
  {
    const Answering recorder(url_, done("\"drive\" is on the disk"), {whole, lossy});
    const std::string output = rb({"stop"}).output;
    EXPECT_NE(output.find("CRC 000012ab agrees"), std::string::npos) << output;
    EXPECT_NE(output.find("CRC 000012ab is not proven"), std::string::npos) << output;
    EXPECT_EQ(output.find("DOES NOT AGREE"), std::string::npos) << output;
  }
  lossy.samples_recorded = 100;
  lossy.gaps = 0;
  lossy.sums_agree = true;
  {
    const Answering recorder(url_, done("\"drive\" is on the disk"), {whole, lossy});
    EXPECT_EQ(rb({"stop"}).code, 0);
  }
  Receipt contradicted = lossy;
  contradicted.sums_agree = false;
  {
    const Answering recorder(url_, done("\"drive\" is on the disk"), {whole, contradicted});
    EXPECT_EQ(rb({"stop"}).code, 3);
  }
  const Answering recorder(url_, done("\"drive\" is on the disk"), {Receipt{.name = "drive"}});
  EXPECT_EQ(rb({"stop"}).code, 3) << "no node has been recorded";
}

TEST_F(OperateCommand, AStopSaysNothingIsLostOfNoNodeThatWasAbsent) {
  Receipt early = whole_receipt();
  early.absence = "ended 38 s before the recording";
  const Receipt never{.index = 1, .nodes = 2, .node = 2, .name = "drive", .absence = "never came"};
  const Answering recorder(url_, done("\"drive\" is on the disk"), {early, never});
  const auto outcome = rb({"stop"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_NE(outcome.output.find("node 1: 100 samples, was absent, 0 repaired"), std::string::npos);
  EXPECT_NE(outcome.output.find("node 1 ended 38 s before the recording\n"), std::string::npos);
  EXPECT_NE(outcome.output.find("node 2: no samples; it never came\n"), std::string::npos);
  EXPECT_EQ(outcome.output.find(" lost"), std::string::npos) << outcome.output;
  EXPECT_EQ(outcome.output.find("not proven"), std::string::npos) << outcome.output;
}

TEST_F(OperateCommand, AStopWithoutEveryNodesReceiptIsNotProven) {
  const Receipt one{.nodes = 2, .node = 1, .epochs = 1, .sums_agree = true, .name = "drive"};
  for (const auto& receipts : {std::vector<Receipt>{}, std::vector<Receipt>{one}}) {
    const Answering recorder(url_, done("\"drive\" is on the disk"), receipts);
    EXPECT_EQ(rb({"stop"}).code, 3);
  }
}

TEST_F(OperateCommand, SaysWhyNobodyAnswers) {
  const auto silent = rb({"mark", "here", "--seconds", "0.5"});
  EXPECT_EQ(silent.code, 4);
  EXPECT_NE(silent.log.find("is rb-recorder --recordings FOLDER running"), std::string::npos) << silent.log;
  EXPECT_EQ(silent.log.find("Asking on"), std::string::npos) << silent.log;
  const auto patient = rb({"mark", "here", "--seconds", "4"});
  EXPECT_NE(patient.log.find("Asking on, for 4 s in all"), std::string::npos) << patient.log;
  const std::jthread recorder([this](std::stop_token stop) {
    Bus bus(url_);
    while (!stop.stop_requested()) {
      bus.publish(kRecorderChannel, encode(RecorderStatus{.recorder = 1, .name = "drive"}));
      bus.handle(std::chrono::milliseconds(20));
    }
  });
  const auto not_operable = rb({"mark", "here", "--seconds", "2"});
  EXPECT_EQ(not_operable.code, 4);
  EXPECT_NE(not_operable.log.find("was started with --record"), std::string::npos) << not_operable.log;
}

TEST_F(OperateCommand, ChannelsAreCalledAsThePageCallsThem) {
  const Answering recorder(url_, done("so it is"));
  EXPECT_EQ(rb({"configure", "range", "2.5", "80"}).code, 0);
  EXPECT_EQ(recorder.heard().node, 2);
  EXPECT_EQ(recorder.heard().channel, 4);
  EXPECT_EQ(recorder.heard().value[0], 80);
  EXPECT_EQ(rb({"configure", "filter", "150", "--order", "4"}).code, 0);
  EXPECT_EQ(recorder.heard().value[1], 4);
  EXPECT_EQ(rb({"zero", "--node", "2"}).code, 0);
  EXPECT_EQ(recorder.heard().operation, Operation::kZero);
  EXPECT_EQ(recorder.heard().node, 2);
  EXPECT_EQ(rb({"vehicle", "winter.toml"}).code, 0);
  EXPECT_EQ(recorder.heard().text, "winter.toml");
}

TEST_F(OperateCommand, RefusesWhatCannotBeAskedAtOnce) {
  for (const std::string channel : {"2", "2.0", "2.13", "0.5", "2.5x", "front.5"})
    EXPECT_EQ(rb({"configure", "range", channel, "80"}).code, 2) << channel;
  EXPECT_EQ(rb({"configure", "range", "2.5", "-1"}).code, 2);
  EXPECT_EQ(rb({"start", std::string(65, 'x')}).code, 2);
  EXPECT_EQ(rb({"configure"}).code, 2);
  const auto wheel = rb({"configure", "reading", "frontleft"});
  EXPECT_EQ(wheel.code, 2);
  EXPECT_NE(wheel.log.find("'frontleft' cannot be used; allowed: front_left, front_right, rear_left"),
            std::string::npos)
      << wheel.log;
}

}  // namespace
}  // namespace roadbalance
