// Over a cluster: mpirun -n 2 rb-mpi study fig3 --runs 400, mpirun -n 4 rb-mpi identify drives
#include <mpi.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "common/command_line/exit_code.hpp"
#include "common/command_line/manual.hpp"
#include "common/command_line/run_program.hpp"
#include "tools/mpi/cluster_campaign.hpp"
#include "tools/mpi/cluster_shares.hpp"
#include "tools/rb/identify.hpp"
#include "tools/study/identify_with.hpp"
#include "tools/study/study_command.hpp"

namespace {

int run(int argc, char** argv) {
  using namespace roadbalance;
  CLI::App app("roadbalance: studies, and identification from many recordings, over a cluster.", "rb-mpi");
  app.require_subcommand(1);
  int code = kDone, rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  add_study(*app.add_subcommand("study", kStudySentence), code, run_campaign_on_cluster, 1, rank == 0);
  add_identify_over(app, code,
                    {.sharer = share_on_cluster, .estimate = identify_with, .jobs = 1, .speaks = rank == 0});
  app.footer(
      "Results are those of rb, bit for bit.  Exit codes: 0 done, 1 the answer is no, 2 usage or "
      "configuration, 3 incomplete but every gap declared, 4 cannot read or write.\n"
      "Begun by mpirun, on machines that see the recordings at the same paths:\n"
      "  mpirun -n 8 --hostfile machines rb-mpi identify /srv/drives");
  add_version(app);
  add_manual(app);
  return run_program(app, {argv + 1, argv + argc}, code);
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  const int code = run(argc, argv);
  MPI_Finalize();
  return code;
}
