#pragma once

#include <string>

namespace roadbalance {

struct LiveOrdersOptions {
  std::string url;
  double seconds = 0.0;  ///< 0: until interrupted
  bool json = false;
};

/// Prints what the analyser on the bus says of orders, once a second; with json an object on a line of its
/// own.
/// @return an ExitCode: whether any order was heard
int show_live_orders(const LiveOrdersOptions& options);

}  // namespace roadbalance
