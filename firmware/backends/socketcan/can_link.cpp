#include "firmware/backends/socketcan/can_link.hpp"

#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_arp.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <string_view>

namespace roadbalance {
namespace {

constexpr std::size_t kFdMtu = 72;  // of struct canfd_frame: the MTU of CAN FD

const void* payload(const rtattr& part) {
  return reinterpret_cast<const char*>(&part) + RTA_LENGTH(0);
}

/// The attribute of `kind` among `size` bytes of them; null if there is none.
const rtattr* find(const rtattr* part, std::size_t size, unsigned kind) {
  auto left = static_cast<int>(size);
  for (; RTA_OK(part, left); part = RTA_NEXT(part, left))
    if ((part->rta_type & NLA_TYPE_MASK) == kind) return part;
  return nullptr;
}

const rtattr* find_inside(const rtattr* outer, unsigned kind) {
  if (!outer) return nullptr;
  return find(static_cast<const rtattr*>(payload(*outer)), RTA_PAYLOAD(outer), kind);
}

template <typename Value>
Value value_of(const rtattr* part) {
  Value value{};
  if (part && RTA_PAYLOAD(part) >= sizeof value) std::memcpy(&value, payload(*part), sizeof value);
  return value;
}

CanLink read_link(const nlmsghdr& answer) {
  const auto& head = *static_cast<const ifinfomsg*>(NLMSG_DATA(&answer));
  const auto* const first = IFLA_RTA(&head);
  const std::size_t size = answer.nlmsg_len - NLMSG_LENGTH(sizeof head);
  CanLink link{.up = (head.ifi_flags & IFF_UP) != 0};
  if (head.ifi_type != ARPHRD_CAN) return link;
  link.takes_fd = value_of<std::uint32_t>(find(first, size, IFLA_MTU)) >= kFdMtu;
  const rtattr* const info = find(first, size, IFLA_LINKINFO);
  const rtattr* const kind = find_inside(info, IFLA_INFO_KIND);
  // The kind is text with or without a closing 0.
  const std::string_view name =
      kind ? std::string_view(static_cast<const char*>(payload(*kind)),
                              ::strnlen(static_cast<const char*>(payload(*kind)), RTA_PAYLOAD(kind)))
           : std::string_view();
  if (name == "vcan" || name == "vxcan") link.kind = CanLink::Kind::kVirtual;
  if (name == "can") link.kind = CanLink::Kind::kController;
  const rtattr* const mode = find_inside(find_inside(info, IFLA_INFO_DATA), IFLA_CAN_CTRLMODE);
  link.listen_only = (value_of<can_ctrlmode>(mode).flags & CAN_CTRLMODE_LISTENONLY) != 0;
  return link;
}

/// Asks for one interface by its name; false if the kernel does not take the question.
bool ask(int netlink, const char* interface) {
  struct {
    nlmsghdr head{};
    ifinfomsg link{};
    alignas(4) std::array<char, RTA_SPACE(IFNAMSIZ)> name{};
  } question;
  const std::size_t length = std::strlen(interface) + 1;
  if (length > IFNAMSIZ) return false;
  question.head.nlmsg_type = RTM_GETLINK;
  question.head.nlmsg_flags = NLM_F_REQUEST;
  question.head.nlmsg_len =
      static_cast<std::uint32_t>(NLMSG_LENGTH(sizeof question.link) + RTA_SPACE(length));
  rtattr name{.rta_len = static_cast<std::uint16_t>(RTA_LENGTH(length)), .rta_type = IFLA_IFNAME};
  std::memcpy(question.name.data(), &name, sizeof name);
  std::memcpy(question.name.data() + RTA_LENGTH(0), interface, length);
  return ::send(netlink, &question, question.head.nlmsg_len, 0) ==
         static_cast<ssize_t>(question.head.nlmsg_len);
}

}  // namespace

std::optional<CanLink> query_can_link(const char* interface) noexcept {
  const int netlink = ::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
  if (netlink < 0) return std::nullopt;
  alignas(nlmsghdr) std::array<char, 32'768> room;
  const ssize_t size = ask(netlink, interface) ? ::recv(netlink, room.data(), room.size(), 0) : -1;
  ::close(netlink);
  nlmsghdr answer;
  if (size < static_cast<ssize_t>(NLMSG_LENGTH(sizeof(ifinfomsg)))) return std::nullopt;
  std::memcpy(&answer, room.data(), sizeof answer);
  if (answer.nlmsg_type != RTM_NEWLINK || answer.nlmsg_len > static_cast<std::size_t>(size))
    return std::nullopt;
  return read_link(*reinterpret_cast<const nlmsghdr*>(room.data()));
}

bool suits(const CanLink& link, CanRole role) {
  if (link.kind == CanLink::Kind::kVirtual) return true;
  return link.kind == CanLink::Kind::kController && link.listen_only == (role == CanRole::kVehicle);
}

std::string refusal(const std::optional<CanLink>& link, CanNeed need, const std::string& interface) {
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
