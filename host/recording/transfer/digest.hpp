#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace roadbalance {

/// SHA-256, FIPS 180-4.
using Digest = std::array<std::uint8_t, 32>;

/// As sha256sum prints it.
std::string hexadecimal(const Digest& digest);

/// The digest of bytes that come piece by piece.
class DigestOfBytes {
 public:
  DigestOfBytes();
  ~DigestOfBytes();
  DigestOfBytes(const DigestOfBytes&) = delete;
  DigestOfBytes& operator=(const DigestOfBytes&) = delete;

  void add(std::span<const std::uint8_t> bytes);
  /// The digest of all of them; nothing can be added afterwards.
  Digest end();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roadbalance
