#include "firmware/backends/usb/usb_device.hpp"

#include <libusb-1.0/libusb.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/types/clocks.hpp"
#include "firmware/backends/usb/usb_address.hpp"
#include "firmware/board/packet.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

bool has_open(const fs::path& process, const std::string& path) {
  std::error_code error;
  for (fs::directory_iterator file(process / "fd", error), end; !error && file != end;
       file.increment(error)) {
    std::error_code closed;  // since it was listed
    if (fs::read_symlink(file->path(), closed) == path) return true;
  }
  return false;
}

/// Processes that have a device file open, for people: "rb-node (process 812)".  Other users' processes show
/// only to root.
std::string device_holder(const std::string& path) {
  std::string holders;
  std::error_code error;
  for (fs::directory_iterator process("/proc", error), end; !error && process != end;
       process.increment(error)) {
    const std::string id = process->path().filename();
    if (id.find_first_not_of("0123456789") != std::string::npos || !has_open(process->path(), path)) continue;
    // We have opened it, too, in order to ask.
    if (id == std::to_string(::getpid())) continue;
    std::string name;
    std::getline(std::ifstream(process->path() / "comm"), name);
    holders += (holders.empty() ? "" : ", ") + name + " (process " + id + ")";
  }
  return holders.empty() ? "this process or one that only root may look at" : holders;
}

constexpr int kInterface = 0;
constexpr unsigned kControlTimeout_ms = 500;
constexpr auto kAfterFailure = std::chrono::milliseconds(10);
/// At the board's 5 ms a packet 80 ms during which this machine need not serve them.
constexpr std::size_t kTransfers = 16;
/// After that the kernel keeps cancelled transfers for ever; they are left to it.
constexpr auto kLongestCancelling = std::chrono::seconds(2);

std::string reason(int code) {
  return libusb_strerror(code);
}

std::string udev_rule(std::uint16_t vendor, std::uint16_t product) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                "SUBSYSTEM==\"usb\", ATTR{idVendor}==\"%04x\", ATTR{idProduct}==\"%04x\", MODE=\"0660\", "
                "GROUP=\"plugdev\", TAG+=\"uaccess\"",
                vendor, product);
  return text.data();
}

std::string node_of(libusb_device* device) {
  std::array<char, 32> path{};
  std::snprintf(path.data(), path.size(), "/dev/bus/usb/%03d/%03d", libusb_get_bus_number(device),
                libusb_get_device_address(device));
  return path.data();
}

std::string serial_of(libusb_device_handle* handle, std::uint8_t index) {
  std::array<unsigned char, 64> text{};
  const int size = index == 0 ? 0
                              : libusb_get_string_descriptor_ascii(handle, index, text.data(),
                                                                   static_cast<int>(text.size()));
  return size > 0 ? std::string(text.begin(), text.begin() + size) : std::string();
}

struct Close {
  void operator()(libusb_device_handle* handle) const { libusb_close(handle); }
};
using Handle = std::unique_ptr<libusb_device_handle, Close>;

/// The devices there are, as long as it lives.
class DeviceList {
 public:
  explicit DeviceList(libusb_context* context) : count_(libusb_get_device_list(context, &list_)) {
    if (count_ < 0) throw UsbError("list USB devices: " + reason(static_cast<int>(count_)));
  }
  DeviceList(const DeviceList&) = delete;
  DeviceList& operator=(const DeviceList&) = delete;
  ~DeviceList() { libusb_free_device_list(list_, 1); }

  std::span<libusb_device* const> devices() const { return {list_, static_cast<std::size_t>(count_)}; }
  std::string names() const {
    std::string all;
    for (libusb_device* device : devices()) {
      libusb_device_descriptor descriptor{};
      libusb_get_device_descriptor(device, &descriptor);
      all += (all.empty() ? "" : ", ") + usb_name(descriptor.idVendor, descriptor.idProduct);
    }
    return all.empty() ? "no USB device at all" : all;
  }

 private:
  libusb_device** list_ = nullptr;
  ssize_t count_;
};

/// A device of the kind that is looked for.
struct Found {
  Handle handle;
  std::string serial;
};

