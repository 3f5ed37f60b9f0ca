#include "firmware/board/byte_order.hpp"
#include "firmware/board/protocol.hpp"
#include "firmware/board/test/check.hpp"

namespace roadbalance::board::test {
namespace {

// 1, 2, 3, ...: every field gets a value of its own, and a second encoding must give the same bytes.
template <std::size_t kBytes>
std::array<std::uint8_t, kBytes> counted() {
  std::array<std::uint8_t, kBytes> bytes{};
  for (std::size_t k = 0; k < kBytes; ++k) bytes[k] = static_cast<std::uint8_t>(k + 1);
  return bytes;
}

template <std::size_t kBytes, class Decode>
void check_exact_length(std::array<std::uint8_t, kBytes> bytes, Decode decode) {
  std::array<std::uint8_t, kBytes + 1> longer{};
  for (std::size_t k = 0; k < kBytes; ++k) longer[k] = bytes[k];
  for (std::size_t size = 0; size <= longer.size(); ++size)
    CHECK_EQUAL(decode(std::span<const std::uint8_t>(longer).first(size)).has_value(), size == kBytes);
}

}  // namespace

BOARD_TEST(requests_encode_what_they_decoded) {
  const auto configuration = decode_configuration(counted<Configuration::kBytes>());
  REQUIRE(configuration.has_value());
  CHECK(encode(*configuration) == counted<Configuration::kBytes>());
  CHECK_EQUAL(configuration->ticks_per_scan, 0x04030201);
  CHECK_EQUAL(configuration->encoder[1].flags, 0x201F);

  const auto references = decode_reference_setup(counted<ReferenceSetup::kBytes>());
  REQUIRE(references.has_value());
  CHECK(encode(*references) == counted<ReferenceSetup::kBytes>());
  CHECK_EQUAL(references->wheel[1].datum, 0x18171615);

  const auto identity = decode_identity(counted<Identity::kBytes>());
  REQUIRE(identity.has_value());
  CHECK(encode(*identity) == counted<Identity::kBytes>());
  CHECK_EQUAL(identity->tick_hz, 0x24232221);

  const Status status{State::kRunning, Refusal::kWrongToken, 6, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
  const auto back = decode_status(encode(status));
  REQUIRE(back.has_value());
  CHECK(encode(*back) == encode(status));
  CHECK_EQUAL(back->ticks, 11);
}

BOARD_TEST(requests_of_the_host_are_read_at_their_length_only) {
  check_exact_length(encode(Configuration{}), decode_configuration);
  check_exact_length(encode(ReferenceSetup{}), decode_reference_setup);
  check_exact_length(encode(TestPattern{}), decode_test_pattern);
  check_exact_length(encode(Arm{}), decode_arm);
  check_exact_length(encode(Start{}), decode_start);
}

BOARD_TEST(requests_with_an_unknown_enumerator_are_refused) {
  CHECK(!decode_test_pattern(std::array<std::uint8_t, 4>{2, 0, 0, 0}));
  CHECK(!decode_test_pattern(std::array<std::uint8_t, 4>{1, 0, 0, 1}));
  CHECK(!decode_arm(std::array<std::uint8_t, 8>{0, 0, 0, 0, 3, 0, 0, 0}));
  CHECK(!decode_arm(std::array<std::uint8_t, 8>{0, 0, 0, 0, 0, 1, 0, 0}));
  auto status = encode(Status{});
  status[0] = 4;
  CHECK(!decode_status(status));
}

BOARD_TEST(answers_of_a_newer_minor_version_are_read) {
  std::array<std::uint8_t, Identity::kBytes + 4> longer{};
  Identity newer;
  newer.minor = kProtocolMinor + 1;
  newer.tick_hz = 7;
  const auto known = encode(newer);
  for (std::size_t k = 0; k < known.size(); ++k) longer[k] = known[k];
  const auto read = decode_identity(longer);
  REQUIRE(read.has_value());
  CHECK_EQUAL(read->minor, kProtocolMinor + 1);
  CHECK_EQUAL(read->tick_hz, 7);
  CHECK(!decode_identity(std::span(longer).first(Identity::kBytes - 1)));
}

BOARD_TEST(identity_of_another_major_version_can_be_named) {
  Identity other;
  other.major = 9;
  const auto read = decode_identity(encode(other));
  REQUIRE(read.has_value());
  CHECK_EQUAL(read->major, 9);
}

}  // namespace roadbalance::board::test
