#pragma once

#include <optional>

#include "hil_tests/network/hosts.hpp"

namespace roadbalance::test {

/// The bus URL that README.md gives for separate computers.  The namespaces are apart: one port for all
/// tests.
inline constexpr const char* kNetworkUrl = "udpm://239.255.76.67:7667?ttl=1";

/// Made before the measurement, so that its observer is on host 0 too.
struct ThreeHosts {
  std::optional<Hosts> hosts;
  ThreeHosts() {
    if (!Hosts::refusal()) hosts.emplace(3);
  }
};

}  // namespace roadbalance::test
