#include "common/record/record_state.hpp"

#include <gtest/gtest.h>

#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

SealedBlock description(NodeEpoch of, std::int64_t sequence, std::int32_t part = 0, std::int32_t parts = 1) {
  SealedBlock sealed;
  seal(MetaBlock{.header = {.node = of.first, .epoch = of.second, .sequence = sequence},
                 .part = part,
                 .parts = parts,
                 .text = "[vehicle]"},
       sealed);
  return sealed;
}

SealedBlock end(NodeEpoch of, std::int64_t sequence) {
  SealedBlock sealed;
  seal(EndBlock{.header = {.node = of.first, .epoch = of.second, .sequence = sequence}, .blocks = 2}, sealed);
  return sealed;
}

TEST(RecordState, RepeatsTheDescriptionOfAnEpochUntilItHasEnded) {
  const NodeEpoch first{1, 100};
  const NodeEpoch second{2, 100};
  RecordState state;
  add(description(first, 1), state);
  add(description(second, 1), state);
  EXPECT_EQ(going_on(state).size(), 2u);
  add(end(first, 2), state);
  ASSERT_EQ(going_on(state).size(), 1u);
  EXPECT_TRUE(going_on(state).contains(second));
  add(description(first, 0), state);  // as in the segments that are read at a restart
  EXPECT_FALSE(going_on(state).contains(first));
}

TEST(RecordState, WhatLiesBehindAHoleIsThereAndHasNoSum) {
  const NodeEpoch one{1, 100};
  RecordState state;
  add(description(one, 1), state);
  add(description(one, 7), state);  // 2 to 6 were damaged
  EXPECT_EQ(state.epoch[one].position.contiguous, 7);
  EXPECT_EQ(state.epoch[one].blocks, 2);
  EXPECT_EQ(state.epoch[one].sum, std::nullopt);
  add(description(one, 5), state);
  EXPECT_EQ(state.epoch[one].position.contiguous, 7);
  add(end(one, 8), state);
  EXPECT_TRUE(state.epoch[one].position.ended);
}

TEST(RecordState, HasNoSumWhereTheEndContradictsIt) {
  const NodeEpoch one{1, 100}, other{2, 100};
  RecordState state;
  BlockSum sum;
  sum.add(description(one, 1));
  for (const auto& [key, crc32c] : {std::pair(one, sum.crc32c()), std::pair(other, sum.crc32c())}) {
    add(description(key, 1), state);
    SealedBlock sealed;
    seal(EndBlock{.header = {.node = key.first, .epoch = key.second, .sequence = 2}, .blocks_crc32c = crc32c},
         sealed);
    add(sealed, state);
  }
  EXPECT_EQ(state.epoch[one].sum, sum.crc32c());
  EXPECT_EQ(state.epoch[other].sum, std::nullopt) << "its description has another CRC";
}

TEST(RecordState, DescriptionsAreBoundedWhateverTheNodesSend) {
  RecordState state;
  for (std::int64_t epoch = 1; epoch <= 3000; ++epoch) add(description({1, epoch}, 0), state);
  EXPECT_EQ(state.vehicle.size(), kMostDescriptionPartsInAll);
  RecordState one;
  for (std::int32_t part = 0; part < 5000; ++part) add(description({1, 1}, 0, part, 5000), one);
  EXPECT_TRUE(one.vehicle.empty()) << "repeated as a whole or not at all";
}

TEST(RecordState, EpochsThatHaveEndedMakeRoomForNewOnes) {
  RecordState state;
  const std::int64_t last = 3 * static_cast<std::int64_t>(kMostDescriptionPartsInAll);
  for (std::int64_t epoch = 1; epoch <= last; ++epoch) {
    add(description({1, epoch}, 1), state);
    if (epoch < last) add(end({1, epoch}, 2), state);
  }
  const auto repeated = going_on(state);
  ASSERT_EQ(repeated.size(), 1u);
  EXPECT_EQ(repeated.begin()->first.second, last);
}

}  // namespace
}  // namespace roadbalance