Found open_listed(libusb_device* device, const libusb_device_descriptor& descriptor) {
  libusb_device_handle* handle = nullptr;
  const int code = libusb_open(device, &handle);
  if (code == LIBUSB_ERROR_ACCESS)
    throw UsbError("no permission for " + node_of(device) + "; mended by a file " +
                   "/etc/udev/rules.d/60-roadbalance.rules with: " +
                   udev_rule(descriptor.idVendor, descriptor.idProduct));
  if (code != 0) throw UsbError("open " + node_of(device) + ": " + reason(code));
  Found found{Handle(handle), {}};
  found.serial = serial_of(handle, descriptor.iSerialNumber);
  return found;
}

Found find(libusb_context* context, std::uint16_t vendor, std::uint16_t product, const std::string& serial) {
  const DeviceList list(context);
  std::vector<Found> found;
  std::string all;  // of that kind, by their serial numbers
  for (libusb_device* device : list.devices()) {
    libusb_device_descriptor descriptor{};
    libusb_get_device_descriptor(device, &descriptor);
    if (descriptor.idVendor != vendor || descriptor.idProduct != product) continue;
    found.push_back(open_listed(device, descriptor));
    const std::string& its = found.back().serial;
    all += (all.empty() ? "" : ", ") + (its.empty() ? "one without" : its);
    if (!serial.empty() && its != serial) found.pop_back();
  }
  if (found.size() == 1) return std::move(found.front());
  const std::string kind = usb_name(vendor, product);
  if (found.size() > 1)
    throw UsbError(std::to_string(found.size()) + " devices " + kind +
                   " are plugged in; the address must say which by its serial number: " + all);
  throw UsbError(all.empty() ? "no device " + kind + " is plugged in; there is: " + list.names()
                             : "no device " + kind + " has this serial number; there is: " + all);
}

}  // namespace

struct UsbBus::State {
  libusb_context* context = nullptr;
};

UsbBus::UsbBus() : state_(std::make_unique<State>()) {
  if (const int code = libusb_init(&state_->context); code != 0)
    throw UsbError("USB of this machine: " + reason(code));
}

UsbBus::~UsbBus() {
  libusb_exit(state_->context);
}

void UsbBus::serve(std::chrono::milliseconds at_most) {
  timeval time{.tv_sec = at_most.count() / 1000, .tv_usec = at_most.count() % 1000 * 1000};
  // A call that fails at once would otherwise fail again and again, at a real-time priority.
  if (libusb_handle_events_timeout_completed(state_->context, &time, nullptr) != 0)
    std::this_thread::sleep_for(kAfterFailure);
}

struct UsbDevice::State {
  struct Transfer {
    libusb_transfer* transfer = nullptr;
    std::array<std::uint8_t, board::kTransferBytes> bytes{};
    bool in_flight = false;
  };

  UsbBus* bus;
  libusb_device_handle* handle = nullptr;
  std::function<void(std::span<const std::uint8_t>)> received;
  DeviceReport* report = nullptr;
  std::vector<Transfer> transfer;
  std::size_t in_flight = 0;
  bool halted = false, gone = false, closing = false;

  static void LIBUSB_CALL complete(libusb_transfer* transfer) {
    auto* const self = static_cast<State*>(transfer->user_data);
    for (Transfer& mine : self->transfer)
      if (mine.transfer == transfer) self->completed(mine);
  }

  void completed(Transfer& mine) {
    mine.in_flight = false;
    --in_flight;
    switch (mine.transfer->status) {
      case LIBUSB_TRANSFER_COMPLETED:
        if (!closing) received({mine.bytes.data(), static_cast<std::size_t>(mine.transfer->actual_length)});
        break;
      case LIBUSB_TRANSFER_STALL:  // comes once for each transfer in flight
        if (!halted) report->count(DeviceCounter::kStalls);
        halted = true;
        break;
      case LIBUSB_TRANSFER_OVERFLOW:
        report->count(DeviceCounter::kPacketsRefused);
        break;
      default:  // the content of a failed transfer is no data, whatever its length
        gone = true;
    }
    if (!halted) submit(mine);
  }

