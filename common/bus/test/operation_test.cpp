#include "common/bus/operation.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "common/bus/control_messages.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/test/bit_flips.hpp"

namespace roadbalance {
namespace {

using test::expect_every_bit_flip_refused;

Request some_request() {
  return {.asker = kRequestLimit - 1,
          .request = 5,
          .operation = Operation::kRange,
          .node = 2,
          .channel = 11,
          .value = {50.0, -1.5},
          .text = "Brücke",
          .nodes = "front, 2",
          .who = "rb of anna at laptop"};
}

TEST(Operation, ARequestArrivesAsItWasSent) {
  EXPECT_EQ(decode_request(encode(some_request())), some_request());
}

TEST(Operation, ARequestOfANewerPageArrives) {
  Request request = some_request();
  request.operation = static_cast<Operation>(99);
  ASSERT_TRUE(decode_request(encode(request)));
}

TEST(Operation, RefusesARequestThatCannotBe) {
  const auto with = [](auto change) {
    Request request = some_request();
    change(request);
    return decode_request(encode(request));
  };
  EXPECT_FALSE(with([](Request& r) { r.asker = 0; }));
  EXPECT_FALSE(with([](Request& r) { r.request = kRequestLimit; }));
  EXPECT_FALSE(with([](Request& r) { r.node = -1; }));
  EXPECT_FALSE(with([](Request& r) { r.node = 10'000; }));
  EXPECT_FALSE(with([](Request& r) { r.channel = 12; }));
  EXPECT_FALSE(with([](Request& r) { r.value[1] = std::numeric_limits<double>::quiet_NaN(); }));
}

// A sentence may quote a file that is no text; a folder may be called anything.
TEST(Operation, NoSentenceKeepsAMessageFromArriving) {
  const std::string bad = "car.toml:3: \"\xFF\x1b[2J\"\nallowed: numbers";
  const auto answer = decode_answer(encode(Answer{.asker = 1, .request = 1, .text = bad}));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->text, "car.toml:3: \"? [2J\" allowed: numbers");
  EXPECT_TRUE(decode_reply(encode(Reply{.node = 1, .text = bad})));
  EXPECT_TRUE(decode_receipt(encode(Receipt{.name = bad})));
  EXPECT_TRUE(decode_recorder_status(encode(RecorderStatus{.name = bad, .fault = bad})));
}

TEST(Operation, AnAnswerArrivesAsItWasSent) {
  const auto answer = decode_answer(encode(Answer{.asker = 3,
                                                  .request = 4,
                                                  .time_us = 17,
                                                  .operation = Operation::kStart,
                                                  .state = AnswerState::kRefused,
                                                  .reason = RefusalReason::kNameTaken,
                                                  .node = 1,
                                                  .value = {2, 3},
                                                  .text = "there is a recording \"drive\""}));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->request, 4);
  EXPECT_EQ(answer->time_us, 17);
  EXPECT_EQ(answer->operation, Operation::kStart);
  EXPECT_EQ(answer->state, AnswerState::kRefused);
  EXPECT_EQ(answer->reason, RefusalReason::kNameTaken);
  EXPECT_EQ(answer->value[1], 3);
  EXPECT_EQ(answer->text, "there is a recording \"drive\"");
}

Receipt some_receipt() {
  return {.incarnation = 3,
          .began_us = 4,
          .ended_us = 5,
          .index = 1,
          .nodes = 2,
          .node = 7,
          .epochs = 2,
          .open_epochs = 1,
          .samples_sent = 100,
          .samples_recorded = 99,
          .gaps = 1,
          .repaired = 6,
          .overload_s = 0.25,
          .sync_us = 12.5,
          .blocks_crc32c = 0xDEADBEEF,
          .sums_agree = true,
          .bytes = 1'000'000,
          .marks = 3,
          .name = "drive"};
}

TEST(Operation, AReceiptArrivesAsItWasSent) {
  const auto receipt = decode_receipt(encode(some_receipt()));
  ASSERT_TRUE(receipt);
  EXPECT_EQ(receipt->open_epochs, 1);
  EXPECT_EQ(receipt->samples_recorded, 99);
  EXPECT_EQ(receipt->overload_s, 0.25);
  EXPECT_EQ(receipt->sync_us, 12.5);
  EXPECT_EQ(receipt->blocks_crc32c, 0xDEADBEEF);
  EXPECT_EQ(receipt->sums_agree, true);
  EXPECT_EQ(receipt->bytes, 1'000'000);
  EXPECT_EQ(receipt->marks, 3);
  EXPECT_EQ(receipt->name, "drive");
  for (const std::optional<bool> sums_agree :
       {std::optional(true), std::optional(false), std::optional<bool>()}) {
    Receipt other = some_receipt();
    other.sums_agree = sums_agree;
    EXPECT_EQ(decode_receipt(encode(other))->sums_agree, sums_agree);
  }
}

TEST(Operation, AReceiptSaysWhenItsNodeWasAwayAndWhoStopped) {
  Receipt sent = some_receipt();
  sent.absence = "never came";
  sent.stopped_by = "rb of anna at laptop";
  const auto receipt = decode_receipt(encode(sent));
  ASSERT_TRUE(receipt);
  EXPECT_EQ(receipt->absence, sent.absence);
  EXPECT_EQ(receipt->stopped_by, sent.stopped_by);
}

TEST(Operation, AStatusNamesTheNodesThatAreAbsentAsFarAsItHasRoom) {
  RecorderStatus sent{.left_out = 65};
  for (std::int32_t node = 1; node <= 20; ++node) sent.absent.push_back({node, AbsenceCause::kNeverCame});
  const auto status = decode_recorder_status(encode(sent));
  ASSERT_TRUE(status);
  ASSERT_EQ(status->absent.size(), kMostAbsentNamed);
  EXPECT_EQ(status->absent.back(), (AbsentNode{16, AbsenceCause::kNeverCame}));
  EXPECT_EQ(status->left_out, 65);
  EXPECT_FALSE(decode_recorder_status(encode(RecorderStatus{.absent = {{1, AbsenceCause::kNone}}})));
  EXPECT_FALSE(decode_recorder_status(encode(RecorderStatus{.absent = {{0, AbsenceCause::kSilent}}})));
}

TEST(Operation, AReceiptOfNothingNamesNoNode) {
  EXPECT_TRUE(decode_receipt(encode(Receipt{.name = "empty"})));
  EXPECT_FALSE(decode_receipt(encode(Receipt{.node = 1})));
  Receipt receipt = some_receipt();
  receipt.index = receipt.nodes;
  EXPECT_FALSE(decode_receipt(encode(receipt)));
}

TEST(Operation, RefusesEverySingleBitFlip) {
  expect_every_bit_flip_refused(encode(some_request()), decode_request);
  expect_every_bit_flip_refused(encode(Answer{.asker = 3, .request = 4, .text = "x"}), decode_answer);
  expect_every_bit_flip_refused(encode(some_receipt()), decode_receipt);
  expect_every_bit_flip_refused(encode(VehiclePart{.node = 1, .incarnation = 1, .parts = 1, .text = "x"}),
                                decode_vehicle_part);
}

TEST(RecorderStatus, SaysWhatIsRecordedAndWhyNot) {
  const auto status = decode_recorder_status(encode(RecorderStatus{.recorder = 9,
                                                                   .state = RecorderState::kFault,
                                                                   .recording_s = 12.5,
                                                                   .nodes = 2,
                                                                   .marks = 4,
                                                                   .operable = true,
                                                                   .name = "drive",
                                                                   .fault = "no space"}));
  ASSERT_TRUE(status);
  EXPECT_EQ(status->recorder, 9);
  EXPECT_EQ(status->state, RecorderState::kFault);
  EXPECT_EQ(status->recording_s, 12.5);
  EXPECT_EQ(status->nodes, 2);
  EXPECT_EQ(status->marks, 4);
  EXPECT_TRUE(status->operable);
  EXPECT_EQ(status->name, "drive");
  EXPECT_EQ(status->fault, "no space");
}

TEST(VehiclePart, ArrivesAsItWasSent) {
  const auto part = decode_vehicle_part(encode(VehiclePart{
      .node = 4, .incarnation = 5, .vehicle_crc32c = 0xF00D0001, .part = 1, .parts = 2, .text = "a\nb"}));
  ASSERT_TRUE(part);
  EXPECT_EQ(part->vehicle_crc32c, 0xF00D0001);
  EXPECT_EQ(part->part, 1);
  EXPECT_EQ(part->text, "a\nb");
  EXPECT_FALSE(decode_vehicle_part(
      encode(VehiclePart{.node = 4, .incarnation = 5, .part = 2, .parts = 2, .text = "a"})));
}

}  // namespace
}  // namespace roadbalance
