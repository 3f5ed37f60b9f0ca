#include "tools/rb/machine.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

namespace roadbalance {
namespace {

constexpr const char* kHeader =
    "Iface\tDestination\tGateway \tFlags\tRefCnt\tUse\tMetric\tMask\t\tMTU\tWindow\tIRTT\n";

TEST(MulticastRoute, IsMissingOnALaptopWithoutNetwork) {
  EXPECT_FALSE(has_multicast_route(""));
  EXPECT_FALSE(has_multicast_route(kHeader));
  // 192.168.1.0/24 alone leads nowhere for 224.0.0.0/4.
  EXPECT_FALSE(has_multicast_route(std::string(kHeader) +
                                   "eth0\t0001A8C0\t00000000\t0001\t0\t0\t0\t00FFFFFF\t0\t0\t0\n"));
  const Finding finding = multicast_route(kHeader);
  EXPECT_EQ(finding.state, Finding::kIll);
  EXPECT_NE(finding.remedy.find("ip route add 224.0.0.0/4 dev lo"), std::string::npos);
}

TEST(MulticastRoute, IsTheDefaultRouteOrItsOwn) {
  EXPECT_TRUE(has_multicast_route(std::string(kHeader) +
                                  "eth0\t00000000\t010011AC\t0003\t0\t0\t0\t00000000\t0\t0\t0\n"));
  EXPECT_TRUE(has_multicast_route(std::string(kHeader) +
                                  "lo\t000000E0\t00000000\t0001\t0\t0\t0\t000000F0\t0\t0\t0\n"));
  EXPECT_EQ(multicast_route(std::string(kHeader) + "lo\t000000E0\t0\t1\t0\t0\t0\t000000F0\t0\t0\t0\n").state,
            Finding::kWell);
}

TEST(ReceiveBuffer, IsEnoughFromFourMebibytesOn) {
  EXPECT_EQ(receive_buffer(4'194'304).state, Finding::kWell);
  const Finding finding = receive_buffer(212'992);
  EXPECT_EQ(finding.state, Finding::kNote);
  EXPECT_EQ(finding.remedy, "sudo sysctl -w net.core.rmem_max=4194304");
}

TEST(WritableFolder, LooksAtWhereTheFolderWouldBeCreated) {
  EXPECT_EQ(writable_folder("not/there/yet").state, Finding::kWell);
  EXPECT_EQ(writable_folder("/proc/not/there").state, Finding::kIll);
}

TEST(Loopback, BringsAMessageBack) {
  EXPECT_EQ(loopback(20'000 + getpid() % 20'000).state, Finding::kWell);
}

}  // namespace
}  // namespace roadbalance
