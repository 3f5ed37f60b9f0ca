// Of a SimulatedDisk: what lies where, past faults and costs.
#include <algorithm>
#include <utility>

#include "common/record/test/simulated_disk.hpp"

namespace roadbalance::test {

// What lies at a place; the place's device becomes that of what is mounted there.
SimulatedDisk::Node SimulatedDisk::enter(Place& at) const {
  const auto mounted = mounted_.find(at.path);
  if (mounted == mounted_.end() || !mounted->second.is_there)
    return at.name.empty() ? root_ : at.folder->find(at.name);
  at.device = mounted->second.device;
  return mounted->second.root;
}

void SimulatedDisk::mount(const std::string& folder) {
  Mounted& mounted = mounted_[folder];
  if (!mounted.root) {
    mounted.device = ++last_device_;
    mounted.root = new_folder();
  }
  mounted.is_there = true;
}

void SimulatedDisk::plug_in(const std::string& folder) {
  Mounted& mounted = mounted_.at(folder);
  mounted = {.root = copy_of(*mounted.root, used_bytes_), .device = ++last_device_, .is_there = true};
}

void SimulatedDisk::replace(const std::string& folder) {
  Mounted& mounted = mounted_.at(folder);
  for (const auto& [file, open] : descriptors_)
    if (open.device == mounted.device) return plug_in(folder);
  pulled_out_.erase(mounted.device);
  mounted.root = new_folder();
  mounted.is_there = true;
}

void SimulatedDisk::pull_out(const std::string& folder) {
  Mounted& mounted = mounted_.at(folder);
  mounted.root->folder->lose_power(random_);
  mounted.is_there = false;
  pulled_out_.insert(mounted.device);
}

SimulatedDisk::Place SimulatedDisk::place(const std::string& path) const {
  Place result{.folder = root_->folder.get(), .name = {}, .path = {}};
  std::size_t at = 0;
  while (at < path.size()) {
    const std::size_t end = std::min(path.find('/', at), path.size());
    const std::string part = path.substr(at, end - at);
    at = end + 1;
    if (part.empty() || part == ".") continue;
    if (!result.name.empty()) {
      const Node inner = enter(result);
      if (!inner || !inner->folder) return {};
      result.folder = inner->folder.get();
    }
    result.name = part;
    result.path += "/" + part;
  }
  return result;
}

SimulatedDisk::Node SimulatedDisk::find(const std::string& path) const {
  Place at = place(path);
  return at.folder ? enter(at) : nullptr;
}

std::vector<std::uint8_t> SimulatedDisk::content(const std::string& path) const {
  const Node node = find(path);
  if (!node || !node->file) return {};
  std::vector<std::uint8_t> bytes(node->file->size());
  node->file->read(0, bytes);
  return bytes;
}

void SimulatedDisk::put(const std::string& path, const std::vector<std::uint8_t>& bytes) {
  const Place at = place(path);
  auto node = std::make_shared<SimulatedNode>();
  node->file = std::make_unique<SimulatedFile>(used_bytes_);
  node->file->write(0, bytes);
  node->file->sync();
  at.folder->add(at.name, std::move(node));
  at.folder->sync();
}

void SimulatedDisk::flip_bit(const std::string& path, std::uint64_t bit) {
  find(path)->file->damage(bit / 8, static_cast<std::uint8_t>(1u << bit % 8));
}

}  // namespace roadbalance::test
