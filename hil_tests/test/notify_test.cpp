#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <string>

#include "common/test/notify_socket.hpp"
#include "hil_tests/measurement.hpp"

namespace roadbalance {
namespace {

using test::Program;

class Notify : public test::Measurement {
 protected:
  /// Waits for a datagram; those before it are `passed_over`.
  bool hears(const std::string& wanted) {
    passed_over.clear();
    return bus.wait([&] {
      for (std::string datagram; !(datagram = supervisor.heard()).empty(); passed_over += datagram + '\n')
        if (datagram == wanted) return true;
      return false;
    });
  }

  const test::NotifySocket supervisor{work / "notify"};
  std::string passed_over;
};

TEST_F(Notify, ARecorderSaysThatItIsReadyThatItLivesAndThatItBeginsToStop) {
  Program running = recorder();
  ASSERT_TRUE(hears("READY=1"));
  EXPECT_EQ(passed_over, "") << "said before";
  EXPECT_TRUE(hears("WATCHDOG=1"));
  ::unsetenv("NOTIFY_SOCKET");  // for the node, which would send the same
  Program front = node("front", "rate=1&seconds=10000");
  ASSERT_TRUE(more_are_durable(kFront, 10));

  front.signal(SIGSTOP);  // the recorder waits for its last blocks
  EXPECT_TRUE(hears("WATCHDOG=1"));
  EXPECT_EQ(passed_over.find("STOPPING"), std::string::npos) << passed_over;
  running.signal(SIGTERM);
  EXPECT_TRUE(hears("STOPPING=1"));
  EXPECT_FALSE(running.exit_code(0)) << "said only at the end";
  front.signal(SIGCONT);
  end_well(running, {&front});
  expect_complete(1);
}

TEST_F(Notify, ANodeSaysThatItIsReadyThatItLivesAndThatItBeginsToStop) {
  Program front = node("front", "rate=1&seconds=10000");
  ASSERT_TRUE(hears("READY=1"));
  EXPECT_EQ(passed_over, "") << "said before";
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(hears("WATCHDOG=1"));
  front.signal(SIGTERM);
  EXPECT_TRUE(hears("STOPPING=1"));
  EXPECT_EQ(front.exit_code(test::BusWatch::kPatience_s), 0);
}

}  // namespace
}  // namespace roadbalance
