#pragma once

#include <optional>
#include <stop_token>
#include <string>

#include "tools/rb/child.hpp"
#include "tools/rb/demo_plan.hpp"

namespace roadbalance {

/// rb-web beside a demo.  It only looks on: without it, or when it fails, the demo is the same.
class DemoPage {
 public:
  explicit DemoPage(const DemoPlan& plan);

  /// Where the page is, or why there is none; a sentence.
  std::string where();
  /// On a terminal the page stays, with the last results, until told to stop.
  void stay(std::stop_token stop);

 private:
  std::optional<Child> web_;
  std::string obstacle_;
};

}  // namespace roadbalance
