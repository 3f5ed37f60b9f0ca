#include "common/bus/order_report.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/bus/other_wire.hpp"
#include "common/types/block.hpp"

namespace roadbalance {
namespace {

OrderReport report() {
  OrderReport sent{.wheel = 3, .node = 7, .time_ns = 123, .seconds = 61.5, .no_angle_s = 2.5};
  for (std::size_t h = 0; h < OrderReport::kOrders; ++h)
    for (std::size_t c = 0; c < 5; ++c)
      sent.order[h][c] = {{1.0 + static_cast<double>(c), -2.0}, 0.25, 0.01 * static_cast<double>(h), 40};
  return sent;
}

TEST(OrderReport, ComesBackAsItWasSent) {
  const OrderReport sent = report();
  const auto bytes = encode(sent);
  EXPECT_LT(bytes.size(), 1400U) << "one datagram";
  const auto got = decode_orders(bytes);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->wheel, 3);
  EXPECT_EQ(got->node, 7);
  EXPECT_EQ(got->seconds, 61.5);
  EXPECT_EQ(got->no_angle_s, 2.5);
  EXPECT_EQ(got->order[1][4].value, std::complex<double>(5.0, -2.0));
  EXPECT_EQ(got->order[1][4].phase_95_rad, 0.01);
  EXPECT_EQ(got->order[0][0].blocks, 40);
  EXPECT_EQ(got->order[0][7].blocks, 0);
  EXPECT_TRUE(std::isnan(got->order[0][7].amplitude_95));
}

TEST(OrderReport, RefusesWhatCannotBe) {
  OrderReport sent = report();
  sent.wheel = 4;
  EXPECT_FALSE(decode_orders(encode(sent)));
  for (const std::int32_t node : {-1, 0, kLastNode + 1}) {
    sent = report();
    sent.node = node;
    EXPECT_FALSE(decode_orders(encode(sent))) << node;
  }
  sent.wheel = 0;
  sent.order[1][2].blocks = -1;
  EXPECT_FALSE(decode_orders(encode(sent)));
  auto bytes = encode(report());
  bytes.pop_back();
  EXPECT_FALSE(decode_orders(bytes));
  bytes.push_back(0);
  bytes[3] ^= 1U;
  EXPECT_FALSE(decode_orders(bytes)) << "another fingerprint";
}

TEST(OrderReport, OfAnotherVersionIsNoticed) {
  auto bytes = encode(report());
  bytes[3] ^= 1U;
  OtherWire wire;
  wire.take(kOrdersChannel, bytes);
  wire.take(kOrdersChannel, bytes);
  const auto sentences = wire.sentences();
  ASSERT_EQ(sentences.size(), 1U);
  EXPECT_NE(sentences[0].find("an analyser is of another version of the wire (RB_ORDERS"), std::string::npos)
      << sentences[0];
}

}  // namespace
}  // namespace roadbalance
