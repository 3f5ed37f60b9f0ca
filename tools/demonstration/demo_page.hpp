#pragma once

#include <optional>
#include <stop_token>
#include <string>

#include "common/process/child.hpp"
#include "tools/demonstration/demo_plan.hpp"

namespace roadbalance {

/// rb-web beside a demo, and rb-recordings for its list of recordings.  They only look on: without them, or
/// when they fail, the demo is the same.
class DemoPage {
 public:
  explicit DemoPage(const DemoPlan& plan);

  /// Where the page is, or why there is none; a sentence.
  /// @throws std::runtime_error if it is not on the port that was asked for: a person may wait for it there
  std::string where();
  /// On a terminal the page stays, with the last results, until asked to stop.
  void stay(std::stop_token stop);

 private:
  std::string no_page(const std::string& why) const;

  std::optional<Child> recordings_;
  std::optional<Child> web_;
  std::string obstacle_;
  int asked_port_;
};

}  // namespace roadbalance
