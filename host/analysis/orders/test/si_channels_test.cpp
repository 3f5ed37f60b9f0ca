#include "host/analysis/orders/si_channels.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

TEST(SiChannels, AreThoseWantedInTheirOrderWithTheirOverloads) {
  NodeConfig node{"node", 1, 2000.0, {}};
  for (int c = 0; c < 4; ++c) {
    ChannelConfig& channel = node.channel.emplace_back();
    channel.scale_m_s2_per_count = 0.5 * (c + 1);
    channel.offset_counts = 10.0 * c;
  }
  std::array<float, kChannels> counts{};
  for (std::size_t c = 0; c < counts.size(); ++c) counts[c] = 100.0F * static_cast<float>(c + 1);
  const SiChannels channels(node, {3, 1});
  ASSERT_EQ(channels.size(), 2);
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(2, 3);
  EXPECT_EQ(channels.read({&counts, 0b1001, 0}, values.col(1)), 0b01U);
  EXPECT_EQ(values(0, 1), (400.0 - 30.0) * 2.0);
  EXPECT_EQ(values(1, 1), (200.0 - 10.0) * 1.0);
  EXPECT_EQ(channels.read({&counts, 0b0110, 0}, values.col(2)), 0b10U);
  EXPECT_EQ(channels.read({&counts, 0, 0}, values.col(2)), 0U);
  EXPECT_EQ(values.col(0).cwiseAbs().sum(), 0.0);
}

}  // namespace
}  // namespace roadbalance
