#include "firmware/node.hpp"

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <stdexcept>

#include "common/config/section.hpp"
#include "common/process/parallel.hpp"
#include "firmware/acquire.hpp"
#include "firmware/pack.hpp"
#include "firmware/ring_sink.hpp"
#include "firmware/uplink.hpp"

namespace roadbalance {

namespace {

std::int64_t random_epoch() {
  std::random_device device;
  std::uniform_int_distribution<std::int64_t> positive(1, std::numeric_limits<std::int64_t>::max());
  return positive(device);
}

}  // namespace

void run_node(std::stop_token stop, const VehicleConfig& vehicle, const NodeConfig& node, FrontEnd& front_end,
              const NodeOptions& options) {
  const std::int64_t epoch = random_epoch();
  Ring ring(options.ring_bytes);
  RingSink sink(ring);
  const auto preview = std::make_unique<PreviewSlot>();
  AcquireLink link;
  Sealer sealer(vehicle, node, epoch, sink, preview.get());
  const std::size_t least = 2 * sealer.most_blocks(kScansPerRead, kEdgesPerRead);
  if (static_cast<std::size_t>(ring.capacity()) < least)
    throw ConfigError("ring of " + std::to_string(options.ring_bytes) + " bytes: node " + node.name +
                      " needs at least " + std::to_string(least * sizeof(SealedBlock)));

  Parallel processes;
  const std::stop_callback pass_on(stop, [&processes] { processes.request_stop(); });
  processes.run(uplink, options.bus_url, node.id, epoch, std::ref(ring), std::ref(*preview), std::ref(link));
  processes.run(acquire, std::ref(front_end), std::ref(sealer), std::ref(sink), std::ref(link));
  processes.wait();
  if (link.state.load() == NodeState::kFailed)
    throw std::runtime_error("front end of node " + node.name + " failed");
}

}  // namespace roadbalance
