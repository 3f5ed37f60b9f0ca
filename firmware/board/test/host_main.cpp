#include <cstdio>

#include "firmware/board/test/check.hpp"

namespace roadbalance::board::test {

void print(const char* text) {
  std::fputs(text, stdout);
}

}  // namespace roadbalance::board::test

int main() {
  return roadbalance::board::test::run_all() == 0 ? 0 : 1;
}
