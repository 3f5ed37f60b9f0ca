#include "common/bus/other_wire.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "common/bus/bus.hpp"
#include "common/bus/control_messages.hpp"
#include "common/bus/results.hpp"
#include "common/bus/test/foreign_message.hpp"

namespace roadbalance {
namespace {

using test::of_another_version;

std::vector<std::uint8_t> heartbeat(std::int32_t node) {
  Heartbeat beat;
  beat.node = node;
  return encode(beat);
}

TEST(OtherWire, NamesNodeChannelBothVersionsAndWhatToDo) {
  OtherWire wire;
  const auto ours = heartbeat(7);
  const auto foreign = of_another_version(ours);
  ASSERT_FALSE(decode_heartbeat(foreign)) << "it is refused by who reads it";
  wire.take("RB_HEARTBEAT_7", foreign);
  const auto said = wire.sentences();
  ASSERT_EQ(said.size(), 1U);
  for (const std::string& part : {std::string("node 7 is of another version of the wire"),
                                  std::string("RB_HEARTBEAT_7"), test::fingerprint_text(foreign),
                                  test::fingerprint_text(ours), std::string("install the same release")})
    EXPECT_NE(said[0].find(part), std::string::npos) << part << " in: " << said[0];
}

TEST(OtherWire, SaysItOnceOfEachChannelAndFingerprint) {
  OtherWire wire;
  const auto foreign = of_another_version(heartbeat(7));
  for (int k = 0; k < 100; ++k) wire.take("RB_HEARTBEAT_7", foreign);
  EXPECT_EQ(wire.sentences().size(), 1U);
  wire.take("RB_HEARTBEAT_7", foreign);
  EXPECT_TRUE(wire.sentences().empty());
  wire.take("RB_HEARTBEAT_8", foreign);
  wire.take("RB_HEARTBEAT_7", of_another_version(heartbeat(7), 2));
  EXPECT_EQ(wire.sentences().size(), 2U);
}

TEST(OtherWire, NumbersTheNodesAsLongAsTheySpeak) {
  OtherWire wire;
  const auto foreign = of_another_version(heartbeat(7));
  for (int k = 0; k < 2; ++k) {
    wire.take("RB_HEARTBEAT_7", foreign);
    EXPECT_EQ(wire.nodes(), std::set<std::int32_t>{7}) << "again, though its sentence is said once";
  }
  EXPECT_TRUE(wire.nodes().empty());
  wire.take("RB_HEARTBEAT_7", heartbeat(7));
  wire.take("RB_HEARTBEAT_99999999999999999999", foreign);
  wire.take("RB_HEARTBEAT_0", foreign);
  EXPECT_TRUE(wire.nodes().empty());
}

TEST(OtherWire, TakesNothingElseForAnotherVersion) {
  OtherWire wire;
  const auto foreign = of_another_version(heartbeat(7));
  wire.take("RB_HEARTBEAT_7", heartbeat(7));
  wire.take("RB_HEARTBEAT_7", encode(Command{.node = 7, .request = 1, .incarnation = 1}));  // a wrong channel
  wire.take("SOMEBODY_ELSE", foreign);
  wire.take("RB_HEARTBEAT_X", foreign);
  wire.take("RB_HEARTBEAT_", foreign);
  wire.take("RB_BLOCK_7", foreign);
  wire.take("RB_HEARTBEAT_7", {});
  wire.take("RB_HEARTBEAT_7", std::span(foreign).first(7));
  for (std::size_t bit = 0; bit < 8 * foreign.size(); ++bit) {  // damaged, of whatever version
    auto damaged = foreign;
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    wire.take("RB_HEARTBEAT_7", damaged);
  }
  EXPECT_TRUE(wire.sentences().empty());
}

TEST(OtherWire, ATypeWithoutCrcIsBelievedTheSecondTime) {
  OtherWire wire;
  auto foreign = encode(Balance{});
  foreign[0] ^= 1;
  wire.take(kBalanceChannel, foreign);
  EXPECT_TRUE(wire.sentences().empty());
  wire.take(kBalanceChannel, foreign);
  wire.take(kBalanceChannel, foreign);
  const auto said = wire.sentences();
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(said[0].find("an analyser is of another version"), std::string::npos) << said[0];
}

TEST(OtherWire, ItsMemoryIsBounded) {
  OtherWire wire;
  const auto foreign = of_another_version(heartbeat(1));
  for (std::size_t node = 1; node <= 10 * OtherWire::kMostVersions; ++node)
    wire.take("RB_HEARTBEAT_" + std::to_string(node), foreign);
  EXPECT_EQ(wire.sentences().size(), OtherWire::kMostVersions);
}

TEST(OtherWire, ABusSaysItOfWhatItHasSubscribedAndGoesOnWithTheOthers) {
  Bus bus(bus_url_on_port(20'000 + ::getpid() % 20'000));
  int understood = 0;
  bus.subscribe("RB_HEARTBEAT_.*", [&](std::string_view, std::span<const std::uint8_t> bytes) {
    understood += decode_heartbeat(bytes).has_value();
  });
  const auto foreign = of_another_version(heartbeat(9));
  for (int k = 0; k < 3; ++k) {
    ASSERT_TRUE(bus.publish("RB_HEARTBEAT_9", foreign));
    ASSERT_TRUE(bus.publish("RB_HEARTBEAT_1", heartbeat(1)));
  }
  while (understood < 3 && bus.handle(std::chrono::milliseconds(2000)) > 0) {
  }
  EXPECT_EQ(understood, 3);
  const auto said = bus.other_versions();
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(said[0].find("node 9"), std::string::npos) << said[0];
}

}  // namespace
}  // namespace roadbalance
