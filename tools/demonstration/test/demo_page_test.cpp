#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "common/process/child.hpp"
#include "common/process/temporary_folder.hpp"

// The demo and the port of its page, as a person starts them.

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

class DemoPageTest : public testing::Test {
 protected:
  static fs::path program(const std::string& name) { return fs::path(std::getenv("RB_BIN")) / name; }
  static int exit_code(Child& child) {
    while (!child.ended()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return *child.ended();
  }
  /// The port of the page whose address a program has printed.
  static std::string port_of(Child& web) {
    std::string said;
    while (!web.ended() && !(said = web.output()).ends_with('\n'))
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const auto end = said.find("/#");
    const auto begin = said.rfind(':', end) + 1;
    return said.substr(begin, end - begin);
  }
  Child demo(const fs::path& rb, const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"demo", "--rate", "max", "--drive-seconds", "100"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Child(rb, arguments, folder_.path() / "rb.log");
  }

  /// The programs in a folder of their own, where a test may put another in the place of one.
  fs::path programs_but(const std::string& missing) const {
    const fs::path bin = folder_.path() / "bin";
    fs::create_directory(bin);
    fs::copy(program("rb"), bin / "rb");  // no link: it looks for the others where it is itself
    for (const char* name : {"rb-node", "rb-recorder", "rb-analyser", "rb-recordings", "rb-web"})
      if (name != missing) fs::create_symlink(program(name), bin / name);
    return bin;
  }

  TemporaryFolder folder_{"demo-page-test"};
};

TEST_F(DemoPageTest, IsOnThePortThatWasAskedFor) {
  for (bool is_taken = true; is_taken;) {
    std::string port;
    {
      Child web(program("rb-web"), {"--port", "0"}, folder_.path() / "web.log");
      port = port_of(web);  // free again when it has ended, unless another program is quicker
    }
    Child rb = demo(program("rb"), {"--port", port});
    const int code = exit_code(rb);
    is_taken = code == 4 && rb.log().find("Address already in use") != std::string::npos;
    if (is_taken) continue;
    EXPECT_EQ(code, 0) << rb.last_words();
    EXPECT_NE(rb.output().find("Watch it in a browser: http://127.0.0.1:" + port + "/#"), std::string::npos)
        << rb.output();
  }
}

TEST_F(DemoPageTest, TheDemoEndsBeforeItBeginsIfThatPortIsTaken) {
  Child taken(program("rb-web"), {"--port", "0"}, folder_.path() / "web.log");
  const std::string port = port_of(taken);
  Child rb = demo(program("rb"), {"--port", port});
  EXPECT_EQ(exit_code(rb), 4);
  EXPECT_TRUE(rb.log().starts_with("rb: no page on port " + port) &&
              rb.log().ends_with("rb-web: listen on 127.0.0.1 port " + port + ": Address already in use\n"))
      << rb.log();
  EXPECT_EQ(rb.output(), "");
}

TEST_F(DemoPageTest, TheDemoDoesWithoutAPageThatNobodyAskedFor) {
  const fs::path bin = programs_but("rb-web");
  Child rb = demo(bin / "rb", {});
  EXPECT_EQ(exit_code(rb), 0) << rb.last_words();
  EXPECT_NE(rb.output().find("\nNo page: "), std::string::npos) << rb.output();
}

TEST_F(DemoPageTest, TheDemoEndsThoughItsAnalyserIsReadyWhenTheDriveIsOver) {
  const fs::path bin = programs_but("rb-analyser");
  std::ofstream(bin / "rb-analyser") << "#!/bin/sh\nsleep 5\nexec " << program("rb-analyser") << " \"$@\"\n";
  fs::permissions(bin / "rb-analyser", fs::perms::owner_all);
  Child rb(bin / "rb", {"demo", "--rate", "max", "--drive-seconds", "2"}, folder_.path() / "rb.log");
  EXPECT_EQ(exit_code(rb), 1);
  EXPECT_TRUE(rb.log().starts_with("rb demo: no wheel was identified: not enough driving")) << rb.log();
}

}  // namespace
}  // namespace roadbalance
