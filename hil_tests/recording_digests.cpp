#include "hil_tests/recording_digests.hpp"

#include <array>
#include <cstdio>
#include <memory>
#include <stdexcept>

namespace roadbalance::test {

std::map<std::string, std::string> digests_of(const std::filesystem::path& folder, const std::string& but) {
  const std::string command = "cd '" + folder.string() + "' && sha256sum -- *";
  const auto close = [](FILE* pipe) { pclose(pipe); };
  const std::unique_ptr<FILE, decltype(close)> pipe(popen(command.c_str(), "r"), close);
  if (!pipe) throw std::runtime_error("sha256sum in " + folder.string() + " cannot be started");
  std::map<std::string, std::string> digests;
  std::array<char, 4096> line{};
  constexpr std::size_t kDigits = 64;
  while (fgets(line.data(), line.size(), pipe.get()) != nullptr) {
    std::string text(line.data());
    if (text.size() < kDigits + 4) throw std::runtime_error("sha256sum says " + text);
    text.pop_back();
    if (const std::string name = text.substr(kDigits + 2); name != but)
      digests[name] = text.substr(0, kDigits);
  }
  if (digests.empty()) throw std::runtime_error(folder.string() + ": nothing in it");
  return digests;
}

}  // namespace roadbalance::test
