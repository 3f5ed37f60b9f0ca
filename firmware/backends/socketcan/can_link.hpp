#pragma once

#include <array>
#include <optional>
#include <string>

#include "common/config/node_wiring.hpp"

namespace roadbalance {

/// A network interface as the kernel describes it.
struct CanLink {
  enum class Kind {
    kController,  ///< has a CAN controller, which acknowledges frames unless it is listen-only
    kVirtual,     ///< vcan, vxcan: has none, so that nothing of ours can reach a bus
    kOther,       ///< no CAN interface
  };
  Kind kind = Kind::kOther;
  bool up = false;
  bool listen_only = false;
  bool takes_fd = false;  ///< takes CAN FD frames
};

/// Nothing if there is no interface of that name.  Never allocates.
std::optional<CanLink> query_can_link(const char* interface) noexcept;

/// True if the interface may be used so: role vehicle needs a controller that is listen-only, role sensor one
/// that is not; one without a controller goes with both.
bool suits(const CanLink& link, CanRole role);

/// The demands on an interface.
struct CanNeed {
  CanRole role = CanRole::kVehicle;
  bool fd = false;  ///< it must take CAN FD frames
};

/// Why the interface cannot be used so, with the command that mends it; empty if it can.
std::string refusal(const std::optional<CanLink>& link, CanNeed need, const std::string& interface);

}  // namespace roadbalance
