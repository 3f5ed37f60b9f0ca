#include "tools/doctor/bus_interface.hpp"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <initializer_list>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/message_format.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

/// A table of such rows: interface, destination, flags, metric, mask.
std::string table(std::initializer_list<std::array<const char*, 5>> rows) {
  std::string text = "Iface\tDestination\tGateway \tFlags\tRefCnt\tUse\tMetric\tMask\t\tMTU\tWindow\tIRTT\n";
  for (const auto& [name, destination, flags, metric, mask] : rows)
    text += std::string(name) + "\t" + destination + "\t00000000\t" + flags + "\t0\t0\t" + metric + "\t" +
            mask + "\t0\t0\t0\n";
  return text;
}

TEST(MulticastInterface, IsMissingOnALaptopWithoutNetwork) {
  EXPECT_FALSE(multicast_interface(""));
  EXPECT_FALSE(multicast_interface(table({})));
  // 192.168.1.0/24 alone leads nowhere for 224.0.0.0/4.
  EXPECT_FALSE(multicast_interface(table({{"eth0", "0001A8C0", "0001", "0", "00FFFFFF"}})));
  const auto findings = way_findings(std::nullopt, true);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].state, Finding::kIll);
  EXPECT_NE(findings[0].remedy.find("ip route add 224.0.0.0/4 dev lo"), std::string::npos);
  EXPECT_NE(findings[0].remedy.find("for good: "), std::string::npos);
}

TEST(MulticastInterface, IsOfTheDefaultRouteOrOfItsOwn) {
  EXPECT_EQ(multicast_interface(table({{"eth0", "00000000", "0003", "0", "00000000"}})), "eth0");
  EXPECT_EQ(multicast_interface(table({{"lo", "000000E0", "0001", "0", "000000F0"}})), "lo");
  // Every route that holds the group will do, of whatever length.
  EXPECT_EQ(multicast_interface(table({{"eth1", "000000EF", "0001", "0", "000000FF"}})), "eth1");
  EXPECT_EQ(multicast_interface(table({{"eth1", "0000FFEF", "0001", "0", "0000FFFF"}})), "eth1");
  EXPECT_EQ(multicast_interface(table({{"eth1", "434CFFEF", "0001", "0", "FFFFFFFF"}})), "eth1");
  EXPECT_FALSE(multicast_interface(table({{"eth1", "0000FEEF", "0001", "0", "0000FFFF"}})));
  EXPECT_EQ(multicast_interface(table({{"eth1", "0000FEEF", "0001", "0", "0000FFFF"}}), 0xEFFE0102), "eth1");
}

// As the kernel chooses: ip-route(8).
TEST(MulticastInterface, IsOfTheNarrowestRouteWithTheLeastMetric) {
  EXPECT_EQ(multicast_interface(table({{"wlan0", "00000000", "0003", "600", "00000000"},
                                       {"eth0", "00000000", "0003", "100", "00000000"},
                                       {"eth1", "00000000", "0003", "200", "00000000"}})),
            "eth0");
  EXPECT_EQ(multicast_interface(table({{"wlan0", "000000E0", "0001", "900", "000000F0"},
                                       {"eth0", "00000000", "0003", "100", "00000000"}})),
            "wlan0");
  EXPECT_FALSE(multicast_interface(
      table({{"*", "000000E0", "0201", "0", "000000F0"}, {"eth0", "00000000", "0003", "0", "00000000"}})))
      << "unreachable";
}

class Interface : public testing::Test {
 protected:
  void say(const std::string& file, const std::string& text) {
    const auto path = std::filesystem::path(sys_ / "class/net/eth0") / file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text << "\n";
  }
  NetworkInterface eth0() const { return network_interface("eth0", sys_.path()); }
  std::string names(bool stays_on_machine) const {
    std::string all;
    for (const Finding& finding : way_findings(eth0(), stays_on_machine)) {
      EXPECT_EQ(finding.state == Finding::kWell, finding.remedy.empty());
      all += (finding.state == Finding::kWell ? "+" : "-") + finding.name;
    }
    return all;
  }
  test::TemporaryDirectory sys_;
};

