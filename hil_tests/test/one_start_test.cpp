#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/record/record_reader.hpp"
#include "hil_tests/test/operating_fixture.hpp"

// All nodes of a recording begin, and end, at one instant.
namespace roadbalance {
namespace {

using test::Program;

class OneStart : public test::Operating {
 protected:
  struct Span {
    std::int64_t begin_ns = 0, end_ns = 0;
    std::int64_t late = 0, other_gaps = 0;
  };

  /// The demonstration car with more nodes of twelve channels.
  static std::string car_of(int nodes) {
    std::string car = test::read_source("sim/demo/vehicle.toml");
    const std::size_t first = car.find("[[node]]"), second = car.find("[[node]]", first + 1);
    const std::string node = car.substr(first, second - first);
    for (int k = 3; k <= nodes; ++k) {
      const std::string number = std::to_string(k);
      std::string more = node;
      for (const auto& [from, to] :
           std::map<std::string, std::string>{{"\"front\"", "\"node" + number + "\""},
                                              {"id = 1\n", "id = " + number + "\n"},
                                              {"name = \"f", "name = \"n" + number + "f"}})
        for (std::size_t at = more.find(from); at != std::string::npos; at = more.find(from, at + to.size()))
          more.replace(at, from.size(), to);
      car += "\n" + more;
    }
    return car;
  }
  /// By the nodes' clocks, which show one bus time.
  static std::map<std::int32_t, Span> spans(const std::filesystem::path& folder) {
    std::map<std::int32_t, Span> spans;
    RecordReader reader(folder);
    SealedBlock block;
    while (const auto event = reader.next()) {
      if (accept(event->data, block) != Refusal::kNone || block.header.node == 0) continue;
      Span& span = spans[block.header.node];
      const bool is_late = block.kind == BlockKind::kGap && decode_gap(block).cause == GapCause::kStartedLate;
      if (block.kind == BlockKind::kGap) ++(is_late ? span.late : span.other_gaps);
      if ((block.kind == BlockKind::kScan || is_late) && span.begin_ns == 0)
        span.begin_ns = block.header.time_ns;
      if (block.kind == BlockKind::kEnd) span.end_ns = block.header.time_ns;
    }
    return spans;
  }
};

TEST_F(OneStart, IsThatOfFourNodesAndOfManyMore) {
  std::vector<int> sizes{4, 16};
  if (test::full_run()) sizes.push_back(48);
  for (const int size : sizes) {
    write_vehicle("car.toml", car_of(size));
    const std::string start_ns = std::to_string(to_ns(WallClock::now() + MachineClock::slept()));
    // A segment begins with the vehicle file of each of many nodes: small ones would hold nothing else.
    Program recorder("rb-recorder", {"--url", url, "--recordings", recordings.string(), "--vehicle",
                                     (vehicles / "car.toml").string()});
    std::vector<Program> nodes;
    for (int k = 1; k <= size; ++k)
      nodes.emplace_back(
          "rb-node", std::vector<std::string>{
                         "--url", url, "--vehicle", (vehicles / "car.toml").string(), "--node",
                         k == 1   ? "front"
                         : k == 2 ? "rear"
                                  : "node" + std::to_string(k),
                         "--front-end", "sim:?seed=1&rate=1&seconds=10000&start_ns=" + start_ns, "--stay"});
    ASSERT_TRUE(bus.wait([&] { return bus.recorder() && bus.recorder()->nodes == size; })) << size;
    const std::string name = std::to_string(size) + " nodes";
    const Answer answer = ask(Operation::kStart, name);
    ASSERT_EQ(answer.state, AnswerState::kDone) << answer.text;
    EXPECT_EQ(answer.value[0], 0.0) << answer.text;
    bus.listen(2.0);
    ASSERT_EQ(ask(Operation::kStop).state, AnswerState::kDone);
    const auto all = spans(recordings / name);
    ASSERT_EQ(static_cast<int>(all.size()), size);
    std::vector<std::int64_t> begins_ns, ends_ns;
    int late = 0;
    for (const auto& [node, span] : all) {
      begins_ns.push_back(span.begin_ns);
      ends_ns.push_back(span.end_ns);
      EXPECT_EQ(span.other_gaps, 0) << "node " << node << " of " << size;
      late += span.late > 0;
    }
    EXPECT_LE(late, size / 4) << "of " << size << "; one is on a machine that was busy";
    const Verdict expected = late > 0 ? Verdict::kIncomplete : Verdict::kComplete;
    EXPECT_EQ(verify_record(recordings / name).verdict, expected);
    EXPECT_LT(std::ranges::max(begins_ns) - std::ranges::min(begins_ns), 50'000'000) << size;
    EXPECT_LT(std::ranges::max(ends_ns) - std::ranges::min(ends_ns), 50'000'000) << size;
  }
}

}  // namespace
}  // namespace roadbalance
