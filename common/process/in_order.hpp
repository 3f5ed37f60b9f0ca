#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

#include "common/process/channel.hpp"
#include "common/process/parallel.hpp"

namespace roadbalance {

/// Does pieces of work side by side and takes their results in their order, whichever is done first.  Work is
/// dealt out in turn, and no worker is more than two results ahead: memory is bounded by `jobs`.
///
/// @param pieces  given to `work` one by one
/// @param jobs    at a time, > 0
/// @param stop    handed on to all work
/// @param work    Result(Piece, std::stop_token), in threads of their own
/// @param take    void(Piece, Result), in this one
/// @throws what the first failing work or `take` throws; work under way is asked to stop and waited for
template <typename Result, typename Piece, typename Work, typename Take>
void in_order(const std::vector<Piece>& pieces, std::size_t jobs, const std::stop_token& stop,
              const Work& work, const Take& take) {
  jobs = std::min(jobs, pieces.size());
  Parallel workers;
  std::vector<In<Result>> results;
  for (std::size_t worker = 0; worker < jobs; ++worker) {
    auto [out, in] = make_channel<Result>(1);
    results.push_back(std::move(in));
    workers.run(
        [&pieces, &work, worker, jobs](std::stop_token asked_to_stop, Out<Result> to) {
          for (std::size_t i = worker; i < pieces.size(); i += jobs)
            if (!to.send(work(pieces[i], asked_to_stop))) return;
        },
        std::move(out));
  }
  const std::stop_callback forward(stop, [&workers] { workers.request_stop(); });
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    std::optional<Result> result = results[i % jobs].receive();
    if (!result) break;  // it failed: wait() throws why
    take(pieces[i], std::move(*result));
  }
  results.clear();
  workers.wait();
}

}  // namespace roadbalance
