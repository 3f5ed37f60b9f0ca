#pragma once

#include <cstdint>

namespace roadbalance::board::arm {

/// Fills the free stack below the caller with a pattern.
void mark_stack();

/// How far below the place of mark_stack() the stack has reached since, in bytes.
std::uint32_t stack_used();

}  // namespace roadbalance::board::arm
