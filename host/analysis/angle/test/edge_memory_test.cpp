#include "host/analysis/angle/edge_memory.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace roadbalance {
namespace {

TEST(EdgeMemory, RefusesWithFiguresWhatDoesNotFit) {
  EdgeMemory memory(2e9);
  memory.add(19'000'000);
  EXPECT_NO_THROW(memory.add(1'000'000));
  try {
    memory.add(1);
    ADD_FAILURE() << "that is more than 2 GB";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("20000001 need 2.00 GB of memory, and 2.00 GB are free"),
              std::string::npos)
        << error.what();
  }
}

TEST(EdgeMemory, KnowsWhatTheMachineHas) {
  EXPECT_GT(available_memory(), 1e6);
  EXPECT_LT(available_memory(), 1e15);
}

}  // namespace
}  // namespace roadbalance
