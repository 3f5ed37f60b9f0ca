#pragma once

namespace roadbalance::board::arm {

/// What a program for the bare processor does, instead of main(); returns its exit code.
int program();

}  // namespace roadbalance::board::arm
