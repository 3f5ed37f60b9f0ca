// rb-mpi under mpirun on this machine, as a user starts it.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

namespace roadbalance {
namespace {

struct Output {
  std::string text;
  int status;
};

Output output_of(const std::string& command) {
  Output output;
  std::FILE* pipe = popen((command + " 2>/dev/null").c_str(), "r");
  std::array<char, 4096> part{};
  while (const std::size_t n = std::fread(part.data(), 1, part.size(), pipe))
    output.text.append(part.data(), n);
  output.status = WEXITSTATUS(pclose(pipe));
  return output;
}

const std::string kMpirun = "mpirun --allow-run-as-root --oversubscribe -n 2 ";
const std::string kStudy = " study fig3 --runs 3 --seed 7 --set samples=1000 --json";

std::string program(const char* name) {
  return std::string(std::getenv("RB_BIN")) + "/" + name;
}

TEST(Cluster, GivesTheSameResultAsOneMachineBitForBit) {
  const Output alone = output_of(program("rb") + kStudy);
  ASSERT_EQ(nlohmann::json::parse(alone.text)["runs"], 3);
  const Output together = output_of(kMpirun + program("rb-mpi") + kStudy);
  EXPECT_EQ(together.text, alone.text);
  EXPECT_EQ(together.status, alone.status);
}

TEST(Cluster, OfMoreProcessesThanRunsStillAnswers) {
  const std::string one_run = " study fig3 --runs 1 --seed 7 --set samples=1000 --json";
  EXPECT_EQ(output_of(kMpirun + program("rb-mpi") + one_run).text, output_of(program("rb") + one_run).text);
}

TEST(Cluster, SaysThatAStudyIsNotThere) {
  EXPECT_EQ(output_of(kMpirun + program("rb-mpi") + " study fig4711").status, 2);
}

}  // namespace
}  // namespace roadbalance
