#pragma once

namespace roadbalance::board::arm {

/// The program for the bare processor, instead of main(); returns its exit code.
int program();

}  // namespace roadbalance::board::arm
