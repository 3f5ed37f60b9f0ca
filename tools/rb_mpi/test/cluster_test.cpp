// rb-mpi under mpirun on this machine, as a user starts it.
#include <gtest/gtest.h>

#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

namespace roadbalance {
namespace {

struct Output {
  std::string text, errors;
  int status;
};

Output output_of(const std::string& command) {
  Output output;
  const std::filesystem::path errors =
      std::filesystem::temp_directory_path() / ("cluster-test-" + std::to_string(getpid()));
  std::FILE* pipe = popen((command + " 2>" + errors.string()).c_str(), "r");
  std::array<char, 4096> part{};
  while (const std::size_t n = std::fread(part.data(), 1, part.size(), pipe))
    output.text.append(part.data(), n);
  output.status = WEXITSTATUS(pclose(pipe));
  std::ifstream file(errors);
  output.errors.assign(std::istreambuf_iterator<char>(file), {});
  std::filesystem::remove(errors);
  return output;
}

/// As root and on a machine of one core, too, with Open MPI 4 and 5; others do not know the variables.
const std::string kMpirun =
    "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 "
    "PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe mpirun -n 2 ";
const std::string kStudy = " study fig3 --runs 3 --seed 7 --set samples=5000 --json";

std::string program(const char* name) {
  return std::string(std::getenv("RB_BIN")) + "/" + name;
}

TEST(Cluster, GivesTheSameResultAsOneMachineBitForBit) {
  const Output alone = output_of(program("rb") + kStudy);
  const auto summary = nlohmann::json::parse(alone.text, nullptr, false);
  ASSERT_FALSE(summary.is_discarded()) << alone.text << alone.errors;
  ASSERT_EQ(summary["runs"], 3);
  for (const auto& row : summary["tables"][0]["rows"]) {
    if (row["estimator"] == "chassis") continue;  // tells no unbalance
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

/// What is not shared out is said once.
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
