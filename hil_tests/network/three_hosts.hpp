#pragma once

#include <optional>

#include "hil_tests/network/hosts.hpp"

namespace roadbalance::test {

/// What README.md tells people to use on computers of their own.  The namespaces are apart: one port for all
/// tests.
inline constexpr const char* kNetworkUrl = "udpm://239.255.76.67:7667?ttl=1";

/// Made before the measurement, so that its observer is on host 0 too.
struct ThreeHosts {
  std::optional<Hosts> hosts;
  ThreeHosts() {
    if (!Hosts::obstacle()) hosts.emplace(3);
  }
};

}  // namespace roadbalance::test
