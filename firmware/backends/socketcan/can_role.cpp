#include "firmware/backends/socketcan/can_link.hpp"

namespace roadbalance {

bool suits(const CanLink& link, CanRole role) {
  if (link.kind == CanLink::Kind::kVirtual) return true;
  return link.kind == CanLink::Kind::kController && link.listen_only == (role == CanRole::kVehicle);
}

std::string obstacle(const std::optional<CanLink>& link, CanNeed need, const std::string& interface) {
  const std::string name = "CAN interface " + interface;
  if (!link) return name + ": there is none of that name; try: ip link show type can";
  if (link->kind == CanLink::Kind::kOther) return name + ": this is no CAN interface";
  if (!suits(*link, need.role)) {
    const bool vehicle = need.role == CanRole::kVehicle;
    return name +
           (vehicle ? " is not listen-only, as role \"vehicle\" demands: it would answer on the car's own bus"
                    : " is listen-only, but role \"sensor\" demands that it acknowledges frames") +
           "; try: ip link set " + interface + " down; ip link set " + interface + " type can listen-only " +
           (vehicle ? "on" : "off") + "; ip link set " + interface + " up";
  }
  if (need.fd && !link->takes_fd) {
    const std::string fd =
        link->kind == CanLink::Kind::kVirtual ? " mtu 72" : " type can bitrate 500000 dbitrate 2000000 fd on";
    return name + " carries no CAN FD, but a message wanted of it has more than 8 bytes; try: ip link set " +
           interface + " down; ip link set " + interface + fd + "; ip link set " + interface + " up";
  }
  if (!link->up) return name + " is down; try: ip link set " + interface + " up";
  return "";
}

}  // namespace roadbalance
