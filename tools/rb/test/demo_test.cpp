#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/process_port.hpp"
#include "common/process/child.hpp"
#include "embedded/demo_scenario.hpp"
#include "embedded/demo_vehicle.hpp"

// The programs end to end, as a person starts them.

namespace roadbalance {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

fs::path program(const std::string& name) {
  return fs::path(std::getenv("RB_BIN")) / name;
}

std::string read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::set<std::string> keys(const Json& object) {
  std::set<std::string> names;
  for (const auto& [key, value] : object.items()) names.insert(key);
  return names;
}

class DemoTest : public testing::Test {
 protected:
  DemoTest() {
    std::string name = (fs::temp_directory_path() / "demo-test-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  ~DemoTest() override { fs::remove_all(folder_); }

  Child start(const std::vector<std::string>& arguments) {
    return Child(program("rb"), arguments, folder_ / ("rb-" + std::to_string(++started_) + ".log"));
  }
  static int wait(Child& child) {
    while (!child.ended()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return *child.ended();
  }
  /// Runs rb to its end; its one JSON object.
  Json run(const std::vector<std::string>& arguments, int expected_code = 0) {
    Child rb = start(arguments);
    EXPECT_EQ(wait(rb), expected_code) << rb.last_words();
    const std::string output = rb.output();
    EXPECT_EQ(std::count(output.begin(), output.end(), '\n'), 1) << output;
    return Json::parse(output);
  }

  fs::path folder_;
  int started_ = 0;
};

/// The state of a process by the kernel; empty if it has just ended.
std::string of_process(pid_t pid, const char* file) {
  try {
    return read_file("/proc/" + std::to_string(pid) + "/" + file);
  } catch (const std::ios_base::failure&) {
    return "";
  }
}

/// Children of a process by name, as the kernel has them.
std::vector<pid_t> children(pid_t parent, const std::string& name) {
  std::ifstream list("/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) + "/children");
  std::vector<pid_t> found;
  for (pid_t pid; list >> pid;)
    if (of_process(pid, "comm") == name + "\n") found.push_back(pid);
  return found;
}

std::vector<std::string> demo_arguments(const std::string& seconds) {
  return {"demo", "--headless", "--json", "--seed", "3", "--drive-seconds", seconds, "--rate", "max"};
}

TEST_F(DemoTest, RecordsEverySampleAndTheRecordingSaysWhatTheLiveRunSaid) {
  const std::string record = (folder_ / "record").string();
  auto arguments = demo_arguments("100");
  arguments.insert(arguments.end(), {"--record", record});
  const Json demo = run(arguments);

  EXPECT_EQ(keys(demo), (std::set<std::string>{"wheels", "nodes", "drive_s", "wall_s"}));
  ASSERT_EQ(demo["wheels"].size(), 4U);
  for (const Json& wheel : demo["wheels"])
    EXPECT_EQ(keys(wheel), (std::set<std::string>{"name", "unbalance_g", "angle_deg", "sigma_g", "sigma_deg",
                                                  "covariance_g2", "force_state", "alone_g", "alone_deg",
                                                  "sigma_alone_g", "force_n", "force_deg", "sigma_force_n",
                                                  "tyre_stiffness_n_m", "sigma_tyre_stiffness_n_m", "truth_g",
                                                  "truth_deg", "truth_tyre_stiffness_n_m"}));
  ASSERT_EQ(demo["nodes"].size(), 2U);
  for (const Json& node : demo["nodes"]) {
    EXPECT_EQ(keys(node),
              (std::set<std::string>{"name", "samples_sent", "samples_recorded", "gaps", "repaired"}));
    EXPECT_EQ(node["samples_sent"], node["samples_recorded"]);
    EXPECT_EQ(node["gaps"], 0);
    // 100 s at 2 kHz; the start takes effect at a scan, so some at the beginning may be before it.
    EXPECT_GT(node["samples_recorded"], 198'000);
    EXPECT_LE(node["samples_recorded"], 200'001);
  }

  EXPECT_EQ(run({"verify", record, "--json"}).at("complete"), true);

  Json live = demo["wheels"];
  EXPECT_TRUE(live[0]["unbalance_g"].is_number()) << "without an estimate there is nothing to compare";
  for (Json& wheel : live)
    for (const char* truth : {"truth_g", "truth_deg", "truth_tyre_stiffness_n_m"}) wheel.erase(truth);
  EXPECT_EQ(run({"identify", record, "--json"})["wheels"], live);
}

TEST_F(DemoTest, GivesTheSameWithThreadsAsWithProcesses) {
  auto arguments = demo_arguments("100");
  const Json processes = run(arguments);
  arguments.push_back("--threads");
  const Json threads = run(arguments);
  for (std::size_t n = 0; n < 2; ++n)
    EXPECT_EQ(threads["nodes"][n]["samples_sent"], threads["nodes"][n]["samples_recorded"]);
  EXPECT_EQ(threads["wheels"], processes["wheels"]);
}

// The truth must not reach those who are to find it: not by command line, not by open file, not by the
// record, not by what they are linked from.
TEST_F(DemoTest, RecorderAndAnalyserNeverReceiveTheScenario) {
  const std::string mark = "mark-that-only-the-scenario-bears";
  const fs::path scenario = folder_ / (mark + ".toml");
  std::ofstream(scenario) << "# " << mark << "\n" << embedded::kDemoScenario;
  const std::string record = (folder_ / "record").string();
  Child rb = start({"demo", "--headless", "--json", "--drive-seconds", "20", "--rate", "20", "--scenario",
                    scenario.string(), "--record", record});

  const auto says = [&](pid_t pid) {
    std::string all = of_process(pid, "cmdline") + of_process(pid, "environ");
    std::error_code gone;
    fs::directory_iterator file("/proc/" + std::to_string(pid) + "/fd", gone);
    for (; !gone && file != fs::directory_iterator(); file.increment(gone)) {
      std::error_code closed;
      all += fs::read_symlink(file->path(), closed).string() + "\n";
    }
    return all;
  };
  bool node_knows = false;
  std::set<std::string> looked_at;
  while (!rb.ended()) {
    for (const char* name : {"rb-recorder", "rb-analyser"})
      for (const pid_t pid : children(rb.pid(), name)) {
        const std::string all = says(pid);
        EXPECT_EQ(all.find(mark), std::string::npos) << name;
        if (all.find("--record") != std::string::npos) looked_at.insert(name);
      }
    for (const pid_t pid : children(rb.pid(), "rb-node"))
      node_knows = node_knows || says(pid).find(mark) != std::string::npos;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(wait(rb), 1) << rb.last_words();
  EXPECT_NE(rb.log().find("no wheel was identified: not enough driving"), std::string::npos) << rb.log();
  EXPECT_TRUE(node_knows) << "the search must find what is there";
  EXPECT_EQ(looked_at.size(), 2U);

  std::uintmax_t bytes = 0;
  for (const auto& file : fs::recursive_directory_iterator(record)) {
    const std::string text = file.is_regular_file() ? read_file(file.path()) : "";
    bytes += text.size();
    EXPECT_EQ(text.find(mark), std::string::npos) << file.path();
  }
  EXPECT_GT(bytes, 1'000'000U);
}

TEST(DemoPrograms, OfTheThreeOnlyTheNodeContainsTheSimulator) {
  const std::string simulator = "11roadbalance3sim";  // namespace roadbalance::sim in mangled names
  EXPECT_NE(read_file(program("rb-node")).find(simulator), std::string::npos);
  EXPECT_EQ(read_file(program("rb-recorder")).find(simulator), std::string::npos);
  EXPECT_EQ(read_file(program("rb-analyser")).find(simulator), std::string::npos);
}

TEST_F(DemoTest, LeavesNothingBehindWhenInterrupted) {
  setenv("TMPDIR", folder_.c_str(), 1);
  Child rb = start({"demo", "--rate", "1", "--drive-seconds", "1000"});
  std::vector<pid_t> nodes;
  while (!rb.ended() && (nodes = children(rb.pid(), "rb-node")).size() < 2)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_EQ(nodes.size(), 2U) << rb.last_words();
  kill(rb.pid(), SIGINT);
  EXPECT_EQ(wait(rb), 1);
  for (const pid_t node : nodes) EXPECT_NE(kill(node, 0), 0);
  for (const auto& entry : fs::directory_iterator(folder_))
    EXPECT_NE(entry.path().filename().string().substr(0, 7), "rb-demo") << entry.path();
  unsetenv("TMPDIR");
}

TEST_F(DemoTest, PrintsWhereThePageIsAndTakesItAlongWhenItEnds) {
  Child rb = start({"demo", "--rate", "max", "--drive-seconds", "100"});
  std::vector<pid_t> web;
  while (!rb.ended() && (web = children(rb.pid(), "rb-web")).empty())
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(wait(rb), 0) << rb.last_words();
  ASSERT_EQ(web.size(), 1U);
  EXPECT_NE(kill(web[0], 0), 0);
  EXPECT_NE(rb.output().find("Watch it in a browser: http://127.0.0.1:"), std::string::npos) << rb.output();
}

TEST_F(DemoTest, NamesWhatIsWrongBeforeAnythingStarts) {
  const auto fails = [&](const std::vector<std::string>& arguments, const std::string& named, int code = 2) {
    Child rb = start(arguments);
    EXPECT_EQ(wait(rb), code);
    EXPECT_NE(rb.log().find(named), std::string::npos) << rb.log();
    EXPECT_EQ(rb.output(), "");
  };
  fails({"demo", "--rate", "fast"}, "rate");
  fails({"demo", "--rate", "0"}, "--rate: '0' cannot be used");
  fails({"demo", "--drive-seconds", "-1"}, "--drive-seconds");
  fails({"demo", "--drive-seconds", "abc"}, "--drive-seconds: 'abc' cannot be used; allowed: 1 .. 1000000 s");
  fails({"demo", "--seed", "-3"}, "--seed: '-3' cannot be used");
  fails({"demo", "--vehicle", "nowhere.toml"}, "nowhere.toml: No such file", 4);
  fails({"demo", "--scenario", "/tmp"}, "/tmp: Is a directory", 4);
  std::ofstream(folder_ / "vehicle.toml") << "colour = \"red\"\n" << embedded::kDemoVehicle;
  fails({"demo", "--vehicle", (folder_ / "vehicle.toml").string()}, "colour");
  fails({"demo", "--record", folder_.string()}, "not empty");
  fails({"demo", "--json", "--port", "8080"}, "--port excludes --json");
  fails({"fly"}, "unknown subcommand fly");
  fails({"import", "xls"}, "unknown subcommand xls");
}

TEST_F(DemoTest, NamesTheNodeThatWasKilled) {
  Child rb = start({"demo", "--rate", "1", "--drive-seconds", "1000"});
  std::vector<pid_t> nodes;
  while (!rb.ended() && (nodes = children(rb.pid(), "rb-node")).size() < 2)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_EQ(nodes.size(), 2U) << rb.last_words();
  const bool is_rear = of_process(nodes[0], "cmdline").find("rear") != std::string::npos;
  kill(nodes[0], SIGKILL);
  EXPECT_EQ(wait(rb), 4);
  EXPECT_NE(
      rb.log().find(std::string("node ") + (is_rear ? "rear" : "front") + " (rb-node) was ended by signal 9"),
      std::string::npos)
      << rb.log();
}

TEST_F(DemoTest, KeepsOffABusThatSomebodyUses) {
  const int port = process_port();
  Child first = start({"demo", "--rate", "1", "--drive-seconds", "1000", "--bus-port", std::to_string(port)});
  Bus bus(bus_url_on_port(port));
  bool heard = false;
  bus.subscribe("RB_HEARTBEAT_.*", [&](std::string_view, std::span<const std::uint8_t>) { heard = true; });
  while (!heard && !first.ended()) bus.handle(std::chrono::milliseconds(100));
  ASSERT_TRUE(heard) << first.last_words();
  Child second =
      start({"demo", "--json", "--drive-seconds", "2", "--rate", "max", "--bus-port", std::to_string(port)});
  EXPECT_EQ(wait(second), 4);
  EXPECT_NE(second.log().find("another recorder or node is on port " + std::to_string(port)),
            std::string::npos)
      << second.log();
  EXPECT_FALSE(first.ended());
  kill(first.pid(), SIGINT);
  EXPECT_EQ(wait(first), 1);
}

TEST_F(DemoTest, SaysThatNoAnalyserIsThere) {
  Child rb = start({"watch", "--json", "--seconds", "0.2", "--url", bus_url_on_port(process_port(1))});
  EXPECT_EQ(wait(rb), 1);
  EXPECT_EQ(rb.output(), "");
  EXPECT_NE(rb.log().find("no analyser heard"), std::string::npos) << rb.log();
}

TEST(DemoPrograms, AResultThatCannotBeWrittenIsNoSuccess) {
  const std::string command = program("rb").string() + " doctor --json >/dev/full 2>/dev/null";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 4);
}

}  // namespace
}  // namespace roadbalance
