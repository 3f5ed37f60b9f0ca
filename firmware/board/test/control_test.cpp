#include "firmware/board/control.hpp"

#include <algorithm>

#include "firmware/board/test/check.hpp"
#include "firmware/board/test/rig.hpp"

namespace roadbalance::board::test {
namespace {

// Everything a host can see of the board's state, but for Status's count of refusals and the time.
struct Seen {
  std::array<std::uint8_t, Status::kBytes> status{};
  std::array<std::uint8_t, Configuration::kBytes> configuration{};
  bool operator==(const Seen&) const = default;
};

Seen seen(Rig& rig) {
  Seen seen;
  Status status = rig.status();
  status.last_refusal = Refusal::kNone;
  status.refused_request = 0;
  status.refusals = 0;
  seen.status = encode(status);
  const SetupPacket setup{kVendorIn, static_cast<std::uint8_t>(Request::kConfiguration), 0, 0, 64};
  (void)rig.board.control_request(setup, {}, seen.configuration);
  return seen;
}

void check_refused(Rig& rig, Request request, std::span<const std::uint8_t> bytes, Refusal reason) {
  const Seen before = seen(rig);
  const std::uint32_t refusals = rig.status().refusals;
  CHECK(!rig.send(request, bytes));
  const Status status = rig.status();
  CHECK_EQUAL(status.last_refusal, reason);
  CHECK_EQUAL(status.refused_request, request);
  CHECK_EQUAL(status.refusals, refusals + 1);
  CHECK(seen(rig) == before);
}

Configuration with_everything() {
  Configuration all = test_configuration();
  all.filter_order = 5;
  all.filter_corner_hz = 200;
  all.references_on = 1;
  all.range.fill(3);
  all.encoder = {{{96, kZeroWired}, {1000, kEncoderFlags}}};
  return all;
}

template <class Change>
std::array<std::uint8_t, Configuration::kBytes> changed(Change change) {
  Configuration configuration = with_everything();
  change(configuration);
  return encode(configuration);
}

}  // namespace

BOARD_TEST(control_identifies_itself_cut_to_the_length_asked_for) {
  Rig& rig = Rig::fresh();
  std::array<std::uint8_t, Identity::kBytes + 8> reply{};
  for (const std::size_t length : {std::size_t{4}, Identity::kBytes, std::size_t{255}}) {
    const SetupPacket setup{kVendorIn, 1, 0, 0, static_cast<std::uint16_t>(length)};
    const auto size = rig.board.control_request(setup, {}, reply);
    CHECK(size == std::min(length, Identity::kBytes));
  }
  const auto identity = decode_identity(reply);
  REQUIRE(identity.has_value());
  CHECK(encode(*identity) == encode(test_identity()));
}

BOARD_TEST(control_configures_the_hardware_and_says_what_is_in_force) {
  Rig& rig = Rig::fresh();
  CHECK(rig.send(Request::kConfigure, encode(with_everything())));
  CHECK(encode(rig.hardware.configuration) == encode(with_everything()));
  CHECK(seen(rig).configuration == encode(with_everything()));
  CHECK_EQUAL(rig.status().configured, 1);
}

BOARD_TEST(control_refuses_values_that_the_board_does_not_have) {
  Rig& rig = Rig::fresh();
  CHECK(rig.send(Request::kConfigure, encode(with_everything())));
  using C = Configuration;
  for (const auto& bytes : {
           changed([](C& c) { c.ticks_per_scan = 0; }),
           changed([](C& c) { c.ticks_per_scan = 4'999; }),      // 20 kHz is the fastest
           changed([](C& c) { c.ticks_per_scan = 1'000'001; }),  // 100 Hz the slowest
           changed([](C& c) { c.packet_limit_us = kPacketLimitMinUs - 1; }),
           changed([](C& c) { c.packet_limit_us = kPacketLimitMaxUs + 1; }),
           changed([](C& c) { c.filter_order = 3; }),
           changed([](C& c) { c.filter_order = 255; }),
           changed([](C& c) { c.filter_order = 0; }),  // but with a corner
           changed([](C& c) { c.filter_corner_hz = 49; }),
           changed([](C& c) { c.filter_corner_hz = 5'001; }),
           changed([](C& c) { c.references_on = 2; }),
           changed([](C& c) { c.range[11] = kRanges; }),
           changed([](C& c) { c.encoder[1].pulses_per_turn = 3; }),
           changed([](C& c) { c.encoder[1].flags = kEncoderFlags + 1; }),
           changed([](C& c) {
             c.encoder[0] = {0, kQuadrature};
           }),
       })
    check_refused(rig, Request::kConfigure, bytes, Refusal::kOutOfRange);

  ReferenceSetup setup;
  setup.wheel[0].on = 1;
  CHECK(rig.send(Request::kReferences, encode(setup)));
  for (int k = 0; k < 6; ++k) {
    ReferenceSetup wrong = setup;
    if (k == 0) wrong.wheel[1].on = 2;
    if (k == 1) wrong.wheel[1].line = kLines;
    if (k == 2) wrong.wheel[0].amplitude_per_mille = 1001;
    if (k == 3) wrong.wheel[0].amplitude_per_mille = 0;
    if (k == 4) wrong.wheel[0].corner_mhz = 99;
    if (k == 5) wrong.wheel[0].corner_mhz = 200'001;
    check_refused(rig, Request::kReferences, encode(wrong), Refusal::kOutOfRange);
  }
}

BOARD_TEST(control_refuses_when_the_hardware_does) {
  Rig& rig = Rig::fresh();
  CHECK(rig.send(Request::kConfigure, encode(test_configuration())));
  rig.hardware.refuses = true;
  check_refused(rig, Request::kConfigure, encode(with_everything()), Refusal::kHardware);
}

BOARD_TEST(control_refuses_what_the_state_does_not_allow) {
  Rig& rig = Rig::fresh();
  const auto arm = encode(Arm{7, StartMode::kImmediate});
  const auto follow = encode(Arm{7, StartMode::kFollower});
  const auto start = encode(Start{7});
  check_refused(rig, Request::kArm, arm, Refusal::kWrongState);  // no configuration
  check_refused(rig, Request::kStart, start, Refusal::kWrongState);
  CHECK(rig.send(Request::kConfigure, encode(test_configuration())));
  CHECK(rig.send(Request::kArm, arm));
  check_refused(rig, Request::kArm, arm, Refusal::kWrongState);
  check_refused(rig, Request::kConfigure, encode(test_configuration()), Refusal::kWrongState);
  check_refused(rig, Request::kStart, encode(Start{8}), Refusal::kWrongToken);
  CHECK(!rig.hardware.running.has_value());
  CHECK(rig.send(Request::kStart, start));
  CHECK(rig.hardware.running == StartMode::kImmediate);
  check_refused(rig, Request::kStart, start, Refusal::kWrongState);
  check_refused(rig, Request::kTestPattern, encode(TestPattern{}), Refusal::kWrongState);
  check_refused(rig, Request::kReferences, encode(ReferenceSetup{}), Refusal::kWrongState);
  CHECK(rig.stop());
  CHECK(!rig.hardware.running.has_value());
  CHECK(rig.send(Request::kArm, follow));
  CHECK(rig.hardware.running == StartMode::kFollower);
  check_refused(rig, Request::kStart, start, Refusal::kWrongState);  // SYNC starts it
}

BOARD_TEST(control_refuses_a_reference_without_its_encoder) {
  Rig& rig = Rig::fresh();
  ReferenceSetup setup;
  setup.wheel[1] = {.on = 1, .line = 1};
  Configuration configuration = with_everything();
  configuration.encoder[1] = {};
  CHECK(rig.send(Request::kReferences, encode(setup)));
  CHECK(rig.send(Request::kConfigure, encode(configuration)));
  check_refused(rig, Request::kArm, encode(Arm{}), Refusal::kOutOfRange);
  configuration.references_on = 0;
  CHECK(rig.send(Request::kConfigure, encode(configuration)));
  CHECK(rig.send(Request::kArm, encode(Arm{})));
}

// Requests of every number, both directions and many lengths with seeded noise: one that is none is stalled
// and changes nothing.
BOARD_TEST(control_refuses_garbage_and_stays_as_it_was) {
  Rig& rig = Rig::fresh();
  CHECK(rig.begin(with_everything()));
  const Seen before = seen(rig);
  std::uint32_t noise = 1;
  std::array<std::uint8_t, 96> data{};
  std::array<std::uint8_t, 96> reply{};
  std::uint32_t refused = 0;
  for (int k = 0; k < 20'000; ++k) {
    for (std::uint8_t& byte : data)
      byte = static_cast<std::uint8_t>((noise = noise * 1664525 + 1013904223) >> 24);
    SetupPacket setup{data[0], data[1], data[2], data[3], data[4]};
    if (data[5] % 2 == 0) setup = {data[0] % 2 == 0 ? kVendorIn : kVendorOut, data[1], 0, 0, data[4]};
    if (data[6] % 2 == 0) setup.request = static_cast<std::uint8_t>(setup.request % 12);
    const bool out = setup.request_type == kVendorOut;
    const bool whole = setup.value == 0 && setup.index == 0;
    if (out && setup.request == static_cast<std::uint8_t>(Request::kStop) && whole) continue;
    const std::size_t size = std::min<std::size_t>(setup.length, data.size());
    const bool done =
        rig.board.control_request(setup, std::span(data).first(out ? size : 0), reply).has_value();
    refused += done ? 0 : 1;
    if (done) CHECK(setup.request_type == kVendorIn && whole);
  }
  CHECK(refused > 10'000);
  CHECK_EQUAL(rig.status().refusals, refused);
  CHECK(seen(rig) == before);
}

BOARD_TEST(control_refuses_data_of_another_length_than_announced) {
  Rig& rig = Rig::fresh();
  const auto bytes = encode(test_configuration());
  const SetupPacket setup{kVendorOut, static_cast<std::uint8_t>(Request::kConfigure), 0, 0, bytes.size() + 1};
  CHECK(!rig.board.control_request(setup, bytes, {}).has_value());
  CHECK_EQUAL(rig.status().last_refusal, Refusal::kWrongLength);
}

BOARD_TEST(control_forgets_all_at_a_reset) {
  Rig& rig = Rig::fresh();
  CHECK(rig.begin(with_everything()));
  rig.board.reset();
  CHECK(!rig.hardware.running.has_value());
  CHECK_EQUAL(rig.status().state, State::kIdle);
  CHECK_EQUAL(rig.status().configured, 0);
  CHECK_EQUAL(rig.status().token, 0);
  check_refused(rig, Request::kArm, encode(Arm{}), Refusal::kWrongState);

  // A reference that was still on would lack its encoder, a pattern would be flagged.
  ReferenceSetup setup;
  setup.wheel[0] = {.on = 1, .line = 0};
  CHECK(rig.send(Request::kReferences, encode(setup)));
  CHECK(rig.send(Request::kTestPattern, encode(TestPattern{Pattern::kCounter})));
  rig.board.reset();
  Configuration without_encoder = test_configuration();
  without_encoder.references_on = 1;
  REQUIRE(rig.begin(without_encoder));
  rig.hardware.now = kTickHz;
  const auto packet = rig.packet();
  REQUIRE(packet.has_value());
  CHECK_EQUAL(packet->header().flags, 0);
}

}  // namespace roadbalance::board::test
