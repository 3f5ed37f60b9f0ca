// rb-mpi under mpirun on this machine, as a user starts it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tools/mpi/test/mpirun.hpp"

namespace roadbalance {
namespace {

using test::Output;
using test::output_of;
using test::program;

const std::string kMpirun = test::mpirun(2);
const std::string kStudy = " study fig3 --runs 3 --seed 7 --set samples=5000 --json";

TEST(Cluster, GivesTheSameResultAsOneMachineBitForBit) {
  const Output alone = output_of(program("rb") + kStudy);
  const auto summary = nlohmann::json::parse(alone.text, nullptr, false);
  ASSERT_FALSE(summary.is_discarded()) << alone.text << alone.errors;
  ASSERT_EQ(summary["runs"], 3);
  for (const auto& row : summary["tables"][0]["rows"]) {
    if (row["estimator"] == "chassis") continue;  // gives no unbalance
    EXPECT_EQ(row.value("answers", 3), 3) << row;
  }
  const Output together = output_of(kMpirun + program("rb-mpi") + kStudy);
  EXPECT_EQ(together.text, alone.text) << together.errors;
  EXPECT_EQ(together.status, alone.status) << together.errors;
}

TEST(Cluster, OfMoreProcessesThanRunsStillAnswers) {
  const std::string one_run = " study fig3 --runs 1 --seed 7 --set samples=5000 --json";
  const Output together = output_of(kMpirun + program("rb-mpi") + one_run);
  EXPECT_EQ(together.text, output_of(program("rb") + one_run).text) << together.errors;
}

/// A result that is not shared out is printed once.
TEST(Cluster, SaysWhatHasNoRunsOnce) {
  for (const char* arguments : {" study list", " study fig4 --json"}) {
    const Output together = output_of(kMpirun + program("rb-mpi") + arguments);
    EXPECT_EQ(together.text, output_of(program("rb") + arguments).text) << together.errors;
  }
}

TEST(Cluster, SaysThatAStudyIsNotThere) {
  const Output together = output_of(kMpirun + program("rb-mpi") + " study fig4711");
  EXPECT_EQ(together.status, 2) << together.errors;
}

}  // namespace
}  // namespace roadbalance
