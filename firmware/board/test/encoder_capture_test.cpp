#include "firmware/board/encoder_capture.hpp"

#include "firmware/board/test/check.hpp"
#include "firmware/board/test/simulated_hardware.hpp"

namespace roadbalance::board::test {
namespace {

constexpr std::uint16_t kPulses = 100;

EncoderCapture& capture_with(std::uint16_t flags, SimulatedHardware hardware = {}) {
  static EncoderCapture capture;
  capture.start({{{kPulses, flags}, {kPulses, flags}}}, hardware);
  capture.keep_from_now();
  return capture;
}

// One step of a quadrature encoder: quarter 0 .. 3 of a pitch, A leads B forward.
struct Wheel {
  EncoderCapture& capture;
  int quarter = 0;
  std::uint64_t ticks = 0;
  bool inverted = false;

  void step(int direction) {
    const int before = quarter;
    quarter = (quarter + direction) & 3;
    const bool a = quarter == 1 || quarter == 2;
    const bool b = quarter == 2 || quarter == 3;
    const bool a_before = before == 1 || before == 2;
    ++ticks;
    if (a != a_before)
      capture.line_change(0, Signal::kA, a != inverted, ticks);
    else
      capture.line_change(0, Signal::kB, b != inverted, ticks);
  }
  void steps(int count) {
    for (int k = 0; k < (count < 0 ? -count : count); ++k) step(count < 0 ? -1 : 1);
  }
};

int net_teeth(EncoderCapture& capture) {
  int net = 0;
  for (std::size_t k = 0; k < capture.queue().size(); ++k) {
    const PacketEdgeKind kind = capture.queue()[k].kind;
    net += kind == PacketEdgeKind::kToothForward ? 1 : kind == PacketEdgeKind::kToothBackward ? -1 : 0;
  }
  return net;
}

}  // namespace

BOARD_TEST(capture_without_quadrature_takes_the_active_flank_only) {
  EncoderCapture& capture = capture_with(0);
  CHECK(capture.line_change(0, Signal::kA, true, 10).has_value());
  CHECK(!capture.line_change(0, Signal::kA, false, 20).has_value());
  CHECK(!capture.line_change(0, Signal::kZero, true, 30).has_value());  // not wired
  CHECK(!capture.line_change(2, Signal::kA, true, 40).has_value());     // no such line
  REQUIRE(capture.queue().size() == 1);
  CHECK_EQUAL(capture.queue()[0].ticks, 10);

  EncoderCapture& inverted = capture_with(kInvertA | kInvertZero | kZeroWired);
  CHECK(!inverted.line_change(1, Signal::kA, true, 10).has_value());
  CHECK(inverted.line_change(1, Signal::kA, false, 20).has_value());
  CHECK(inverted.line_change(1, Signal::kZero, false, 30).has_value());
  REQUIRE(inverted.queue().size() == 2);
  CHECK_EQUAL(inverted.queue()[0].line, 1);
  CHECK_EQUAL(inverted.queue()[1].kind, PacketEdgeKind::kZeroMark);
}

BOARD_TEST(capture_with_quadrature_counts_the_way_that_was_gone) {
  EncoderCapture& capture = capture_with(kQuadrature);
  Wheel wheel{capture};
  wheel.steps(4 * 10);
  CHECK_EQUAL(net_teeth(capture), 10);
  wheel.steps(-4 * 13);
  CHECK_EQUAL(net_teeth(capture), -3);
  // Trembling about the flank, and about the far side of the tooth.
  for (int k = 0; k < 20; ++k) wheel.steps(k % 2 == 0 ? 1 : -1);
  CHECK_EQUAL(net_teeth(capture), -3);
  wheel.steps(2);
  for (int k = 0; k < 20; ++k) wheel.steps(k % 2 == 0 ? 1 : -1);
  wheel.steps(-2);
  CHECK_EQUAL(net_teeth(capture), -3);
}

BOARD_TEST(capture_with_b_inverted_counts_the_other_way) {
  SimulatedHardware hardware;
  Wheel wheel{capture_with(kQuadrature | kInvertB, hardware)};
  wheel.steps(4 * 10);
  CHECK_EQUAL(net_teeth(wheel.capture), -10);
}

BOARD_TEST(capture_begins_with_the_levels_the_hardware_has) {
  SimulatedHardware hardware;
  hardware.levels[0][1] = true;  // B is high: A falls as the far side of a tooth
  EncoderCapture& capture = capture_with(kQuadrature, hardware);
  Wheel wheel{capture, 2};
  wheel.steps(4 * 5);
  CHECK_EQUAL(net_teeth(capture), 5);
}

BOARD_TEST(capture_takes_the_zero_mark_at_the_same_place_both_ways) {
  EncoderCapture& capture = capture_with(kQuadrature | kZeroWired);
  Wheel wheel{capture};
  wheel.steps(4);
  CHECK(capture.line_change(0, Signal::kZero, true, 100).has_value());
  CHECK(!capture.line_change(0, Signal::kZero, false, 110).has_value());
  wheel.ticks = 110;
  wheel.steps(-4);
  CHECK(!capture.line_change(0, Signal::kZero, true, 200).has_value());
  CHECK(capture.line_change(0, Signal::kZero, false, 210).has_value());
}

BOARD_TEST(capture_declares_what_a_full_ring_loses) {
  EncoderCapture& capture = capture_with(0);
  std::uint64_t ticks = 0;
  for (std::size_t k = 0; k < EncoderCapture::kEdges + 5; ++k)
    capture.line_change(0, Signal::kA, true, ++ticks);
  CHECK_EQUAL(capture.queue().size(), EncoderCapture::kEdges);
  CHECK_EQUAL(capture.lost(), 5);
  // Room for one: the mark and the edge do not fit both, and the other line has nothing to declare.
  capture.queue().drop(1);
  capture.line_change(0, Signal::kA, true, ++ticks);
  CHECK_EQUAL(capture.lost(), 6);
  capture.line_change(1, Signal::kA, true, ++ticks);
  CHECK_EQUAL(capture.lost(), 6);
  capture.queue().drop(3);
  capture.line_change(0, Signal::kA, true, ++ticks);
  CHECK_EQUAL(capture.lost(), 6);
  const std::size_t size = capture.queue().size();
  CHECK_EQUAL(capture.queue()[size - 2].kind, PacketEdgeKind::kLost);
  CHECK_EQUAL(capture.queue()[size - 2].lost, 6);
  CHECK_EQUAL(capture.queue()[size - 2].line, 0);
  CHECK_EQUAL(capture.queue()[size - 1].kind, PacketEdgeKind::kToothForward);
}

BOARD_TEST(capture_declares_an_edge_that_comes_late_as_lost) {
  EncoderCapture& capture = capture_with(0);
  capture.line_change(0, Signal::kA, true, 100);
  capture.pass(200);
  capture.line_change(0, Signal::kA, true, 200);  // behind the conversion that it should precede
  CHECK_EQUAL(capture.lost(), 1);
  capture.line_change(1, Signal::kA, true, 250);
  capture.line_change(0, Signal::kA, true, 240);  // behind a later edge
  CHECK_EQUAL(capture.lost(), 2);
  capture.line_change(0, Signal::kA, true, 300);
  REQUIRE(capture.queue().size() == 4);
  CHECK_EQUAL(capture.queue()[2].kind, PacketEdgeKind::kLost);
  CHECK_EQUAL(capture.queue()[2].lost, 2);
}

}  // namespace roadbalance::board::test