TEST_F(Interface, IsWellAtOrdinaryEthernet) {
  say("mtu", "1500");
  say("speed", "1000");
  say("carrier", "1");
  EXPECT_EQ(names(false), "+multicast_route");
  EXPECT_EQ(way_findings(eth0(), false)[0].sentence, "The bus goes over eth0 at 1000 Mbit/s.");
}

TEST_F(Interface, OfWhichNothingIsToldIsWell) {
  EXPECT_EQ(names(false), "+multicast_route");
  say("speed", "-1");  // a virtual one's
  EXPECT_EQ(way_findings(eth0(), false)[0].sentence, "The bus goes over eth0.");
}

TEST_F(Interface, CarriesABlockInOnePieceOrSaysSo) {
  ScanBlock block;
  block.header = {.node = 1, .epoch = 1, .sequence = 1, .scans = kScansPerBlock};
  SealedBlock sealed;
  seal(block, sealed);
  EXPECT_EQ(20 + 8 + kShortHeader + block_channel(1, BlockKind::kScan).size() + 1 + sealed.size, 1404U);
  say("mtu", "1404");
  EXPECT_EQ(names(true), "+multicast_route");
  say("mtu", "1403");
  EXPECT_EQ(names(true), "-mtu");
  EXPECT_NE(way_findings(eth0(), true)[0].sentence.find("a block (1404)"), std::string::npos);
}

TEST_F(Interface, OfRadioOrSlowOrUnpluggedMattersToOtherMachinesOnly) {
  say("speed", "10");
  EXPECT_EQ(names(false), "-speed");
  say("speed", "100");
  EXPECT_EQ(names(false), "+multicast_route");
  say("carrier", "0");
  EXPECT_EQ(names(false), "-cable");
  say("carrier", "1");
  say("phy80211/name", "phy0");
  EXPECT_EQ(names(false), "-wireless");
  EXPECT_EQ(names(true), "+multicast_route");
}

TEST_F(Interface, IsFoundByTheTableOfRoutes) {
  const test::TemporaryDirectory proc;
  say("phy80211/name", "phy0");
  std::filesystem::create_directories(proc / "net");
  std::ofstream(proc / "net/route") << table({{"eth0", "00000000", "0003", "0", "00000000"}});
  const auto first = [&](const std::string& url) {
    return examine_way(url, proc.path(), sys_.path())[0].name;
  };
  EXPECT_EQ(first(""), "wireless");
  EXPECT_EQ(first("udpm://239.255.76.67:7667?ttl=1"), "wireless");
  EXPECT_EQ(first("udpm://239.255.76.67:7667?ttl=0"), "multicast_route");
}

TEST(ReceiveBuffer, IsEnoughFromFourMebibytesOn) {
  const test::TemporaryDirectory proc;
  EXPECT_EQ(receive_buffer(4'194'304, proc.path()).state, Finding::kWell);
  const Finding small = receive_buffer(212'992, proc.path());
  EXPECT_EQ(small.state, Finding::kNote);
  EXPECT_NE(small.sentence.find("0.2 MiB"), std::string::npos) << small.sentence;
  EXPECT_NE(small.remedy.find("sysctl.d"), std::string::npos) << "that it stays: " << small.remedy;
  EXPECT_NE(small.remedy.find("net.core.rmem_max=4194304"), std::string::npos) << small.remedy;
  std::filesystem::create_directories(proc / "sys/net/core");
  const auto rmem_max = [&proc](int bytes) {
    std::ofstream(proc / "sys/net/core/rmem_max") << bytes << "\n";
  };
  rmem_max(212'992);
  EXPECT_EQ(receive_buffer(212'992, proc.path()).remedy, small.remedy);
  rmem_max(8'388'608);
  EXPECT_NE(receive_buffer(212'992, proc.path()).remedy.find("recv_buf_size"), std::string::npos)
      << "the address asks for less than the kernel would give";
}

}  // namespace
}  // namespace roadbalance
