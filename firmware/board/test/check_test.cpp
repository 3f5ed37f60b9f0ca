#include "firmware/board/test/check.hpp"

namespace {

int reached = 0;

void broken_checks() {
  CHECK(1 + 1 == 3);
  CHECK_EQUAL(1 + 1, 3);
  CHECK_NEAR(1.0, 1.2, 0.1);
  CHECK_NEAR(0.0 / static_cast<double>(reached), 0.0, 1.0);  // not a number is near to nothing
}

void broken_requirement() {
  REQUIRE(1 + 1 == 3);
  ++reached;
}

}  // namespace

BOARD_TEST(check_counts_what_does_not_hold) {
  using roadbalance::board::test::failures_of;
  reached = 0;
  CHECK_EQUAL(failures_of(broken_checks), 4);
  CHECK_EQUAL(failures_of(broken_requirement), 1);
  CHECK_EQUAL(reached, 0);
}
