#include "common/bus/types.hpp"

#include <wire/edge_block_t.hpp>
#include <wire/end_t.hpp>
#include <wire/gap_t.hpp>
#include <wire/meta_t.hpp>
#include <wire/scan_block_t.hpp>
#include <wire/signal_block_t.hpp>

#include "common/bus/wire_format.hpp"

namespace roadbalance {
namespace {

template <typename Message>
BlockType type_of() {
  return {.name = std::string("wire.") + Message::getTypeName(),
          .fingerprint = Message::getHash(),
          .bytes = wire_format::size_of<Message>()};
}

}  // namespace

std::vector<BlockType> block_types() {
  return {type_of<wire::scan_block_t>(), type_of<wire::edge_block_t>(), type_of<wire::gap_t>(),
          type_of<wire::meta_t>(),       type_of<wire::end_t>(),        type_of<wire::signal_block_t>()};
}

}  // namespace roadbalance
