#include "host/recorder/recorder.hpp"

#include <functional>
#include <utility>

#include "common/process/parallel.hpp"
#include "host/recorder/receive.hpp"
#include "host/recorder/write.hpp"

namespace roadbalance {
namespace {
// Credit bounds what is under way to a few thousand blocks a node, so these are never full.
constexpr std::size_t kDeliveryBatches = 65'536;
constexpr std::size_t kDurableBatches = 64;
}  // namespace

RecorderReport run_recorder(std::stop_token stop, const RecorderOptions& options) {
  RecordKeeper keeper(kernel_disk(), {.folder = options.folder,
                                      .segment_bytes = options.segment_bytes,
                                      .commit_period = options.commit_period});
  if (keeper.cut_tail() && options.on_cut_tail) options.on_cut_tail(*keeper.cut_tail());

  auto [deliveries_out, deliveries_in] = make_channel<std::vector<Delivery>>(kDeliveryBatches);
  auto [durable_out, durable_in] = make_channel<std::vector<DurableMark>>(kDurableBatches);
  RecorderReport report;

  Parallel recorder;
  const std::stop_callback pass_on(stop, [&recorder] { recorder.request_stop(); });
  recorder.run(write_record, std::ref(keeper), std::move(deliveries_in), std::move(durable_out));
  recorder.run(receive, std::cref(options), std::cref(keeper.recovered()), std::move(deliveries_out),
               std::move(durable_in), std::ref(report));
  recorder.wait();
  return report;
}

}  // namespace roadbalance
