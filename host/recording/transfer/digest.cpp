#include "host/recording/transfer/digest.hpp"

#include <openssl/evp.h>

#include <stdexcept>

namespace roadbalance {
namespace {

void expect(int done, const char* call) {
  if (done != 1) throw std::runtime_error(std::string("SHA-256 of libcrypto: ") + call + " failed");
}

}  // namespace

std::string hexadecimal(const Digest& digest) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : digest) (text += kDigits[byte >> 4]) += kDigits[byte & 15];
  return text;
}

struct DigestOfBytes::State {
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context{EVP_MD_CTX_new(), &EVP_MD_CTX_free};
};

DigestOfBytes::DigestOfBytes() : state_(std::make_unique<State>()) {
  expect(state_->context ? EVP_DigestInit_ex(state_->context.get(), EVP_sha256(), nullptr) : 0, "init");
}

DigestOfBytes::~DigestOfBytes() = default;

void DigestOfBytes::add(std::span<const std::uint8_t> bytes) {
  expect(EVP_DigestUpdate(state_->context.get(), bytes.data(), bytes.size()), "update");
}

Digest DigestOfBytes::end() {
  Digest digest{};
  unsigned size = 0;
  expect(EVP_DigestFinal_ex(state_->context.get(), digest.data(), &size), "final");
  return digest;
}

}  // namespace roadbalance
