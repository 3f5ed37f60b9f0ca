#include "tools/study/campaign.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "common/types/crc32c.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

/// Distinguishes builds: results of another build are not results of this one.
std::uint32_t build_mark() {
  std::ifstream file("/proc/self/exe", std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  return crc32c({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

class ResultFiles {
 public:
  explicit ResultFiles(const Campaign& campaign)
      : folder_(campaign.state), name_(campaign.name), settings_(campaign.settings) {
    settings_["build"] = build_mark();
    std::filesystem::create_directories(folder_);
  }

  std::optional<Json> read(std::uint64_t seed) const {
    std::ifstream file(path(seed));
    if (!file) return std::nullopt;
    const Json whole = Json::parse(file, nullptr, false);
    if (whole.is_discarded() || whole.value("settings", Json()) != settings_ || !whole.contains("result"))
      return std::nullopt;
    return whole["result"];
  }

  /// Complete or not at all.
  void write(std::uint64_t seed, const Json& result) const {
    const std::filesystem::path draft = path(seed).string() + ".new";
    std::ofstream file(draft);
    file << Json{{"settings", settings_}, {"seed", seed}, {"result", result}}.dump(1) << '\n';
    if (!file.flush()) throw std::system_error(errno, std::generic_category(), "write " + draft.string());
    file.close();
    std::filesystem::rename(draft, path(seed));
  }

 private:
  std::filesystem::path path(std::uint64_t seed) const {
    return folder_ / (name_ + "-" + std::to_string(seed) + ".json");
  }

  std::filesystem::path folder_;
  std::string name_;
  Json settings_;
};

pid_t start_run(const ResultFiles& files, const Experiment& experiment, std::uint64_t seed) {
  std::fflush(nullptr);  // or the child would print it again
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (pid > 0) return pid;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(EXIT_FAILURE);
  try {
    files.write(seed, experiment(seed));
    _exit(EXIT_SUCCESS);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "seed %llu: %s\n", static_cast<unsigned long long>(seed), error.what());
    _exit(EXIT_FAILURE);
  }
}

}  // namespace

std::vector<Json> run_campaign(const Campaign& campaign, const Experiment& experiment) {
  std::vector<std::uint64_t> seeds;
  for (int i = 0; i < campaign.runs; ++i)
    seeds.push_back(campaign.first_seed + static_cast<std::uint64_t>(i));
  return run_seeds(campaign, seeds, experiment);
}

std::vector<Json> run_seeds(const Campaign& campaign, const std::vector<std::uint64_t>& seeds,
                            const Experiment& experiment) {
  const ResultFiles files(campaign);
  std::vector<std::uint64_t> to_do;
  for (const std::uint64_t seed : seeds)
    if (!files.read(seed)) to_do.push_back(seed);
  std::size_t done = seeds.size() - to_do.size();
  if (done > 0) std::fprintf(stderr, "%zu of %zu runs were done before\n", done, seeds.size());

  for (; campaign.in_process && !to_do.empty(); to_do.erase(to_do.begin())) {
    const std::uint64_t seed = to_do.front();
    try {
      files.write(seed, experiment(seed));
    } catch (const std::exception& error) {
      throw std::runtime_error(campaign.name + ": the run with seed " + std::to_string(seed) +
                               " failed: " + error.what());
    }
    std::fprintf(stderr, "%zu of %zu runs done\n", ++done, seeds.size());
  }

  std::map<pid_t, std::uint64_t> running;
  std::optional<std::uint64_t> failed;
  const auto begin = std::chrono::steady_clock::now();
  std::size_t next = 0;
  while (!running.empty() || (next < to_do.size() && !failed)) {
    while (!failed && next < to_do.size() && std::ssize(running) < campaign.jobs)
      running.emplace(start_run(files, experiment, to_do[next]), to_do[next]), ++next;
    int status = 0;
    const auto ended = running.find(waitpid(-1, &status, 0));
    if (ended == running.end()) continue;
    if (!WIFEXITED(status) || WEXITSTATUS(status) != EXIT_SUCCESS) failed = ended->second;
    running.erase(ended);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (!failed) std::fprintf(stderr, "%zu of %zu runs done, %.0f s\n", ++done, seeds.size(), seconds);
  }
  if (failed)
    throw std::runtime_error(campaign.name + ": the run with seed " + std::to_string(*failed) + " failed");

  std::vector<Json> results;
  for (const std::uint64_t seed : seeds) results.push_back(files.read(seed).value());
  return results;
}

}  // namespace roadbalance
