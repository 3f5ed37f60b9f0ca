#include "tools/mpi/cluster_campaign.hpp"

#include <mpi.h>

#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

/// The texts of all processes in order of rank, in the first process; elsewhere nothing.
std::vector<std::string> gather(const std::string& text, int rank, int processes) {
  const int size = static_cast<int>(text.size());
  std::vector<int> sizes(static_cast<std::size_t>(processes)), begins(sizes.size());
  MPI_Gather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, 0, MPI_COMM_WORLD);
  std::string all;
  if (rank == 0) {
    int sum = 0;
    for (std::size_t i = 0; i < sizes.size(); sum += sizes[i], ++i) begins[i] = sum;
    all.resize(static_cast<std::size_t>(sum));
  }
  MPI_Gatherv(text.data(), size, MPI_CHAR, all.data(), sizes.data(), begins.data(), MPI_CHAR, 0,
              MPI_COMM_WORLD);
  std::vector<std::string> texts;
  for (std::size_t i = 0; rank == 0 && i < sizes.size(); ++i)
    texts.push_back(all.substr(static_cast<std::size_t>(begins[i]), static_cast<std::size_t>(sizes[i])));
  return texts;
}

}  // namespace

std::optional<std::vector<Json>> run_campaign_on_cluster(const Campaign& campaign,
                                                         const Experiment& experiment) {
  int rank = 0, processes = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &processes);
  std::vector<std::uint64_t> mine;
  for (int i = rank; i < campaign.runs; i += processes)
    mine.push_back(campaign.first_seed + static_cast<std::uint64_t>(i));

  std::exception_ptr failure;
  Json results = Json::array();
  try {
    Campaign share = campaign;
    share.in_process = campaign.jobs == 1;  // what MPI has opened does not like a fork
    results = run_seeds(share, mine, experiment);
  } catch (...) {
    failure = std::current_exception();
  }
  const int failed = failure ? 1 : 0;
  int anywhere = 0;
  MPI_Allreduce(&failed, &anywhere, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  if (failure) std::rethrow_exception(failure);
  if (anywhere != 0) throw std::runtime_error(campaign.name + ": a run failed in another process");

  const std::vector<std::string> texts = gather(results.dump(), rank, processes);
  if (rank != 0) return std::nullopt;
  std::vector<Json> of_rank;
  for (const std::string& text : texts) of_rank.push_back(Json::parse(text));
  std::vector<Json> all;
  for (int i = 0; i < campaign.runs; ++i)
    all.push_back(of_rank[static_cast<std::size_t>(i % processes)][static_cast<std::size_t>(i / processes)]);
  return all;
}

}  // namespace roadbalance
