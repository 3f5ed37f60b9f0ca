#include <algorithm>
#include <string>

#include "hil_tests/deterministic/world.hpp"

namespace roadbalance::test {
namespace {

constexpr std::int64_t kLook_ns = 20'000'000;
// What nodes hold that nobody knows of is found while nothing is recorded.
constexpr std::int64_t kQuiet_ns = 5'000'000'000;

/// It says that this node may measure by another vehicle.toml.
bool names(const Answer& answer, std::int32_t node) {
  const std::string number = std::to_string(node);
  if (answer.text.find("node " + number + " may keep the new set-up") != std::string::npos) return true;
  const std::string absent = "not on the bus: node ";
  const auto at = answer.text.find(absent);
  return at != std::string::npos && answer.text.find(number, at + absent.size()) != std::string::npos;
}

}  // namespace

void World::turn_asker(std::size_t which) {
  HostMachine& host = *hosts_.front().machine;
  const bool records = host.is_up() && host.has_work();
  if (const auto request =
          askers_[which].turn(now_ns_, stopped_, which == 0 && records, host.unsure_deaths()))
    network_.from_asker(kRequestChannel, encode(*request), now_ns_);
  if (records || !host.is_up()) quiet_since_ns_ = now_ns_;
  if (stopped_ && now_ns_ - quiet_since_ns_ >= kQuiet_ns &&
      std::ranges::none_of(askers_, [](const Asker& asker) { return asker.waits(); }))
    host.stop();
  if (!host.closed()) events_.add(now_ns_ + kLook_ns, Event::Kind::kAsker, which);
}

void World::take_answer(const Event& event) {
  if (const auto answer = decode_answer(network_.datagrams().bytes(event.what)))
    for (Asker& asker : askers_) asker.take(*answer, hosts_.front().machine->unsure_deaths());
  network_.datagrams().release(event.what);
}

bool World::was_named(std::int32_t node) const {
  return std::ranges::any_of(askers_, [&](const Asker& asker) {
    return std::ranges::any_of(
        asker.asked(), [&](const Asker::Asked& asked) { return asked.answer && names(*asked.answer, node); });
  });
}

// All nodes measure by the file that the recorder leads, but for those that it names.
void World::check_set_up() {
  if (!scenario_.is_operated()) return;
  const std::uint32_t file = hosts_.front().machine->vehicle_crc32c();
  for (const Node& node : nodes_)
    if (const auto crc = node.machine->changed_vehicle();
        crc && *crc != file && !was_named(node.machine->number()))
      truth_.fault("node " + std::to_string(node.machine->number()) +
                   " measures by another vehicle.toml than the recorder's, and nobody was told");
}

}  // namespace roadbalance::test