  void submit(Transfer& mine) {
    if (gone || closing) return;
    if (libusb_submit_transfer(mine.transfer) != 0) {
      gone = true;
      return;
    }
    mine.in_flight = true;
    ++in_flight;
  }

  /// False: the kernel has not given all of them back.
  bool take_back() {
    closing = true;
    for (Transfer& mine : transfer)
      if (mine.in_flight) libusb_cancel_transfer(mine.transfer);
    const auto until = WallClock::now() + kLongestCancelling;
    while (in_flight > 0 && WallClock::now() < until) bus->serve(std::chrono::milliseconds(10));
    return in_flight == 0;
  }
};

UsbDevice::UsbDevice(UsbBus& bus, std::uint16_t vendor, std::uint16_t product, const std::string& serial)
    : state_(std::make_unique<State>()) {
  Found found = find(bus.state_->context, vendor, product, serial);
  const std::string node = node_of(libusb_get_device(found.handle.get()));
  if (const int code = libusb_claim_interface(found.handle.get(), kInterface); code == LIBUSB_ERROR_BUSY)
    throw UsbError(node + " is in use by " + device_holder(node));
  else if (code != 0)
    throw UsbError("claim " + node + ": " + reason(code));
  state_->bus = &bus;
  state_->handle = found.handle.release();
}

UsbDevice::~UsbDevice() {
  if (!state_->take_back()) {
    static_cast<void>(state_.release());  // the kernel may still write there
    return;
  }
  for (auto& mine : state_->transfer) libusb_free_transfer(mine.transfer);
  libusb_release_interface(state_->handle, kInterface);
  libusb_close(state_->handle);
}

bool UsbDevice::gone() const {
  return state_->gone;
}

bool UsbDevice::put(std::uint8_t request, std::span<const std::uint8_t> data) {
  // libusb's parameter is not const, but it only reads.
  const int sent = libusb_control_transfer(state_->handle, board::kVendorOut, request, 0, 0,
                                           const_cast<std::uint8_t*>(data.data()),
                                           static_cast<std::uint16_t>(data.size()), kControlTimeout_ms);
  if (sent == LIBUSB_ERROR_PIPE) return false;
  if (sent < 0) throw UsbError("request " + std::to_string(request) + ": " + reason(sent));
  return true;
}

std::optional<std::size_t> UsbDevice::get(std::uint8_t request, std::span<std::uint8_t> reply) {
  const int size = libusb_control_transfer(state_->handle, board::kVendorIn, request, 0, 0, reply.data(),
                                           static_cast<std::uint16_t>(reply.size()), kControlTimeout_ms);
  if (size == LIBUSB_ERROR_PIPE) return std::nullopt;
  if (size < 0) throw UsbError("request " + std::to_string(request) + ": " + reason(size));
  return static_cast<std::size_t>(size);
}

void UsbDevice::stream(std::function<void(std::span<const std::uint8_t>)> received, DeviceReport& report) {
  state_->received = std::move(received);
  state_->report = &report;
  state_->transfer.resize(kTransfers);
  for (auto& mine : state_->transfer) {
    mine.transfer = libusb_alloc_transfer(0);
    if (!mine.transfer) throw UsbError("no memory for transfers");
    libusb_fill_bulk_transfer(mine.transfer, state_->handle, board::kBulkIn, mine.bytes.data(),
                              static_cast<int>(mine.bytes.size()), State::complete, state_.get(), 0);
  }
  for (auto& mine : state_->transfer) state_->submit(mine);
  if (state_->gone) throw UsbError("the system takes no transfers");
}

void UsbDevice::maintain() {
  if (!state_->halted || state_->in_flight > 0 || state_->gone) return;
  // While a transfer is in flight clearing would let it run on a pipe that the host thinks halted.
  if (libusb_clear_halt(state_->handle, board::kBulkIn) != 0) {
    state_->gone = true;
    return;
  }
  state_->halted = false;
  for (auto& mine : state_->transfer) state_->submit(mine);
}

}  // namespace roadbalance
