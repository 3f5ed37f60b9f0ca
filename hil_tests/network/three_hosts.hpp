#pragma once

#include <optional>

#include "hil_tests/network/hosts.hpp"

namespace roadbalance::test {

/// The namespaces are apart: one port for all tests.
inline constexpr const char* kNetworkUrl = "udpm://239.255.76.67:7667?ttl=1&recv_buf_size=4194304";

/// Made before the measurement, so that its observer is on host 0 too.
struct ThreeHosts {
  std::optional<Hosts> hosts;
  ThreeHosts() {
    if (!Hosts::obstacle()) hosts.emplace(3);
  }
};

}  // namespace roadbalance::test
