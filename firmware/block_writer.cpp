#include "firmware/block_writer.hpp"

namespace roadbalance {

BlockWriter::BlockWriter(int node, std::int64_t epoch, const std::string& description, BlockSink& sink)
    : node_(node),
      epoch_(epoch),
      sink_(sink),
      description_(split_text(MetaKind::kVehicleToml, description)) {}

bool BlockWriter::write_description(NodeTime now) noexcept {
  for (; parts_written_ < description_.size(); ++parts_written_) {
    MetaBlock& part = description_[parts_written_];
    part.header = header(0, 0, to_ns(now));
    if (!write(part)) return false;
  }
  return true;
}

}  // namespace roadbalance
