#include "tools/demonstration/demo_page.hpp"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>

#include "common/types/clocks.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kLook{10};

}  // namespace

DemoPage::DemoPage(const DemoPlan& plan) : asked_port_(plan.page_port()) {
  try {
    std::filesystem::create_directories(plan.recordings());  // the recorder makes its folder later
    recordings_.emplace(sibling_program("rb-recordings"),
                        std::vector<std::string>{"--url", plan.url(), "--folder", plan.recordings().string()},
                        plan.work() / "recordings.log");
  } catch (const std::system_error&) {
    // The page shows that no list is heard.
  }
  try {
    web_.emplace(sibling_program("rb-web"),
                 std::vector<std::string>{"--url", plan.url(), "--port", std::to_string(asked_port_)},
                 plan.work() / "web.log");
  } catch (const std::system_error& error) {
    obstacle_ = error.what();
  }
}

std::string DemoPage::where() {
  constexpr std::chrono::seconds kPatience{5};
  if (!web_) return no_page(obstacle_);
  for (const WallTime end = WallClock::now() + kPatience; WallClock::now() < end;) {
    if (const std::string url = web_->output(); url.ends_with('\n'))
      return "Watch it in a browser: " + url.substr(0, url.size() - 1);
    if (web_->ended()) return no_page("rb-web " + web_->how_it_ended());
    std::this_thread::sleep_for(kLook);
  }
  return no_page("rb-web has not said where it is");
}

std::string DemoPage::no_page(const std::string& why) const {
  if (asked_port_ == 0) return "No page: " + why;
  throw std::runtime_error("no page on port " + std::to_string(asked_port_) +
                           " (--port names another, without it a free one is taken): " + why);
}

void DemoPage::stay(std::stop_token stop) {
  if (!web_ || web_->ended() || isatty(STDIN_FILENO) != 1 || isatty(STDOUT_FILENO) != 1) return;
  std::printf("The page shows the result until you press Ctrl-C.\n");
  std::fflush(stdout);
  while (!stop.stop_requested() && !web_->ended()) std::this_thread::sleep_for(kLook);
}

}  // namespace roadbalance
