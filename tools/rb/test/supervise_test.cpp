#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "common/process/child.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

// Real programs under `rb supervise`; each leaves a line in the file `runs` when it starts.
class Supervise : public ::testing::Test {
 protected:
  Child supervise(std::vector<std::string> options, const std::string& shell) {
    std::vector<std::string> words{"supervise"};
    words.insert(words.end(), options.begin(), options.end());
    for (const std::string& word :
         {std::string("--"), std::string("bash"), std::string("-c"),
          "echo $$ >> " + (folder / "runs") + "\n" + "run=$(wc -l < " + (folder / "runs") + ")\n" + shell})
      words.push_back(word);
    return {std::filesystem::path(std::getenv("RB_BIN")) / "rb", words, folder / "log"};
  }

  // The process numbers of all runs so far.
  std::vector<pid_t> runs() const {
    std::ifstream file(folder / "runs");
    return {std::istream_iterator<pid_t>(file), {}};
  }

  // A bound for slow machines, not a measurement.
  static bool wait_until(const std::function<bool()>& condition) {
    for (int i = 0; i < 6000; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
  static int code_of(Child& child) {
    wait_until([&] { return child.ended().has_value(); });
    return child.ended().value_or(-1);
  }
  bool has_started(std::size_t times) const {
    return wait_until([&] { return runs().size() >= times; });
  }

  const test::TemporaryDirectory folder;
};

// As a program of ours does: datagrams to the supervisor.  The first two runs feed once and hang, the third
// feeds for longer than the watchdog of two seconds waits, much oftener than it must.
constexpr const char* kFeedsInItsThirdRun = R"(run=$run exec python3 -c '
import os, signal, socket, time
run = int(os.environ["run"])
def feed():
    sender.sendto(f"WATCHDOG=1\nSTATUS=run {run}".encode(), os.environ["NOTIFY_SOCKET"])
sender = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
feed()
if run < 3:
    os.kill(os.getpid(), signal.SIGSTOP)
end = time.monotonic() + 3
while time.monotonic() < end:
    time.sleep(0.02)
    feed()
')";

TEST_F(Supervise, EndsWithTheCodeOfAProgramThatEndedWell) {
  Child done = supervise({}, "exit 0");
  EXPECT_EQ(code_of(done), 0);
  Child usage = supervise({}, "exit 2");
  EXPECT_EQ(code_of(usage), 2);
  EXPECT_EQ(runs().size(), 2u);
}

TEST_F(Supervise, StartsAProgramAgainThatWasKilled) {
  Child supervisor = supervise({}, "if [ $run -lt 4 ]; then kill -9 $$; fi; exit 0");
  EXPECT_EQ(code_of(supervisor), 0) << supervisor.log();
  EXPECT_EQ(runs().size(), 4u);
  EXPECT_NE(supervisor.log().find("ended by signal 9"), std::string::npos) << supervisor.log();
}

TEST_F(Supervise, DoesNotStartAProgramForEverThatIsNotThere) {
  Child supervisor(std::filesystem::path(std::getenv("RB_BIN")) / "rb",
                   {"supervise", "--", "/no/such/program"}, folder / "log");
  EXPECT_EQ(code_of(supervisor), 127);
  EXPECT_NE(supervisor.log().find("/no/such/program"), std::string::npos) << supervisor.log();
}

TEST_F(Supervise, PassesSignalsOnAndEndsWithTheProgram) {
  Child supervisor =
      supervise({}, "trap 'exit 7' TERM; trap 'echo heard >> " + (folder / "heard") + "' USR1; echo > " +
                        (folder / "ready") + "; while true; do sleep 0.05; done");
  ASSERT_TRUE(wait_until([&] { return std::filesystem::exists(folder / "ready"); }));
  kill(supervisor.pid(), SIGUSR1);
  EXPECT_TRUE(wait_until([&] { return std::filesystem::exists(folder / "heard"); }));
  supervisor.stop();
  EXPECT_EQ(code_of(supervisor), 7);
  EXPECT_EQ(runs().size(), 1u);
}

TEST_F(Supervise, KillsAProgramThatHangsAndStartsItAgain) {
  Child supervisor = supervise({"--watchdog", "2"}, kFeedsInItsThirdRun);
  EXPECT_EQ(code_of(supervisor), 0) << supervisor.log();
  EXPECT_EQ(runs().size(), 3u) << "the third fed its watchdog longer than that waits";
  const std::string log = supervisor.log();
  EXPECT_NE(log.find("it hangs and is killed"), std::string::npos) << log;
  EXPECT_NE(log.find("it last said: run 2"), std::string::npos) << log;
}

// A program that ignores the ends of its children passes that on to all that it starts: the kernel then
// reports none.
class SuperviseBelowOneThatIgnoresItsChildren : public Supervise {
 protected:
  ~SuperviseBelowOneThatIgnoresItsChildren() override { heed(); }
  void heed() { ::signal(SIGCHLD, before_); }

 private:
  const sighandler_t before_ = ::signal(SIGCHLD, SIG_IGN);
};

TEST_F(SuperviseBelowOneThatIgnoresItsChildren, NoticesTheEndsOfItsProgram) {
  Child supervisor = supervise({}, "if [ $run -lt 3 ]; then exit 4; fi; exit 0");
  heed();
  EXPECT_EQ(code_of(supervisor), 0) << supervisor.log();
  EXPECT_EQ(runs().size(), 3u);
  EXPECT_NE(supervisor.log().find("ended with code 4"), std::string::npos) << supervisor.log();
}

TEST_F(SuperviseBelowOneThatIgnoresItsChildren, StartsItsProgramWithASignalThatIsHeeded) {
  Child supervisor(std::filesystem::path(std::getenv("RB_BIN")) / "rb",
                   {"supervise", "--", "grep", "SigIgn", "/proc/self/status"}, folder / "log");
  heed();
  EXPECT_EQ(code_of(supervisor), 0) << supervisor.log();
  std::istringstream words(supervisor.output());  // proc(5): "SigIgn: 0000000000010000", bit 0 is signal 1
  std::string name;
  std::uint64_t ignored = 0;
  ASSERT_TRUE(words >> name >> std::hex >> ignored) << supervisor.output();
  EXPECT_EQ(ignored >> (SIGCHLD - 1) & 1, 0u) << supervisor.output();
}

TEST_F(Supervise, StartsACrashingProgramMoreAndMoreSlowlyAndCanStillBeStopped) {
  Child supervisor = supervise({}, "exit 4");
  ASSERT_TRUE(has_started(4));
  supervisor.stop();
  EXPECT_TRUE(wait_until([&] { return supervisor.ended().has_value(); }));
  // The waits are 0, 0.1, 0.2, 0.4 s and so on: see supervisor_test.
  EXPECT_LT(runs().size(), 12u);
}

}  // namespace
}  // namespace roadbalance
