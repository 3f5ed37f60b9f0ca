#include "hil_tests/measurement.hpp"

#include <csignal>

#include "common/test/bus_url.hpp"
#include "common/test/source.hpp"
#include "hil_tests/simulated_truth.hpp"

namespace roadbalance::test {
namespace {

const std::string kSeed = "seed=3";

}  // namespace

Measurement::Measurement() : Measurement(test::bus_url()) {}

Measurement::Measurement(const std::string& bus_url) : url(bus_url), bus(url) {}

Program Measurement::recorder(const std::filesystem::path& folder,
                              const std::vector<std::string>& more) const {
  std::vector<std::string> words{"--record", folder, "--url", url};
  words.insert(words.end(), more.begin(), more.end());
  return {"rb-recorder", words};
}

Program Measurement::node(const std::string& name, const std::string& drive,
                          const std::vector<std::string>& more) const {
  std::vector<std::string> words{
      "--vehicle",   source_path("sim/demo/vehicle.toml"), "--node", name, "--url", url,
      "--front-end", "sim:?" + kSeed + "&" + drive};
  words.insert(words.end(), more.begin(), more.end());
  return {"rb-node", words};
}

Program Measurement::analyser(const std::vector<std::string>& more) const {
  std::vector<std::string> words{"--record", record, "--url", url};
  words.insert(words.end(), more.begin(), more.end());
  return {"rb-analyser", words};
}

bool Measurement::more_are_durable(std::int32_t node, std::int64_t blocks) {
  const Ack before = bus.ack(node);
  return bus.wait([&] {
    const Ack now = bus.ack(node);
    return now.durable >= blocks + (now.epoch == before.epoch ? before.durable : 0);
  });
}

bool Measurement::backlog_is_gone(std::int32_t node) {
  return bus.wait([&] {
    const Heartbeat heartbeat = bus.heartbeat(node);
    return heartbeat.ring_used < heartbeat.ring_capacity / 8;
  });
}

void Measurement::end_well(Program& recorder, std::vector<Program*> nodes) const {
  recorder.signal(SIGTERM);
  EXPECT_EQ(recorder.exit_code(BusWatch::kPatience_s), 0);
  for (Program* node : nodes) EXPECT_EQ(node->exit_code(BusWatch::kPatience_s), 0);
}

void Measurement::expect_complete(const std::filesystem::path& folder, std::size_t epochs) const {
  expect_verified(folder, epochs);
  EXPECT_EQ(check_record(folder), 0) << "the independent checker disagrees";
}

void Measurement::expect_as_simulated(const std::filesystem::path& folder, const std::string& node,
                                      const std::string& drive) const {
  test::expect_as_simulated(folder, node, kSeed + "&" + drive);
}

void Measurement::expect_verified(const std::filesystem::path& folder, std::size_t epochs) const {
  const Verification verification = verify_record(folder);
  EXPECT_EQ(verification.verdict, Verdict::kComplete) << verdict_text(verification);
  ASSERT_EQ(verification.epoch.size(), epochs);
  for (const auto& epoch : verification.epoch) {
    EXPECT_TRUE(epoch.is_complete()) << "node " << epoch.node;
    EXPECT_GT(epoch.samples, 0);
    EXPECT_EQ(epoch.samples, epoch.samples_sent);
    EXPECT_EQ(epoch.repeated_blocks, 0);
  }
}

int check_record(const std::filesystem::path& folder) {
  return run("python3", {source_path("tools/check_record.py"), folder}, BusWatch::kPatience_s);
}

}  // namespace roadbalance::test
