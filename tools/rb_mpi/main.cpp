// Over a cluster: mpirun -n 2 rb-mpi study fig3 --runs 400, mpirun -n 4 rb-mpi identify drives
#include <mpi.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "common/command_line/manual.hpp"
#include "common/config/section.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/identify_many.hpp"
#include "tools/rb/study.hpp"
#include "tools/rb_mpi/cluster_campaign.hpp"
#include "tools/rb_mpi/cluster_shares.hpp"

namespace {

int run(int argc, char** argv) {
  using namespace roadbalance;
  CLI::App app("roadbalance: studies, and identification from many recordings, over a cluster.", "rb-mpi");
  app.require_subcommand(1);
  int code = kDone, rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  add_study_over(app, code, run_campaign_on_cluster, 1, rank == 0);
  add_identify_over(app, code, share_on_cluster, 1, rank == 0);
  app.footer(
      "Results are those of rb, bit for bit.  Exit codes: 0 done, 1 the answer is no, 2 usage or "
      "configuration, 3 incomplete but every gap declared, 4 cannot read or write.\n"
      "Begun by mpirun, on machines that see the recordings at the same paths:\n"
      "  mpirun -n 8 --hostfile machines rb-mpi identify /srv/drives");
  add_manual(app);
  try {
    app.parse(argc, argv);
    return code;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  } catch (const ConfigError& error) {
    std::fprintf(stderr, "rb-mpi: %s\n", error.what());
    return kUsage;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rb-mpi: %s\n", error.what());
    return kCannotAccess;
  }
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int code = run(argc, argv);
  if (std::fflush(stdout) != 0) code = roadbalance::kCannotAccess;
  MPI_Finalize();
  return code;
}
