#include "firmware/clock_answer.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "common/clock/test/kernel_stamps.hpp"
#include "common/process/parallel.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr std::uint32_t kLoopback = 0x7F000001;
constexpr milliseconds kPatience{60'000};  // for slow machines

/// Its clock shows 1000 s more than the machine's.
class Elsewhere final : public FrontEnd {
 public:
  Read read(std::span<Scan>, std::span<Edge>, std::span<SignalSample>) noexcept override { return {}; }
  NodeTime node_time(MachineTime machine) const noexcept override {
    return node_time_from_ns(to_ns(machine) + 1'000'000'000'000);
  }
};

class ClockAnswer : public testing::Test {
 protected:
  ClockAnswer() : host_(kLoopback) {
    EXPECT_EQ(node_.follow(), "");
    process_.run(answer_clock, std::ref(node_), 3, 77, std::cref(front_end_),
                 [](const std::string& why) { ADD_FAILURE() << why; });
  }
  ~ClockAnswer() override { process_.request_stop(); }

  void send(std::span<const std::uint8_t> bytes) { ASSERT_TRUE(host_.send(node_.address(), bytes)); }
  void ask(std::int32_t node, std::int64_t epoch, std::int64_t number) {
    send(encode(ClockDatagram{.node = node, .epoch = epoch, .number = number}));
  }
  std::optional<ClockDatagram> hear() {
    const auto got = host_.receive(kPatience);
    return got ? decode_clock_datagram(got->bytes()) : std::nullopt;
  }

  Elsewhere front_end_;
  ClockPlace node_{[] { return kLoopback; }};
  ClockSocket host_;
  Parallel process_;
};

TEST_F(ClockAnswer, AnswersInTheNodesClockWithTheKernelsStamps) {
  ASSERT_NO_FATAL_FAILURE(await_kernel_stamps());
  const std::int64_t begin_ns = to_ns(MachineClock::now());
  ask(3, 77, 5);
  const auto answer = hear();
  const auto follow_up = hear();
  const std::int64_t end_ns = to_ns(MachineClock::now());
  ASSERT_TRUE(answer && follow_up);
  EXPECT_EQ(answer->kind, ClockDatagramKind::kAnswer);
  EXPECT_EQ(follow_up->kind, ClockDatagramKind::kFollowUp);
  EXPECT_TRUE(answer->received_by_kernel);
  EXPECT_TRUE(follow_up->answered_by_kernel);
  for (const auto& datagram : {*answer, *follow_up}) {
    EXPECT_EQ(datagram.number, 5);
    EXPECT_EQ(datagram.epoch, 77);
    constexpr std::int64_t kReading_ns = 25'000, kAhead_ns = 1'000'000'000'000;
    EXPECT_GE(datagram.received_ns, begin_ns + kAhead_ns - kReading_ns);
    EXPECT_GE(datagram.answered_ns, datagram.received_ns - kReading_ns);
    EXPECT_LE(datagram.answered_ns, end_ns + kAhead_ns + kReading_ns);
  }
}

TEST_F(ClockAnswer, IsSilentToWhatIsNoQuestionOfIts) {
  ask(4, 77, 1);
  ask(3, 78, 2);
  send(std::vector<std::uint8_t>(48, 0x52));
  send(encode(ClockDatagram{.kind = ClockDatagramKind::kAnswer, .node = 3, .epoch = 77, .number = 3}));
  ask(3, 77, 9);
  const auto answer = hear();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->number, 9);
}

TEST_F(ClockAnswer, AFloodGetsNoMoreThanItsAllowance) {
  const MachineTime begin = MachineClock::now();
  for (int i = 0; i < kMostAnswers + 200; ++i) ask(3, 77, i);
  int answers = 0;
  while (const auto got = host_.receive(answers == 0 ? kPatience : milliseconds(100)))
    if (const auto d = decode_clock_datagram(got->bytes()))
      answers += d->kind == ClockDatagramKind::kAnswer ? 1 : 0;
  // The questions may fall into one second more than have passed: two, unless the machine is slow.
  const auto passed = std::chrono::floor<std::chrono::seconds>(MachineClock::now() - begin).count();
  EXPECT_LE(answers, (2 + passed) * kMostAnswers);
  EXPECT_GT(answers, 0);
}

}  // namespace
}  // namespace roadbalance
