#include "firmware/board/arm/program.hpp"
#include "firmware/board/test/check.hpp"

int roadbalance::board::arm::program() {
  return roadbalance::board::test::run_all() == 0 ? 0 : 1;
}
