#pragma once

#include <cstdint>
#include <span>

namespace roadbalance::fuzz {

/// How often each edge of our code was passed by the input at hand, up to 255.  The fuzzer clears them before
/// an input and reads them behind it.
std::span<std::uint8_t> edge_counters();

}  // namespace roadbalance::fuzz
