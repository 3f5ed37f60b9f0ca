#include "tools/mpi/cluster_shares.hpp"

#include <mpi.h>

#include <exception>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/process/in_order.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

/// MPI counts in int.
constexpr std::size_t kMostBytes = std::size_t{1} << 30;
enum Tag : int { kShare = 1, kAnswer = 2 };
enum Answer : int { kGoOn = 0, kEnough = 1 };

struct World {
  int rank = 0, processes = 1;
  World() {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &processes);
  }
};

/// The first process's list, in all.
std::vector<fs::path> announce(const std::vector<fs::path>& recordings) {
  std::string text;
  for (const fs::path& recording : recordings) text += recording.string() + '\0';
  auto size = static_cast<unsigned long long>(text.size());
  MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG_LONG, 0, MPI_COMM_WORLD);
  text.resize(size);
  MPI_Bcast(text.data(), static_cast<int>(size), MPI_CHAR, 0, MPI_COMM_WORLD);
  std::vector<fs::path> all;
  for (std::size_t at = 0; at < text.size(); at += all.back().string().size() + 1)
    all.emplace_back(text.c_str() + at);
  return all;
}

/// Those of one process.
std::vector<std::size_t> dealt_to(int rank, int processes, std::size_t recordings) {
  std::vector<std::size_t> which;
  for (auto i = static_cast<std::size_t>(rank); i < recordings; i += static_cast<std::size_t>(processes))
    which.push_back(i);
  return which;
}

/// Nothing: the process that made it could not.
std::optional<DriveShare> receive(int from) {
  MPI_Status status;
  MPI_Probe(from, kShare, MPI_COMM_WORLD, &status);
  int size = 0;
  MPI_Get_count(&status, MPI_CHAR, &size);
  std::vector<char> bytes(static_cast<std::size_t>(size));
  MPI_Recv(bytes.data(), size, MPI_CHAR, from, kShare, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return decode_drive_share(bytes);
}

void answer(int to, int what) {
  MPI_Send(&what, 1, MPI_INT, to, kAnswer, MPI_COMM_WORLD);
}

/// False if the first process wants no more.
bool deliver(const std::vector<char>& bytes) {
  if (bytes.size() > kMostBytes) throw std::runtime_error("the share of a recording is too large to send");
  MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_CHAR, 0, kShare, MPI_COMM_WORLD);
  int what = kEnough;
  MPI_Recv(&what, 1, MPI_INT, 0, kAnswer, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return what == kGoOn;
}

struct Enough {};

/// In another process than the first.
void serve(const World& world, const std::vector<fs::path>& recordings, const ShareWork& work) {
  try {
    in_order<DriveShare>(
        dealt_to(world.rank, world.processes, recordings.size()), work.jobs, work.stop,
        [&](std::size_t i, const std::stop_token& stop) {
          return share_of(recordings[i], work.refine, stop);
        },
        [](std::size_t, const DriveShare& share) {
          if (!deliver(encode(share))) throw Enough();
        });
  } catch (const Enough&) {
  } catch (...) {
    deliver({});  // which is no share; the first process then asks for nothing more
    throw;
  }
}

/// In the first process: its own shares made here, those of others received, all in order.
class Gathering {
 public:
  Gathering(const World& world, const std::vector<fs::path>& recordings,
            const std::function<void(std::size_t, DriveShare)>& take)
      : world_(world), recordings_(recordings), take_(take) {}

  void run(const ShareWork& work) {
    try {
      in_order<DriveShare>(
          dealt_to(0, world_.processes, recordings_.size()), work.jobs, work.stop,
          [&](std::size_t i, const std::stop_token& stop) {
            return share_of(recordings_[i], work.refine, stop);
          },
          [&](std::size_t i, DriveShare share) {
            take_(i, std::move(share));
            take_of_others(i + 1);
          });
    } catch (...) {
      dismiss();
      throw;
    }
  }

 private:
  int owner(std::size_t which) const {
    return static_cast<int>(which % static_cast<std::size_t>(world_.processes));
  }

  void take_of_others(std::size_t first) {
    for (next_ = first; next_ < recordings_.size() && owner(next_) != 0; ++next_) {
      std::optional<DriveShare> share = receive(owner(next_));
      answered_ = false;
      if (!share) throw std::runtime_error(recordings_[next_].string() + ": could not be read elsewhere");
      take_(next_, std::move(*share));
      answer(owner(next_), kGoOn);
      answered_ = true;
    }
  }

  /// All others: their next share is their last.
  void dismiss() {
    for (int rank = 1; rank < world_.processes; ++rank) {
      if (!answered_ && rank == owner(next_)) {
        answer(rank, kEnough);
        continue;
      }
      std::size_t of_rank = next_;
      while (of_rank < recordings_.size() && owner(of_rank) != rank) ++of_rank;
      if (of_rank >= recordings_.size()) continue;  // it has delivered all
      receive(rank);
      answer(rank, kEnough);
    }
  }

  const World& world_;
  const std::vector<fs::path>& recordings_;
  const std::function<void(std::size_t, DriveShare)>& take_;
  std::size_t next_ = 0;  ///< not yet received, if it is another's
  bool answered_ = true;  ///< the process that sent the newest share
};

}  // namespace

void share_on_cluster(const std::vector<fs::path>& recordings, const ShareWork& work,
                      const std::function<void(std::size_t which, DriveShare share)>& take) {
  const World world;
  const std::vector<fs::path> all = announce(recordings);
  if (world.rank != 0) return serve(world, all, work);
  Gathering(world, all, take).run(work);
}

}  // namespace roadbalance
